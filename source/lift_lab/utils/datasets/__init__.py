"""Recorded episodes, and files of them."""

from .dataset_file_handler_base import DatasetFileHandlerBase
from .episode_data import EpisodeData
from .hdf5_dataset_file_handler import HDF5DatasetFileHandler

__all__ = ["DatasetFileHandlerBase", "EpisodeData", "HDF5DatasetFileHandler"]

"""Arrays of the CPU engine's batch as float32 copies for the layers above, and frames without contacts."""

from __future__ import annotations

import copy

import mujoco
import numpy as np
import torch
from mujoco.batch import Batch

from .base import Stage

_NOT_FOR_FRAMES = int(
    mujoco.mjtDisableBit.mjDSBL_CONTACT
    | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    | mujoco.mjtDisableBit.mjDSBL_ACTUATION
    | mujoco.mjtDisableBit.mjDSBL_SENSOR
)
"""What the position and velocity stages can do without when only frames and their motion are wanted."""


class Frames:
    """Poses of bodies, geoms, joints and sites of a batch and how they move, without its contacts and forces.

    One more batch, of the same model with constraints, actuation and sensors disabled.

    Args:
        batch: the batch whose state is followed.
    """

    def __init__(self, batch: Batch):
        self._leader = batch
        self._batch: Batch | None = None  # made with the first field
        self._states: list[tuple[np.ndarray, np.ndarray]] = []
        self.stage = Stage.POS
        """What follow() computes."""

    def bind(self, name: str, stage: Stage) -> np.ndarray:
        """The live array of a field that needs a stage, current after follow()."""
        if self._batch is None:
            leader = self._leader
            model = copy.copy(leader.model)
            model.opt.disableflags |= _NOT_FOR_FRAMES
            self._batch = Batch(model, leader.nsim, leader.nthread)
            self._batch.warning[:, :, 1] = 1  # so that none is printed
            self._follow_states("qpos", "mocap_pos", "mocap_quat")
        if stage > self.stage:
            self.stage = stage
            self._follow_states("qvel")
        return self._batch.bind(name)

    def _follow_states(self, *names: str) -> None:
        pairs = [(self._batch.bind(name), self._leader.bind(name)) for name in names]  # type: ignore[union-attr]
        self._states += [(mine, leaders) for mine, leaders in pairs if leaders.size]

    def follow(self, ids: np.ndarray | None = None) -> None:
        """Compute the bound fields at the leader's state, of some environments or all."""
        if self._batch is None:
            return
        rows = slice(None) if ids is None else ids
        for mine, leaders in self._states:
            mine[rows] = leaders[rows]
        self._batch.forward(ids, stage=int(self.stage))


class Mirror:
    """The float32 copy of one of the batch's arrays.

    The copy is numpy's, on the calling thread: torch's would start its thread pool beside the batch's.
    """

    def __init__(self, source: np.ndarray, shape: tuple[int, ...], stage: Stage, column_stages: list[Stage] | None):
        num_envs, width = source.shape
        self.stage = stage
        self.tensor = torch.zeros(num_envs, *shape)
        self.array = self.tensor.numpy().reshape(num_envs, width)
        self.source = source
        self._column_stages = np.array([stage] * width if column_stages is None else column_stages, dtype=int)
        self._lowest = int(self._column_stages.min(initial=int(Stage.ACC)))
        self._highest = int(self._column_stages.max(initial=int(Stage.NONE)))

    def write(self, rows: slice | np.ndarray, columns: slice | np.ndarray, values: np.ndarray) -> None:
        """The values that were written into the source."""
        if values.dtype == np.float32:
            self.array[rows, columns] = values
            return
        with lossy():
            self.array[rows, columns] = values

    def copy_all(self) -> None:
        """Copy everything; overflows are the caller's to ignore."""
        np.copyto(self.array, self.source, casting="same_kind")

    def sync(self, stage: Stage, ids: np.ndarray | None = None) -> None:
        """Copy the columns that are current once `stage` has been computed, of some environments or all; overflows
        are the caller's to ignore."""
        if self._lowest > stage:
            return
        if self._highest > stage:
            rows = np.arange(len(self.array)) if ids is None else ids
            index = np.ix_(rows, np.flatnonzero(self._column_stages <= stage))
            self.array[index] = self.source[index]
        elif ids is None:
            self.copy_all()
        else:
            self.array[ids] = self.source[ids]

    def clear_forces(self, ids: np.ndarray | None) -> None:
        """Zero the force-dependent columns: they belonged to a state that is gone."""
        if self._highest == Stage.ACC:
            rows = np.arange(len(self.array)) if ids is None else ids
            self.array[np.ix_(rows, np.flatnonzero(self._column_stages == Stage.ACC))] = 0.0


def lossy() -> np.errstate:
    """While copies to float32 are made: a diverged value may exceed it."""
    return np.errstate(over="ignore")

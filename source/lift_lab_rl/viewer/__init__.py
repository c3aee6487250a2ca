"""Watching policies in a browser: a live page that steers, and a recorded page that plays by itself."""

from .policies import CheckpointPolicy, RandomPolicy, ViewedPolicy, ZeroPolicy
from .replay import record_replay
from .session import ViewerSession

__all__ = ["CheckpointPolicy", "RandomPolicy", "ViewedPolicy", "ViewerSession", "ZeroPolicy", "record_replay"]

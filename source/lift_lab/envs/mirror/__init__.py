"""Mirror images of a task's observations and actions, declared by term."""

from .check import check_mirror
from .mirror_cfg import MirrorCfg
from .task_mirror import TaskMirror

__all__ = ["MirrorCfg", "TaskMirror", "check_mirror"]

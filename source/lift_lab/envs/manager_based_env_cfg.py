"""Config of an environment without rewards and terminations."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from lift_lab.managers import EventTermCfg, RecorderManagerBaseCfg
from lift_lab.scene import InteractiveSceneCfg
from lift_lab.sim import SimulationCfg
from lift_lab.utils import MISSING, ConfigBase, configclass
from lift_lab.utils.ranges import COUNT_OR_ZERO, INT32_COUNT, SEED, Ranges

from . import mdp
from .common import ViewerCfg
from .mirror.mirror_cfg import MirrorCfg

__all__ = [
    "DefaultEventManagerCfg",
    "ManagerBasedEnvCfg",
]


@configclass
class DefaultEventManagerCfg(ConfigBase):
    """The events of an environment that names none."""

    reset_scene_to_default = EventTermCfg(func=mdp.reset_scene_to_default, mode="reset")


@configclass
class ManagerBasedEnvCfg(ConfigBase):
    """Config of :class:`ManagerBasedEnv`."""

    viewer: ViewerCfg = ViewerCfg()
    """Camera of rendered frames."""
    sim: SimulationCfg = SimulationCfg()
    """The simulation."""
    ui_window_class_type: type | None = None
    """Isaac Lab's window. Ignored: there is none."""
    seed: int | None = None
    """Seed of all random numbers; None leaves them unseeded, and runs differ."""
    decimation: int = MISSING
    """Physics steps in an environment step."""
    scene: Annotated[Any, InteractiveSceneCfg] = MISSING
    """The scene."""
    recorders: Annotated[Any, object] = RecorderManagerBaseCfg()
    """Recorder terms; by default nothing is recorded."""
    observations: Annotated[Any, object] = MISSING
    """Observation groups."""
    actions: Annotated[Any, object] = MISSING
    """Action terms."""
    events: Annotated[Any, object] = DefaultEventManagerCfg()
    """Event terms; by default a reset puts everything into its default state."""
    mirror: MirrorCfg | None = None
    """Mirror symmetry of the task, for mirrored samples and symmetric policies (ours); None for none."""
    rerender_on_reset: bool = False
    """Isaac Lab's switch for rendered sensors. Ignored: there are none."""
    num_rerenders_on_reset: int = 0
    """Isaac Lab's setting for rendered sensors. Ignored: there are none."""
    wait_for_textures: bool = True
    """Isaac Lab's switch for rendered sensors. Ignored: there are none."""
    xr: Any = None
    """Isaac Lab's XR device. Ignored: there is none."""
    teleop_devices: Any = None
    """Isaac Lab's teleoperation devices. Ignored: there are none."""
    export_io_descriptors: bool = False
    """Whether to write ``io_descriptors/IO_descriptors.yaml`` into ``log_dir``: inputs and outputs of the policy."""
    log_dir: str | None = None
    """Folder of the run's logs, for terms that write files; the training script sets it."""

    _ranges: ClassVar[Ranges] = {"seed": SEED, "decimation": INT32_COUNT, "num_rerenders_on_reset": COUNT_OR_ZERO}

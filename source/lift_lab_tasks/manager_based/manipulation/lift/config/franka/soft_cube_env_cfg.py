"""The lift task with a soft cube (the paper's section 4.1 speaks of a deformable one)."""

from __future__ import annotations

from lift_lab.assets import DeformableObjectCfg
from lift_lab.sim.spawners.from_files.from_files_cfg import UsdFileCfg
from lift_lab.utils import configclass
from lift_lab_assets.files import ASSETS_USD_DIR

from . import joint_pos_env_cfg
from .event_sets import SoftEventCfg


@configclass
class FrankaSoftCubeLiftEnvCfg(joint_pos_env_cfg.FrankaCubeLiftEnvCfg):
    """``Lift-Soft-Cube-Franka``: the baseline with a cube of soft rubber; its centre is to reach the goal."""

    events: SoftEventCfg = SoftEventCfg()

    def __post_init__(self):
        super().__post_init__()
        self.scene.object = DeformableObjectCfg(
            prim_path="{ENV_REGEX_NS}/Object",
            init_state=DeformableObjectCfg.InitialStateCfg(pos=(0.5, 0.0, 0.02)),
            spawn=UsdFileCfg(usd_path=str(ASSETS_USD_DIR / "soft_cube.usda")),
        )
        self.sim.mujoco.integrator = "discrete"
        self.sim.mujoco.warmstart = True  # not measured without


@configclass
class FrankaSoftCubeLiftEnvCfg_PLAY(FrankaSoftCubeLiftEnvCfg):
    """The task for watching: few environments, no observation noise."""

    def __post_init__(self):
        super().__post_init__()
        self.scene.num_envs = 50
        self.observations.policy.enable_corruption = False

"""Config of a deformable object."""

from __future__ import annotations

from lift_lab.utils import configclass

from ..asset_base_cfg import AssetBaseCfg
from .deformable_object import DeformableObject


@configclass
class DeformableObjectCfg(AssetBaseCfg):
    """A single soft body. Its scene needs ``sim.mujoco.integrator="discrete"``."""

    class_type: type = DeformableObject

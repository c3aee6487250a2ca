"""Mirror images of the terms of :mod:`lift_lab.envs.mdp`.

Each entry is a function ``(mirror, arguments or term)``. It returns a kind of :data:`~lift_lab.utils.mirror.KINDS` or a
map.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import torch

from lift_lab.assets.asset_base import as_list
from lift_lab.controllers import DifferentialIKControllerCfg
from lift_lab.envs import mdp
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.mirror import KINDS, MirrorMap, MirrorTermCfg, map_of_kind

if TYPE_CHECKING:
    from .task_mirror import TaskMirror

Kind = str | MirrorTermCfg | MirrorMap
"""A kind's name, a declaration number by number, or a map."""

# -- observations


def _is(kind: str) -> Callable[[TaskMirror, dict[str, Any]], Kind]:
    return lambda mirror, args: kind


def _same_everywhere(values: torch.Tensor, what: str) -> torch.Tensor:
    """The first row of a setting that has to be equal in all environments."""
    if not bool((values == values[:1]).all()):
        raise ConfigError(f"{what} differ between environments, so there is no one mirror image")
    return values[0].double().cpu()


def _joint_pos(mirror: TaskMirror, args: dict[str, Any]) -> MirrorMap:
    asset = args["asset_cfg"]
    return mirror.joints(asset.name).columns(asset.joint_ids)


def _joint_pos_rel(mirror: TaskMirror, args: dict[str, Any]) -> MirrorMap:
    asset = args["asset_cfg"]
    joints = mirror.joints(asset.name)
    default = _same_everywhere(joints.asset.data.default_joint_pos, f"the default joint positions of '{asset.name}'")
    return joints.columns(asset.joint_ids).in_units(1.0, default[asset.joint_ids])


def _joint_pos_limit_normalized(mirror: TaskMirror, args: dict[str, Any]) -> MirrorMap:
    asset = args["asset_cfg"]
    joints = mirror.joints(asset.name)
    limits = _same_everywhere(joints.asset.data.soft_joint_pos_limits, f"the joint limits of '{asset.name}'")
    low, high = limits[asset.joint_ids].unbind(-1)
    return joints.columns(asset.joint_ids).in_units(0.5 * (high - low), 0.5 * (high + low))


def _joint_vel(mirror: TaskMirror, args: dict[str, Any]) -> MirrorMap:
    asset = args["asset_cfg"]
    return mirror.joints(asset.name).columns(asset.joint_ids, moves=False)


def _joint_vel_rel(mirror: TaskMirror, args: dict[str, Any]) -> MirrorMap:
    asset = args["asset_cfg"]
    joints = mirror.joints(asset.name)
    default = _same_everywhere(joints.asset.data.default_joint_vel, f"the default joint velocities of '{asset.name}'")
    return joints.columns(asset.joint_ids, moves=False).in_units(1.0, default[asset.joint_ids])


def _bodies(kind: str) -> Callable[[TaskMirror, dict[str, Any]], Kind]:
    """Numbers of some bodies, one body after the other; bodies change places as joints do."""

    def of(mirror: TaskMirror, args: dict[str, Any]) -> MirrorMap:
        asset_cfg = args["asset_cfg"]
        asset = mirror.env.scene[asset_cfg.name]
        chosen = as_list(asset_cfg.body_ids, asset.num_bodies)
        one = MirrorMap.of(KINDS[kind])
        if asset_cfg.name not in mirror.cfg.assets:
            return MirrorMap.cat([one] * len(chosen))
        partners = mirror.joints(asset_cfg.name).partners([asset.body_names[i] for i in chosen])
        return one.of_parts(partners)

    return of


def _last_action(mirror: TaskMirror, args: dict[str, Any]) -> MirrorMap:
    name = args["action_name"]
    return mirror.actions() if name is None else mirror.action(name)


OBSERVATIONS: Mapping[Any, Callable[[TaskMirror, dict[str, Any]], Kind]] = {
    mdp.base_pos_z: _is("same"),
    mdp.base_lin_vel: _is("vector"),
    mdp.base_ang_vel: _is("pseudo_vector"),
    mdp.projected_gravity: _is("vector"),
    mdp.root_pos_w: _is("vector"),
    mdp.root_quat_w: _is("quaternion"),
    mdp.root_lin_vel_w: _is("vector"),
    mdp.root_ang_vel_w: _is("pseudo_vector"),
    mdp.body_pose_w: _bodies("pose"),
    mdp.body_projected_gravity_b: _bodies("vector"),
    mdp.joint_pos: _joint_pos,
    mdp.joint_pos_rel: _joint_pos_rel,
    mdp.joint_pos_limit_normalized: _joint_pos_limit_normalized,
    mdp.joint_vel: _joint_vel,
    mdp.joint_vel_rel: _joint_vel_rel,
    mdp.joint_effort: _joint_vel,
    mdp.imu_orientation: _is("quaternion"),
    mdp.imu_projected_gravity: _is("vector"),
    mdp.imu_ang_vel: _is("pseudo_vector"),
    mdp.imu_lin_acc: _is("vector"),
    mdp.last_action: _last_action,
    mdp.generated_commands: lambda mirror, args: mirror.command(args["command_name"]),
    mdp.current_time_s: _is("same"),
    mdp.remaining_time_s: _is("same"),
}
"""By function."""

# -- actions


def _numbers(values: Any, count: int, otherwise: float) -> torch.Tensor:
    """A setting of each column as a row of numbers."""
    row = torch.as_tensor(otherwise if values is None else values, dtype=torch.float64).cpu()
    return row.expand(count)


def _joint_targets(moves: bool) -> Callable[[TaskMirror, Any], MirrorMap]:
    """Actions of which an affine map is a target of each joint."""

    def of(mirror: TaskMirror, term: Any) -> MirrorMap:
        descriptor = term.IO_descriptor
        image = mirror.joints(term.cfg.asset_name).named(descriptor.joint_names, moves)
        count = len(image)
        return image.in_units(_numbers(descriptor.scale, count, 1.0), _numbers(descriptor.offset, count, 0.0))

    return of


def _targets_within_limits(mirror: TaskMirror, term: Any) -> MirrorMap:
    descriptor = term.IO_descriptor
    count = len(descriptor.joint_names)
    scale, zero = _numbers(descriptor.scale, count, 1.0), torch.zeros(count, dtype=torch.float64)
    if descriptor.extras["rescale_to_limits"]:
        low, high = (_numbers(descriptor.extras[side], count, 0.0) for side in ("lower", "upper"))
        scale, zero = scale * 0.5 * (high - low), 0.5 * (high + low)
    return mirror.joints(term.cfg.asset_name).named(descriptor.joint_names).in_units(scale, zero)


def _gripper(mirror: TaskMirror, term: Any) -> str:
    """One number that opens or closes; both targets have to be their own mirror images."""
    descriptor = term.IO_descriptor
    image = mirror.joints(term.cfg.asset_name).named(descriptor.joint_names)
    for which in ("open_command", "close_command"):
        target = _numbers(descriptor.extras[which], len(image), 0.0)
        if not torch.allclose(image(target.clone()), target):
            raise ConfigError(
                f"{type(term).__name__}: {which}_expr is not its own mirror image, so the action has none; give the "
                "joints that change places equal targets"
            )
    return "same"


def _inverse_kinematics(mirror: TaskMirror, term: Any) -> str:
    controller: DifferentialIKControllerCfg = term.cfg.controller
    if controller.command_type == "position":
        return "vector"
    return "twist" if controller.use_relative_mode else "pose"


def _operational_space(mirror: TaskMirror, term: Any) -> MirrorMap:
    controller = term.cfg.controller_cfg
    kinds = ["pose" if target == "pose_abs" else "twist" for target in controller.target_types]
    maps = [map_of_kind(kind, 7 if kind == "pose" else 6, type(term).__name__) for kind in kinds]
    gains = {"fixed": 0, "variable_kp": 6, "variable": 12}[controller.impedance_mode]
    return MirrorMap.cat([*maps, *([MirrorMap.of([1.0] * gains)] if gains else [])])


ACTIONS: Mapping[type, Callable[[TaskMirror, Any], Kind]] = {
    mdp.JointPositionAction: _joint_targets(moves=True),
    mdp.RelativeJointPositionAction: _joint_targets(moves=False),
    mdp.JointVelocityAction: _joint_targets(moves=False),
    mdp.JointEffortAction: _joint_targets(moves=False),
    mdp.JointPositionToLimitsAction: _targets_within_limits,
    mdp.BinaryJointAction: _gripper,
    mdp.NonHolonomicAction: lambda mirror, term: MirrorTermCfg(signs=[1.0, -1.0]),
    mdp.DifferentialInverseKinematicsAction: _inverse_kinematics,
    mdp.OperationalSpaceControllerAction: _operational_space,
}
"""By class; a sub-class mirrors as its base does."""

# -- commands

COMMANDS: Mapping[type, Callable[[TaskMirror, Any], Kind]] = {
    mdp.UniformPoseCommand: lambda mirror, term: "pose",
    mdp.UniformVelocityCommand: lambda mirror, term: "planar_velocity",
    mdp.UniformPose2dCommand: lambda mirror, term: "planar_pose",
}
"""By class; a sub-class mirrors as its base does."""

"""Fields of the model that may differ between environments, and what follows from them."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np
import torch

from lift_lab.utils.errors import ConfigError


def words(*lines: str) -> tuple[str, ...]:
    """Split lines into words."""
    return tuple(" ".join(lines).split())


RANDOMIZABLE_FIELDS = words(
    "body_mass body_inertia body_ipos body_iquat body_pos body_quat body_gravcomp",
    "jnt_pos jnt_axis jnt_range jnt_margin jnt_stiffness jnt_solref jnt_solimp jnt_actfrcrange",
    "dof_armature dof_damping dof_frictionloss dof_solref dof_solimp",
    "geom_pos geom_quat geom_size geom_friction geom_solref geom_solimp geom_solmix geom_margin geom_gap geom_rgba",
    "site_pos site_quat cam_pos cam_quat cam_fovy",
    "actuator_gainprm actuator_biasprm actuator_dynprm actuator_gear actuator_ctrlrange actuator_forcerange",
    "eq_data eq_solref eq_solimp flex_friction qpos0 qpos_spring opt.gravity",
)
"""Model fields that may differ between environments: numbers, never structure (counts, ids, types)."""

CONSTANT_INPUTS = words(
    "qpos0 qpos_spring body_mass body_inertia body_ipos body_iquat body_pos body_quat body_gravcomp jnt_pos jnt_axis",
    "dof_armature geom_pos geom_quat geom_size geom_margin geom_gap site_pos site_quat cam_pos cam_quat",
    "actuator_gear eq_data",
)
"""Fields of :data:`RANDOMIZABLE_FIELDS` from which others follow: inverse weights, bounding volumes, shortcuts."""

_GEOM = mujoco.mjtGeom
_WITHOUT_SIZE = [int(kind) for kind in (_GEOM.mjGEOM_PLANE, _GEOM.mjGEOM_HFIELD, _GEOM.mjGEOM_MESH, _GEOM.mjGEOM_SDF)]
_FREE = [int(kind) for kind in (mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_BALL)]
_SAME = 1e-6
"""MuJoCo's tolerance of frames that coincide."""


def check_model_fields(model: mujoco.MjModel, fields: Mapping[str, torch.Tensor]) -> None:
    """Check values of :data:`CONSTANT_INPUTS` against what the model was compiled for.

    MuJoCo stores a diagonal inertia matrix for a body that is "simple": its frame is that of its inertia and its
    joints lie in it. Neither engine notices on its own that this no longer holds in all cases.

    Args:
        model: the compiled model.
        fields: values of each environment by name, shape (num_envs, *shape).

    Raises:
        ConfigError: a simple body gets another inertial frame or joint frame, or a mesh, plane or height field
            another size.
    """
    simple = np.flatnonzero(model.body_simple[1:] > 0) + 1
    joints = np.flatnonzero(np.isin(model.jnt_bodyid, simple))
    axes = joints[~np.isin(model.jnt_type[joints], _FREE)]
    unsized = np.flatnonzero(np.isin(model.geom_type, _WITHOUT_SIZE))
    bodies_of_joints = model.jnt_bodyid
    for name, ids in (("body_ipos", simple), ("body_iquat", simple), ("jnt_pos", joints), ("jnt_axis", axes)):
        if name not in fields or not len(ids):
            continue
        values = fields[name][:, torch.from_numpy(ids).to(fields[name].device)].abs()
        if name == "jnt_axis":
            bad = (values > _SAME).sum(dim=-1) != 1
        else:
            bad = (values[..., -3:] > _SAME).any(dim=-1)
        for i in bad.any(dim=0).nonzero().flatten().tolist()[:1]:
            body = model.body(ids[i] if name.startswith("body") else bodies_of_joints[ids[i]]).name
            raise ConfigError(
                f"{name} of '{body}' cannot change: the body was compiled as simple, with a diagonal inertia matrix."
                " Set simple=False on the body in the scene's spec before it is compiled, as an event term's"
                " prepare_model can"
            )
    if "geom_size" in fields and len(unsized):
        sizes = fields["geom_size"][:, torch.from_numpy(unsized).to(fields["geom_size"].device)]
        compiled = torch.from_numpy(model.geom_size[unsized]).to(sizes)
        for i in (sizes != compiled).any(dim=-1).any(dim=0).nonzero().flatten().tolist()[:1]:
            geom = model.geom(unsized[i])
            kind = mujoco.mjtGeom(int(geom.type[0])).name.removeprefix("mjGEOM_").lower()
            raise ConfigError(f"geom_size of '{geom.name}' cannot change: a {kind} has its shape from elsewhere")


def fixed_geoms(model: mujoco.MjModel) -> np.ndarray:
    """Geoms of bodies that are fixed to the world and are no mocap bodies."""
    bodies = model.geom_bodyid
    fixed = (model.body_weldid[bodies] == 0) & (model.body_mocapid[model.body_rootid[bodies]] == -1)
    return np.flatnonzero(fixed)

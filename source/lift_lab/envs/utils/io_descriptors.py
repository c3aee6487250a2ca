"""Isaac Lab's IO descriptors: inputs and outputs of a policy as plain data."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import yaml

from lift_lab.utils.errors import ConfigError
from lift_lab.utils.io import write_atomically
from lift_lab.utils.io_descriptors import (
    GenericActionIODescriptor,
    GenericObservationIODescriptor,
    generic_io_descriptor,
    plain,
    record_body_names,
    record_dtype,
    record_joint_names,
    record_joint_pos_offsets,
    record_joint_vel_offsets,
    record_shape,
)

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedEnv

__all__ = [
    "GenericActionIODescriptor",
    "GenericObservationIODescriptor",
    "export_articulations_data",
    "export_scene_data",
    "generic_io_descriptor",
    "record_body_names",
    "record_dtype",
    "record_joint_names",
    "record_joint_pos_offsets",
    "record_joint_vel_offsets",
    "record_shape",
]

FILE = "IO_descriptors.yaml"
"""Name of the file."""

_JOINT_DATA = ("pos", "vel", "pos_limits", "damping", "stiffness", "friction", "armature")


def export_articulations_data(env: ManagerBasedEnv) -> dict[str, dict[str, Any]]:
    """Joint names and default joint values of the first environment, by articulation.

    Returns:
        By name of the articulation: ``joint_names``, and ``default_joint_pos``, ``_vel``, ``_pos_limits``,
        ``_damping``, ``_stiffness``, ``_friction`` and ``_armature``, in the order of the names. Units: rad or m, s,
        N m or N.
    """
    found: dict[str, dict[str, Any]] = {}
    for name, articulation in env.scene.articulations.items():
        data: Any = articulation.data
        values = {f"default_joint_{kind}": getattr(data, f"default_joint_{kind}")[0] for kind in _JOINT_DATA}
        found[name] = plain({"joint_names": articulation.joint_names, **values})
    return found


def export_scene_data(env: ManagerBasedEnv) -> dict[str, Any]:
    """Physics step and environment step in s, and physics steps in an environment step."""
    return {"physics_dt": env.physics_dt, "dt": env.step_dt, "decimation": int(env.cfg.decimation)}


def io_descriptors(env: ManagerBasedEnv) -> dict[str, Any]:
    """All descriptions of an environment, see :attr:`~lift_lab.envs.ManagerBasedEnv.get_IO_descriptors`."""
    return {
        "observations": env.observation_manager.get_IO_descriptors,
        "actions": env.action_manager.get_IO_descriptors,
        "articulations": export_articulations_data(env),
        "scene": export_scene_data(env),
    }


def write_io_descriptors(env: ManagerBasedEnv, output_dir: str | Path | None) -> Path:
    """Write ``IO_descriptors.yaml``, see :meth:`~lift_lab.envs.ManagerBasedEnv.export_IO_descriptors`."""
    if output_dir is None:
        if env.cfg.log_dir is None:
            raise ConfigError("where do the IO descriptors go? Set env.log_dir, or give export_IO_descriptors a folder")
        output_dir = Path(env.cfg.log_dir) / "io_descriptors"
    path = Path(output_dir) / FILE
    write_atomically(path, yaml.safe_dump(io_descriptors(env)).encode())
    return path

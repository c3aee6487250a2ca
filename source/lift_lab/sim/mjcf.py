"""A simulation's scene as an MJCF file that plain MuJoCo loads."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np

from lift_lab.utils.errors import PhysicsError
from lift_lab.utils.io import write_atomically

INITIAL_KEY = "initial"
"""Name of the keyframe with the initial state."""


def write_mjcf(
    spec: mujoco.MjSpec, model: mujoco.MjModel, path: str | Path, initial_qpos: np.ndarray, initial_qvel: np.ndarray
) -> list[Path]:
    """Write a scene as MJCF: bodies, actuators and solver settings of one environment.

    Names are those of the scene: ``robot/panda_joint1`` is a joint of the entity ``robot``. A keyframe ``initial``
    holds the initial state, with position drives at their joints' initial positions.

    Args:
        spec: the scene's spec; left as it is.
        model: the model that was compiled from it.
        path: of the ``.xml`` file; its folder is made. Files that the scene needs, such as textures, go beside it.
        initial_qpos: MuJoCo's positions, shape (nq,).
        initial_qvel: MuJoCo's velocities, shape (nv,).

    Returns:
        The files, the MJCF first.

    Raises:
        PhysicsError: MuJoCo cannot write the scene as MJCF.
        FileError: a file cannot be written.
    """
    path = Path(path)
    copy = spec.copy()
    try:
        ctrl = _holding_ctrl(model, initial_qpos)
        copy.add_key(name=INITIAL_KEY, qpos=initial_qpos, qvel=initial_qvel, ctrl=ctrl)
        copy.compile()
        text = copy.to_xml()
        mujoco.MjModel.from_xml_string(text, dict(copy.assets))
    except (ValueError, mujoco.FatalError) as error:
        raise PhysicsError(f"MuJoCo cannot write this scene as MJCF: {error}") from error
    files = {path: text.encode()}
    for name, content in copy.assets.items():
        files[path.parent / name] = content.encode() if isinstance(content, str) else content
    for file, content in files.items():
        write_atomically(file, content)
    return list(files)


def _holding_ctrl(model: mujoco.MjModel, qpos: np.ndarray) -> np.ndarray:
    """Control that asks each position drive for the joint position that it has; 0 for other actuators."""
    ctrl = np.zeros(model.nu)
    for actuator in range(model.nu):
        if model.actuator_trntype[actuator] == mujoco.mjtTrn.mjTRN_JOINT and model.actuator_biasprm[actuator, 1] < 0:
            ctrl[actuator] = qpos[model.jnt_qposadr[model.actuator_trnid[actuator, 0]]]
    return ctrl

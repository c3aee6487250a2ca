"""The shipped robot, cube and table together: a scripted hand picks the cube up and holds it.

No learning gate can pass with contacts or gains that fail here.
"""

import mujoco
import numpy as np
import pytest

from lift_lab.usd import load
from lift_lab_assets.files import ASSETS_USD_DIR

START = [0.0, -0.569, 0.0, -2.810, 0.0, 3.037, 0.741, 0.04, 0.04]
DOWN = np.diag([1.0, -1.0, -1.0])
"""Orientation of a hand that looks down."""
SUBSTEPS = 4
CUBE_QPOS = slice(9, 12)


def scene(variants: dict[str, str] | None = None) -> mujoco.MjModel:
    """Robot at the origin, table before it, cube loose; the physics settings that learning uses."""
    spec = mujoco.MjSpec()
    spec.option.timestep = 0.005
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.iterations = 10
    spec.option.ls_iterations = 20
    robot, _ = load(ASSETS_USD_DIR / "franka_panda.usda", variants=variants)
    robot.body("panda_hand").add_site(name="tool", pos=[0, 0, 0.1034])
    for body in robot.bodies[1:]:
        body.gravcomp = 1
    table, _ = load(ASSETS_USD_DIR / "table.usda")
    cube, _ = load(ASSETS_USD_DIR / "cube.usda")
    spec.attach(robot, frame=spec.worldbody.add_frame(), prefix="robot_")
    spec.attach(
        table, frame=spec.worldbody.add_frame(pos=[0.5, 0, 0], quat=[0.5**0.5, 0, 0, 0.5**0.5]), prefix="table_"
    )
    spec.attach(cube, frame=spec.worldbody.add_frame(), prefix="cube_")
    return spec.compile()


def toward(model: mujoco.MjModel, q: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Arm angles one damped least-squares step nearer to `target` (m, world), the hand looking down."""
    data = mujoco.MjData(model)
    data.qpos[:7] = q
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    jacobian = np.zeros((6, model.nv))
    mujoco.mj_jacSite(model, data, jacobian[:3], jacobian[3:], 0)
    turn = DOWN @ data.site_xmat[0].reshape(3, 3).T
    angle = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    error = np.concatenate([target - data.site_xpos[0], np.clip(angle, -0.1, 0.1)])
    arm = jacobian[:, :7]
    step = arm.T @ np.linalg.solve(arm @ arm.T + 1e-4 * np.eye(6), error)
    return np.clip(q + np.clip(step, -0.06, 0.06), *model.jnt_range[:7].T)


@pytest.mark.parametrize(
    "variants", [{}, {"FingerColliders": "full", "FingerMimic": "on"}], ids=["default", "real hand"]
)
def test_a_scripted_hand_lifts_the_cube_and_holds_it(variants):
    model = scene(variants)
    for x, y in ((0.42, -0.2), (0.58, 0.15)):
        data = mujoco.MjData(model)
        data.qpos[:9] = START
        data.qpos[CUBE_QPOS] = x, y, 0.02
        mujoco.mj_forward(model, data)
        q, command = np.array(START[:7]), data.site_xpos[0].copy()
        plan = [((x, y, 0.14), 0.04, 90), ((x, y, 0.024), 0.04, 50), ((x, y, 0.024), 0.0, 15), ((0.5, 0, 0.3), 0.0, 95)]
        for target, grip, steps in plan:
            for _ in range(steps):
                command += np.clip(np.array(target) - command, -0.015, 0.015)
                q = toward(model, toward(model, q, command), command)
                data.ctrl[:9] = [*q, grip, grip]
                mujoco.mj_step(model, data, SUBSTEPS)
        # Held at the tool centre, off the table, and still.
        np.testing.assert_allclose(data.qpos[CUBE_QPOS], data.site_xpos[0], atol=0.02)
        np.testing.assert_allclose(data.qpos[CUBE_QPOS], [0.5, 0, 0.3], atol=0.03)
        assert np.abs(data.qvel[9:12]).max() < 0.05

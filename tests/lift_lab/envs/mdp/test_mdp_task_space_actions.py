"""End-effector actions on the Panda: kinematics, dynamics, and reaching what was commanded."""

from types import SimpleNamespace

import mujoco
import numpy as np
import pytest
import torch

import lift_lab.envs.mdp as mdp
import lift_lab.sim as sim_utils
from lift_lab.actuators import ImplicitActuatorCfg
from lift_lab.assets import ArticulationCfg
from lift_lab.assets.articulation.joint_dynamics import JointDynamics
from lift_lab.controllers import DifferentialIKControllerCfg, OperationalSpaceControllerCfg
from lift_lab.envs.mdp.actions._end_effector import EndEffector
from lift_lab.scene import InteractiveScene, InteractiveSceneCfg
from lift_lab.sim.physics import make_physics
from lift_lab.utils import configclass
from lift_lab.utils.assets import ISAACLAB_NUCLEUS_DIR
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.math import quat_apply, quat_error_magnitude, quat_mul

N = 3
REACH = [0.0, -0.4, 0.0, -2.2, 0.0, 2.0, 0.74]
HAND = {"asset_name": "robot", "joint_names": ["panda_joint.*"], "body_name": "panda_hand"}


@configclass
class _SceneCfg(InteractiveSceneCfg):
    robot = ArticulationCfg(
        prim_path="{ENV_REGEX_NS}/Robot",
        # turned by 90 degrees, so that root and world frames differ
        init_state=ArticulationCfg.InitialStateCfg(
            pos=(0.3, -0.2, 0.1),
            rot=(0.7071068, 0.0, 0.0, 0.7071068),
            joint_pos={f"panda_joint{i + 1}": q for i, q in enumerate(REACH)} | {"panda_finger_joint.*": 0.04},
        ),
        spawn=sim_utils.UsdFileCfg(
            usd_path=f"{ISAACLAB_NUCLEUS_DIR}/Robots/FrankaEmika/panda_instanceable.usd",
            rigid_props=sim_utils.RigidBodyPropertiesCfg(disable_gravity=True),
        ),
        actuators={"all": ImplicitActuatorCfg(joint_names_expr=[".*"], stiffness=800.0, damping=80.0)},
    )


@pytest.fixture(scope="module")
def panda():
    """Scene with three Pandas at rest, shared by the tests of this module."""
    sim = sim_utils.SimulationContext(sim_utils.SimulationCfg(device="cpu", dt=0.005))
    scene = InteractiveScene(_SceneCfg(num_envs=N, env_spacing=2.0))
    sim.reset()
    yield SimpleNamespace(sim=sim, scene=scene, num_envs=N, device="cpu", robot=scene["robot"])
    sim.close()


@pytest.fixture
def env(panda):
    """The scene with different joint positions in each environment, and no velocity targets left over."""
    torch.manual_seed(1)
    robot = panda.robot
    panda.scene.reset()
    position = robot.data.default_joint_pos.clone()
    position[:, :7] += 0.2 * torch.randn(N, 7)
    _place(panda, position, torch.zeros(N, 9))
    return panda


def _place(env, position, velocity):
    env.robot.write_joint_state_to_sim(position, velocity)
    env.robot.set_joint_position_target(position)
    env.scene.write_data_to_sim()
    env.sim.physics.refresh()
    env.scene.update(0.0)


def _run(env, term, steps):
    for _ in range(steps):
        term.apply_actions()
        env.scene.write_data_to_sim()
        env.sim.physics.step(1)
        env.scene.update(0.005)


OFFSET = SimpleNamespace(pos=(0.05, -0.02, 0.107), rot=(0.8, 0.0, 0.6, 0.0))


@pytest.mark.parametrize("offset", [None, OFFSET])
def test_the_jacobian_is_the_motion_of_the_frame(env, offset):
    effector = EndEffector(env.robot, ["panda_joint.*"], "panda_hand", offset, "test")
    jacobian = effector.jacobian_b()
    position, quat = effector.pose_b()
    start, eps = env.robot.data.joint_pos.clone(), 2e-3
    for joint in range(7):
        moved = start.clone()
        moved[:, joint] += eps
        _place(env, moved, torch.zeros(N, 9))
        position_1, quat_1 = effector.pose_b()
        torch.testing.assert_close((position_1 - position) / eps, jacobian[:, :3, joint], atol=4e-3, rtol=0)
        # a small turn w: q1 q0^-1 = (1, w / 2)
        conjugate = quat * torch.tensor([1.0, -1.0, -1.0, -1.0])
        turn = 2.0 * quat_mul(quat_1, conjugate)[:, 1:] / eps
        torch.testing.assert_close(turn, jacobian[:, 3:, joint], atol=4e-3, rtol=0)


@pytest.mark.parametrize("offset", [None, OFFSET])
def test_the_velocity_of_the_frame_is_the_jacobian_times_the_joint_velocities(env, offset):
    effector = EndEffector(env.robot, ["panda_joint.*"], "panda_hand", offset, "test")
    velocity = torch.zeros(N, 9)
    velocity[:, :7] = torch.randn(N, 7)
    effector.velocity_b()  # from here on the engine keeps velocities current
    _place(env, env.robot.data.joint_pos.clone(), velocity)
    expected = (effector.jacobian_b() @ velocity[:, :7].unsqueeze(-1)).squeeze(-1)
    torch.testing.assert_close(effector.velocity_b(), expected, atol=1e-4, rtol=0)


ARM_XML = """
<mujoco>
  <option gravity="1 -2 -9"/>
  <worldbody>
    <body name="other"><freejoint/><geom size="0.1" mass="3"/></body>
    <body name="arm/base" pos="0.5 0 1">
      <geom size="0.1" mass="4"/>
      <body name="arm/a" pos="0 0 0.2" quat="0.8 0.6 0 0">
        <joint name="a" axis="0 0.6 0.8" armature="0.3"/>
        <geom type="box" size="0.1 0.05 0.2" pos="0.1 0 0.2" mass="2"/>
        <body name="arm/b" pos="0.2 0 0.4">
          <joint name="b" type="slide" axis="1 0 0"/>
          <joint name="c" axis="0 1 0" pos="0.1 0 0"/>
          <geom type="capsule" size="0.05 0.2" pos="0 0.2 0" mass="1"/>
          <body name="arm/c" pos="0 0.4 0" gravcomp="1">
            <joint name="d" axis="1 1 0" armature="0.1"/>
            <geom type="box" size="0.1 0.2 0.05" pos="0 0 0.1" mass="0.7"/>
          </body>
        </body>
        <body name="arm/side" pos="-0.2 0 0"><joint name="e" axis="0 0 1"/><geom size="0.08" mass="0.6"/></body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


@pytest.mark.parametrize("chosen", [[0, 1, 2, 3, 4], [3, 1]])
def test_inertia_and_gravity_are_mujocos(chosen):
    model = mujoco.MjModel.from_xml_string(ARM_XML)
    physics = make_physics(model, 4)
    torch.manual_seed(0)
    physics.write("qpos", torch.randn(4, 5), cols=slice(7, 12))
    physics.refresh()
    arm_bodies = [i for i in range(model.nbody) if model.body(i).name.startswith("arm/")]
    armature = torch.tensor(np.asarray(model.dof_armature)[6:], dtype=torch.float32).repeat(4, 1)
    asset = SimpleNamespace(
        physics=physics,
        engine_body_ids=arm_bodies,
        engine_dof_ids=[6, 7, 8, 9, 10],
        device="cpu",
        data=SimpleNamespace(joint_armature=armature),
    )
    dynamics = JointDynamics(asset, torch.tensor(chosen))
    dofs = [6 + j for j in chosen]
    for env_id in range(4):
        data = mujoco.MjData(model)
        data.qpos[:] = physics.field("qpos")[env_id].numpy()
        mujoco.mj_forward(model, data)
        inertia = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, inertia)
        torch.testing.assert_close(
            dynamics.mass_matrix()[env_id].double(), torch.tensor(inertia[np.ix_(dofs, dofs)]), atol=1e-4, rtol=1e-4
        )
        holding = data.qfrc_bias - data.qfrc_passive  # at rest: gravity less what the engine compensates
        torch.testing.assert_close(
            dynamics.gravity_efforts()[env_id].double(), torch.tensor(holding[dofs]), atol=1e-3, rtol=1e-4
        )
    physics.close()


@pytest.mark.parametrize("method", ["pinv", "svd", "dls"])
def test_inverse_kinematics_brings_the_offset_frame_to_a_pose(env, method):
    cfg = mdp.DifferentialInverseKinematicsActionCfg(
        **HAND,
        body_offset=mdp.DifferentialInverseKinematicsActionCfg.OffsetCfg(pos=(0.0, 0.0, 0.107)),
        controller=DifferentialIKControllerCfg(command_type="pose", ik_method=method),
    )
    term = cfg.class_type(cfg, env)
    assert not term.constant_over_substeps
    target = torch.tensor([[0.45, 0.1, 0.4, 0.0, 1.0, 0.0, 0.0]]).repeat(N, 1)
    term.process_actions(target)
    _run(env, term, 300)
    data = env.robot.data
    hand = env.robot.body_names.index("panda_hand")
    tip_w = data.body_pos_w[:, hand] + quat_apply(
        data.body_quat_w[:, hand], torch.tensor([[0.0, 0.0, 0.107]]).repeat(N, 1)
    )
    # the root stands at (0.3, -0.2, 0.1), turned by 90 degrees about z
    expected = env.scene.env_origins + torch.tensor([0.3 - 0.1, -0.2 + 0.45, 0.1 + 0.4])
    torch.testing.assert_close(tip_w, expected, atol=3e-3, rtol=0)
    turned = quat_mul(data.root_quat_w, target[:, 3:])
    assert quat_error_magnitude(turned, data.body_quat_w[:, hand]).max() < 0.02


def test_a_relative_command_moves_the_hand_in_the_root_frame(env):
    cfg = mdp.DifferentialInverseKinematicsActionCfg(
        **HAND,
        scale=0.1,
        controller=DifferentialIKControllerCfg(command_type="position", use_relative_mode=True, ik_method="dls"),
    )
    term = cfg.class_type(cfg, env)
    hand = env.robot.body_names.index("panda_hand")
    before = env.robot.data.body_pos_w[:, hand].clone()
    term.process_actions(torch.tensor([[0.5, 0.0, 0.3]]).repeat(N, 1))
    _run(env, term, 200)
    moved = env.robot.data.body_pos_w[:, hand] - before
    torch.testing.assert_close(moved, torch.tensor([[0.0, 0.05, 0.03]]).repeat(N, 1), atol=3e-3, rtol=0)
    term.reset(torch.tensor([1]))
    assert term.raw_actions[1].tolist() == [0.0, 0.0, 0.0]


def test_clip_and_scale_name_the_columns_of_the_command(env):
    controller = DifferentialIKControllerCfg(command_type="pose", use_relative_mode=True, ik_method="dls")
    cfg = mdp.DifferentialInverseKinematicsActionCfg(
        **HAND, scale=(1.0, 1.0, 1.0, 2.0, 2.0, 2.0), clip={"x": (-0.1, 0.1), "r.": (-0.5, 0.5)}, controller=controller
    )
    term = cfg.class_type(cfg, env)
    term.process_actions(torch.full((N, 6), 0.2))
    torch.testing.assert_close(term.processed_actions[0], torch.tensor([0.1, 0.2, 0.2, 0.4, 0.4, 0.4]))
    cfg.scale = (1.0, 2.0)
    with pytest.raises(ConfigError, match="2 values for 6 columns"):
        cfg.class_type(cfg, env)


def test_operational_space_control_holds_a_pose_and_the_elbow(env):
    cfg = mdp.OperationalSpaceControllerActionCfg(
        **HAND,
        controller_cfg=OperationalSpaceControllerCfg(
            target_types=["pose_abs"],
            inertial_dynamics_decoupling=True,
            gravity_compensation=True,
            motion_stiffness_task=200.0,
            nullspace_control="position",
        ),
        nullspace_joint_pos_target="default",
    )
    robot = env.robot
    arm = list(range(7))
    robot.write_joint_stiffness_to_sim(torch.zeros(N, 7), joint_ids=arm)
    robot.write_joint_damping_to_sim(torch.zeros(N, 7), joint_ids=arm)
    try:
        term = cfg.class_type(cfg, env)
        target = torch.tensor([[0.45, 0.1, 0.5, 0.0, 1.0, 0.0, 0.0]]).repeat(N, 1)
        term.process_actions(target)
        _run(env, term, 600)
        pose = torch.cat(term._end_effector.pose_b(), dim=1)
        torch.testing.assert_close(pose[:, :3], target[:, :3], atol=5e-3, rtol=0)
        assert quat_error_magnitude(pose[:, 3:], target[:, 3:]).max() < 0.02
        assert robot.data.joint_vel[:, :7].abs().max() < 0.05
    finally:
        robot.write_joint_stiffness_to_sim(torch.full((N, 7), 800.0), joint_ids=arm)
        robot.write_joint_damping_to_sim(torch.full((N, 7), 80.0), joint_ids=arm)


@pytest.mark.parametrize(
    ("settings", "controller", "message"),
    [
        ({"nullspace_joint_pos_target": "zero"}, {}, "set both or neither"),
        ({}, {"nullspace_control": "position"}, "set both or neither"),
        ({"task_frame_rel_path": "Table"}, {}, "task_frame_rel_path 'Table'"),
        (
            {},
            {"target_types": ["wrench_abs"], "contact_wrench_stiffness_task": 1.0},
            "contact sensor",
        ),
        ({"body_name": "panda_link.*"}, {}, "must match one body"),
    ],
)
def test_operational_space_settings_that_disagree_are_errors(env, settings, controller, message):
    controller = OperationalSpaceControllerCfg(**{"target_types": ["pose_abs"], **controller})
    cfg = mdp.OperationalSpaceControllerActionCfg(**{**HAND, **settings}, controller_cfg=controller)
    with pytest.raises(ConfigError, match=message):
        cfg.class_type(cfg, env)


def test_scales_follow_the_targets_and_gains(env):
    cfg = mdp.OperationalSpaceControllerActionCfg(
        **HAND,
        controller_cfg=OperationalSpaceControllerCfg(
            target_types=["pose_rel", "wrench_abs"],
            impedance_mode="variable",
            motion_stiffness_limits_task=(10.0, 50.0),
        ),
        position_scale=0.1,
        orientation_scale=0.2,
        wrench_scale=3.0,
        stiffness_scale=20.0,
        damping_ratio_scale=0.5,
    )
    term = cfg.class_type(cfg, env)
    assert term.action_dim == 24
    action = torch.ones(N, 24)
    action[:, 12] = 9.0
    term.process_actions(action)
    expected = [0.1] * 3 + [0.2] * 3 + [3.0] * 6 + [50.0] + [20.0] * 5 + [0.5] * 6
    torch.testing.assert_close(term.processed_actions[0], torch.tensor(expected))


def test_a_task_frame_carries_the_targets(make_env):
    env = make_env()
    env.reset()
    cfg = mdp.OperationalSpaceControllerActionCfg(
        asset_name="robot",
        joint_names=[".*"],
        body_name="lower",
        task_frame_rel_path="Ball",
        controller_cfg=OperationalSpaceControllerCfg(target_types=["pose_abs"]),
    )
    term = cfg.class_type(cfg, env)
    half = 0.5**0.5
    pose = torch.tensor([[2.0, 0.0, 1.0, half, 0.0, 0.0, half]]).repeat(3, 1)
    pose[:, :3] += env.scene.env_origins
    env.scene["ball"].write_root_pose_to_sim(pose)
    term.process_actions(torch.tensor([[0.3, 0.1, -0.2, 1.0, 0.0, 0.0, 0.0]]).repeat(3, 1))
    # the ball is turned by 90 degrees; the arm's base stands at (0, 0, 0.5)
    wanted = torch.tensor([2.0 - 0.1, 0.3, 0.5 - 0.2, half, 0.0, 0.0, half]).repeat(3, 1)
    torch.testing.assert_close(term._osc.desired_ee_pose_b, wanted, atol=1e-6, rtol=0)

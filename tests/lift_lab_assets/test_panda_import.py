"""The Panda's USD file, imported, is the robot that its published numbers describe.

The reference is MuJoCo's own compile of the MJCF below: the same numbers, typed from the publications in
MJCF's terms (full inertia tensors, radians, nested bodies), without a pass through USD.
"""

import mujoco
import numpy as np
import pytest
from pxr import Usd

from lift_lab.usd import load
from lift_lab.utils.assets import ISAACLAB_NUCLEUS_DIR, resolve_usd_path
from lift_lab_assets.files import ASSETS_USD_DIR

REFERENCE = """
<mujoco>
  <compiler angle="radian" autolimits="true"/>
  <default>
    <joint axis="0 0 1" armature="0.1" damping="0.5"/>
    <default class="finger"><joint type="slide" axis="0 1 0" range="0 0.04" damping="1"/></default>
  </default>
  <worldbody>
    <body name="panda_link0">
      <inertial mass="0.629769" pos="-0.041018 -0.00014 0.049974"
        fullinertia="0.00315 0.00388 0.004285 8.2904e-7 0.00015 8.2299e-6"/>
      <body name="panda_link1" pos="0 0 0.333">
        <inertial mass="4.970684" pos="0.003875 0.002081 -0.04762"
          fullinertia="0.70337 0.70661 0.009117 -0.000139 0.006772 0.019169"/>
        <joint name="panda_joint1" range="-2.8973 2.8973"/>
        <body name="panda_link2" quat="1 -1 0 0">
          <inertial mass="0.646926" pos="-0.003141 -0.02872 0.003495"
            fullinertia="0.007962 0.02811 0.025995 -0.003925 0.010254 0.000704"/>
          <joint name="panda_joint2" range="-1.7628 1.7628"/>
          <body name="panda_link3" pos="0 -0.316 0" quat="1 1 0 0">
            <inertial mass="3.228604" pos="0.027518 0.039252 -0.066502"
              fullinertia="0.037242 0.036155 0.01083 -0.004761 -0.011396 -0.012805"/>
            <joint name="panda_joint3" range="-2.8973 2.8973"/>
            <body name="panda_link4" pos="0.0825 0 0" quat="1 1 0 0">
              <inertial mass="3.587895" pos="-0.05317 0.104419 0.027454"
                fullinertia="0.025853 0.019552 0.028323 0.007796 -0.001332 0.008641"/>
              <joint name="panda_joint4" range="-3.0718 -0.0698"/>
              <body name="panda_link5" pos="-0.0825 0.384 0" quat="1 -1 0 0">
                <inertial mass="1.225946" pos="-0.011953 0.041065 -0.038437"
                  fullinertia="0.035549 0.029474 0.008627 -0.002117 -0.004037 0.000229"/>
                <joint name="panda_joint5" range="-2.8973 2.8973"/>
                <body name="panda_link6" quat="1 1 0 0">
                  <inertial mass="1.666555" pos="0.060149 -0.014117 -0.010517"
                    fullinertia="0.001964 0.004354 0.005433 0.000109 -0.001158 0.000341"/>
                  <joint name="panda_joint6" range="-0.0175 3.7525"/>
                  <body name="panda_link7" pos="0.088 0 0" quat="1 1 0 0">
                    <inertial mass="0.735522" pos="0.010517 -0.004252 0.061597"
                      fullinertia="0.012516 0.010027 0.004815 -0.000428 -0.001196 -0.000741"/>
                    <joint name="panda_joint7" range="-2.8973 2.8973"/>
                    <body name="panda_hand" pos="0 0 0.107" euler="0 0 -0.78539816339744831">
                      <inertial mass="0.73" pos="-0.01 0 0.03" diaginertia="0.001 0.0025 0.0017"/>
                      <body name="panda_leftfinger" pos="0 0 0.0584">
                        <inertial mass="0.015" pos="0 0 0" diaginertia="2.375e-6 2.375e-6 7.5e-7"/>
                        <joint name="panda_finger_joint1" class="finger"/>
                      </body>
                      <body name="panda_rightfinger" pos="0 0 0.0584">
                        <inertial mass="0.015" pos="0 0 0" diaginertia="2.375e-6 2.375e-6 7.5e-7"/>
                        <joint name="panda_finger_joint2" class="finger" axis="0 -1 0"/>
                      </body>
                    </body>
                  </body>
                </body>
              </body>
            </body>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""

ARM_JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
JOINTS = [*ARM_JOINTS, "panda_finger_joint1", "panda_finger_joint2"]
LINKS = [*(f"panda_link{i}" for i in range(8)), "panda_hand", "panda_leftfinger", "panda_rightfinger"]
PANDA = ASSETS_USD_DIR / "franka_panda.usda"


@pytest.fixture(scope="module")
def reference() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(REFERENCE)


@pytest.fixture(scope="module")
def imported():
    return load(PANDA)


@pytest.fixture(scope="module")
def model(imported) -> mujoco.MjModel:
    return imported[0].compile()


def dofs(model: mujoco.MjModel) -> list[int]:
    return [model.joint(name).dofadr[0] for name in JOINTS]


def at(model: mujoco.MjModel, q: np.ndarray, v: np.ndarray | None = None) -> mujoco.MjData:
    """Data at joint positions and velocities given in the order of JOINTS."""
    data = mujoco.MjData(model)
    data.qpos[[model.joint(name).qposadr[0] for name in JOINTS]] = q
    if v is not None:
        data.qvel[dofs(model)] = v
    mujoco.mj_forward(model, data)
    return data


@pytest.fixture(scope="module")
def configurations(reference) -> np.ndarray:
    """20 random configurations within the limits, shape (20, 9)."""
    limits = np.array([reference.joint(name).range for name in JOINTS])
    return np.random.default_rng(0).uniform(*limits.T, size=(20, len(JOINTS)))


def test_links_and_joints_have_their_names_and_the_base_is_fixed(model):
    assert {model.body(i).name for i in range(1, model.nbody)} == set(LINKS)
    assert {model.joint(i).name for i in range(model.njnt)} == set(JOINTS)
    assert model.nv == len(JOINTS)
    assert model.body("panda_link0").parentid[0] == 0


def test_forward_kinematics_agree(model, reference, configurations):
    for q in configurations:
        ours, theirs = at(model, q), at(reference, q)
        for link in LINKS:
            np.testing.assert_allclose(ours.body(link).xpos, theirs.body(link).xpos, atol=1e-6, err_msg=link)
            np.testing.assert_allclose(ours.body(link).xmat, theirs.body(link).xmat, atol=1e-6, err_msg=link)


def test_mass_matrices_agree_to_a_millionth_of_their_scale(model, reference, configurations):
    for q in configurations:
        matrices = []
        for m in (model, reference):
            full = np.zeros((m.nv, m.nv))
            mujoco.mj_fullM(m, at(m, q), full)
            matrices.append(full[np.ix_(dofs(m), dofs(m))])
        np.testing.assert_allclose(*matrices, rtol=0, atol=1e-6 * np.abs(matrices[1]).max())


def test_gravity_torques_agree_to_a_millionth_of_their_scale(model, reference, configurations):
    for q in configurations:
        ours, theirs = (at(m, q).qfrc_bias[dofs(m)] for m in (model, reference))
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-6 * np.abs(theirs).max())


def test_coriolis_torques_agree_to_a_millionth_of_their_scale(model, reference, configurations):
    velocities = np.random.default_rng(1).uniform(-2, 2, size=configurations.shape)
    for q, v in zip(configurations, velocities, strict=True):
        ours, theirs = (at(m, q, v).qfrc_bias[dofs(m)] for m in (model, reference))
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-6 * np.abs(theirs).max())


def test_robot_weighs_its_links(model):
    assert model.body_mass.sum() == pytest.approx(17.452, abs=5e-4)


def test_joint_ranges_armature_and_damping_agree(model, reference):
    for name in JOINTS:
        np.testing.assert_allclose(model.joint(name).range, reference.joint(name).range, atol=1e-6, err_msg=name)
        assert model.joint(name).limited[0] == 1, name
    for field in ("dof_armature", "dof_damping"):
        ours, theirs = getattr(model, field)[dofs(model)], getattr(reference, field)[dofs(reference)]
        np.testing.assert_allclose(ours, theirs, rtol=1e-6)
    assert not model.dof_frictionloss.any()


def test_drives_carry_gains_in_radians(model):
    assert {model.actuator(i).name for i in range(model.nu)} == set(JOINTS)
    for name in JOINTS:
        kp, kv = (400, 160) if name in ARM_JOINTS else (350, 10)
        np.testing.assert_allclose(model.actuator(name).gainprm[0], kp, rtol=1e-6)
        np.testing.assert_allclose(model.actuator(name).biasprm[:3], [0, -kp, -kv], rtol=1e-6)


def test_effort_is_limited_at_the_joint(model):
    for name in JOINTS:
        limit = 70 if "finger" in name else (87 if name in ARM_JOINTS[:4] else 12)
        joint = model.joint(name).id
        assert model.jnt_actfrclimited[joint] == 1, name
        np.testing.assert_allclose(model.jnt_actfrcrange[joint], [-limit, limit], rtol=1e-6, err_msg=name)


def test_velocity_limits_are_reported_in_radians(imported):
    _, report = imported
    expected = dict(zip(JOINTS, [2.175] * 4 + [2.61] * 3 + [0.2] * 2, strict=True))
    assert report.joint_velocity_limits == pytest.approx(expected, rel=1e-6)


def test_gravity_acts_unless_a_configuration_compensates_it(model):
    assert not model.body_gravcomp.any()


def test_links_never_touch_each_other_and_visuals_touch_nothing(model, configurations):
    for q in configurations:
        assert at(model, q).ncon == 0
    visuals = [i for i in range(model.ngeom) if model.geom(i).type[0] == mujoco.mjtGeom.mjGEOM_MESH]
    assert len(visuals) > len(LINKS)
    assert not model.geom_contype[visuals].any()
    assert not model.geom_conaffinity[visuals].any()


def test_links_rest_apart_at_the_initial_pose_even_with_self_collision():
    stage = Usd.Stage.Open(str(PANDA))
    stage.SetEditTarget(stage.GetSessionLayer())
    stage.GetDefaultPrim().GetAttribute("physxArticulation:enabledSelfCollisions").Set(True)
    colliding = load(stage)[0].compile()
    folded = [0.0, 1.7, 0.0, -3.0, 0.0, 0.0, 0.0, 0.04, 0.04]  # the hand reaches back into the upper arm
    initial = [0.0, -0.569, 0.0, -2.810, 0.0, 3.037, 0.741, 0.04, 0.04]
    assert at(colliding, np.array(initial)).ncon == 0
    assert at(colliding, np.array(folded)).ncon > 0
    assert colliding.nexclude < load(PANDA)[0].compile().nexclude


def test_pads_carry_the_contact_that_grasping_was_proven_with(model):
    for side in ("left", "right"):
        pad = model.geom(f"panda_{side}finger_pad")
        assert pad.condim[0] == 4
        np.testing.assert_allclose(pad.size, [0.00875, 0.0076, 0.017], rtol=1e-6)
        np.testing.assert_allclose(pad.friction, [1.0, 0.02, 0.0001], rtol=1e-6)
        np.testing.assert_allclose(pad.solref, [0.01, 1.0], rtol=1e-6)
        np.testing.assert_allclose(pad.solimp[:3], [0.95, 0.99, 0.001], rtol=1e-6)


def test_fingers_open_away_from_each_other(model):
    q = np.zeros(len(JOINTS))
    q[7:] = 0.04
    data = at(model, q)
    rotation = data.body("panda_hand").xmat.reshape(3, 3)
    apart = rotation.T @ (data.body("panda_leftfinger").xpos - data.body("panda_rightfinger").xpos)
    np.testing.assert_allclose(apart, [0, 0.08, 0], atol=1e-6)


def test_mimic_variant_couples_the_fingers():
    spec, _ = load(PANDA, variants={"FingerMimic": "on"})
    model = spec.compile()
    assert model.neq == 1
    assert model.eq_type[0] == mujoco.mjtEq.mjEQ_JOINT
    assert [model.joint(model.eq_obj1id[0]).name, model.joint(model.eq_obj2id[0]).name] == JOINTS[-1:-3:-1]
    np.testing.assert_allclose(model.eq_data[0, :5], [0, 1, 0, 0, 0])  # q2 = q1


def test_friction_variant_brings_the_identified_dry_friction():
    spec, _ = load(PANDA, variants={"JointFriction": "identified"})
    model = spec.compile()
    expected = [0.245, 0.152, 0.183, 0.359, 0.267, 0.166, 1.211, 0, 0]
    np.testing.assert_allclose(model.dof_frictionloss[dofs(model)], expected)


def test_isaac_labs_asset_paths_lead_to_the_shipped_files():
    assert resolve_usd_path(f"{ISAACLAB_NUCLEUS_DIR}/Robots/FrankaEmika/panda_instanceable.usd") == PANDA
    assert resolve_usd_path("cartpole.usda") == ASSETS_USD_DIR / "cartpole.usda"


def test_cube_weighs_a_fifth_of_a_kilogram_and_its_inertia_follows_its_scale():
    for scale in (1.0, 0.8):
        spec, report = load(ASSETS_USD_DIR / "cube.usda", scale=scale)
        model = spec.compile()
        assert report.root_bodies == ["Cube"]
        assert model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE
        np.testing.assert_allclose(model.body("Cube").mass, 0.2, rtol=1e-6)
        np.testing.assert_allclose(model.body("Cube").inertia, 0.2 * (0.04 * scale) ** 2 / 6, rtol=1e-5)
        np.testing.assert_allclose(model.geom("cube_collision").size, 0.02 * scale, rtol=1e-6)


@pytest.mark.filterwarnings("ignore:Attach conflict")
def test_cube_comes_to_rest_on_the_table():
    scene = mujoco.MjSpec()
    scene.option.timestep = 0.005
    for name, pos in (("table.usda", (0.5, 0, 0)), ("cube.usda", (0.5, 0, 0.1))):
        spec, _ = load(ASSETS_USD_DIR / name)
        scene.attach(spec, frame=scene.worldbody.add_frame(pos=pos), prefix=f"{name[0]}_")
    model = scene.compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 400)
    np.testing.assert_allclose(data.body("c_Cube").xpos, [0.5, 0, 0.02], atol=5e-4)
    assert np.abs(data.qvel).max() < 1e-3


def test_cartpole_imports_with_a_free_pole_and_a_rail():
    spec, _ = load(ASSETS_USD_DIR / "cartpole.usda")
    model = spec.compile()
    assert [model.joint(i).name for i in range(model.njnt)] == ["slider_to_cart", "cart_to_pole"]
    np.testing.assert_allclose(model.joint("slider_to_cart").range, [-4, 4], rtol=1e-6)
    np.testing.assert_allclose(model.joint("slider_to_cart").axis, [0, 1, 0], atol=1e-9)
    np.testing.assert_allclose(model.joint("cart_to_pole").axis, [1, 0, 0], atol=1e-9)
    assert model.joint("cart_to_pole").limited[0] == 0
    # A uniform rod on a hinge: m (h^2 + w^2) / 12 + m d^2 about the hinge.
    mass_matrix = np.zeros((2, 2))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, mass_matrix)
    np.testing.assert_allclose(np.diag(mass_matrix), [2.0, (1 + 0.06**2) / 12 + 0.47**2], rtol=1e-6)

"""The official Panda URDF -> urdf-usd-converter -> import, against the numbers in the URDF's text.

Masses, inertias, limits and forward kinematics are read and worked out here, with nothing but the XML and numpy. The
converter makes rigid bodies of the links that have mass (two of the Panda's 13 are bare frames).
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lift_lab.usd import load

CONVERTERS = [
    "urdf-usd-converter==0.3.4",
    "usd-exchange==3.0.1",
    "newton-usd-schemas==0.6.0",
    "numpy-stl==4.1.1",
    "python-utils==4.2.0",
    "typing-extensions==4.16.0",
    "tinyobjloader==2.0.0rc13",
    "pycollada==0.9.3",
    "python-dateutil==4.0.0",
]
DATA = "example-robot-data==6.0.0"
ENVIRONMENTS = {"urdf": CONVERTERS}
WHEELS = (DATA,)
INSIDE = "cmeel.prefix/share/example-robot-data"
pytestmark = pytest.mark.slow


def _numbers(element, name: str, default: str = "0 0 0") -> np.ndarray:
    return np.array([float(v) for v in (element.get(name, default) if element is not None else default).split()])


def _pose(origin) -> np.ndarray:
    """Homogeneous matrix of a URDF origin: fixed-axis roll, pitch, yaw."""
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_euler("xyz", _numbers(origin, "rpy")).as_matrix()
    matrix[:3, 3] = _numbers(origin, "xyz")
    return matrix


def _moved(joint, value: float) -> np.ndarray:
    """Pose of a joint's child in its parent at a joint position (rad or m)."""
    axis, matrix = _numbers(joint.find("axis"), "xyz", "1 0 0"), np.eye(4)
    if joint.get("type") == "revolute":
        matrix[:3, :3] = Rotation.from_rotvec(value * axis).as_matrix()
    elif joint.get("type") == "prismatic":
        matrix[:3, 3] = value * axis
    return _pose(joint.find("origin")) @ matrix


@pytest.fixture(scope="module")
def files(third_party):
    root = third_party.wheel(DATA, "robots/panda_description/") / INSIDE
    return root, root / "robots/panda_description/urdf/panda.urdf"


@pytest.fixture(scope="module")
def urdf(files):
    return ElementTree.parse(files[1]).getroot()


@pytest.fixture(scope="module")
def imported(third_party, files, tmp_path_factory):
    environment = third_party.environment("urdf", CONVERTERS, ("numpy", "numpy.libs"))
    folder = tmp_path_factory.mktemp("urdf")
    packages = [{"name": "example-robot-data", "path": str(files[0])}]
    task = [(str(files[1]), str(folder / "panda"), packages)]
    (stage,) = environment.run(Path(__file__).with_name("usd_convert.py"), task, folder)
    spec, report = load(stage)
    return spec.compile(), report


def _solid(urdf) -> list:
    """Links with mass."""
    return [link for link in urdf.findall("link") if float(link.find("inertial/mass").get("value")) > 0]


def test_every_link_with_mass_is_a_body(imported, urdf):
    model, report = imported
    links = [link.get("name") for link in _solid(urdf)]
    assert len(links) == 11
    assert sorted(report.bodies) == sorted(links)
    assert report.root_bodies == ["panda_link0"]
    assert model.nv == 9


def test_masses_centres_and_inertias_are_those_of_the_text(imported, urdf):
    model, _ = imported
    for link in _solid(urdf):
        inertial = link.find("inertial")
        mass = float(inertial.find("mass").get("value"))
        body = model.body(link.get("name"))
        assert body.mass[0] == pytest.approx(mass, rel=1e-6)
        values = {key: float(inertial.find("inertia").get(key)) for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")}
        tensor = np.array(
            [
                [values["ixx"], values["ixy"], values["ixz"]],
                [values["ixy"], values["iyy"], values["iyz"]],
                [values["ixz"], values["iyz"], values["izz"]],
            ]
        )
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, body.iquat)
        turn = turn.reshape(3, 3)
        np.testing.assert_allclose(body.ipos, _numbers(inertial.find("origin"), "xyz"), atol=1e-7)
        ours = turn @ np.diag(body.inertia) @ turn.T
        np.testing.assert_allclose(ours, tensor, atol=1e-5 * np.trace(tensor), err_msg=link.get("name"))


def test_limits_and_speeds_are_those_of_the_text(imported, urdf):
    model, report = imported
    moving = [joint for joint in urdf.findall("joint") if joint.get("type") != "fixed"]
    assert len(moving) == 9
    for joint in moving:
        name, limit = joint.get("name"), joint.find("limit")
        ours = model.joint(name)
        assert ours.limited[0]
        np.testing.assert_allclose(ours.range, [float(limit.get("lower")), float(limit.get("upper"))], atol=1e-6)
        assert report.joint_velocity_limits[name] == pytest.approx(float(limit.get("velocity")), rel=1e-6)
        effort = float(limit.get("effort"))
        np.testing.assert_allclose(model.jnt_actfrcrange[ours.id], (-effort, effort), rtol=1e-6)


def test_the_second_finger_mimics_the_first(imported, urdf):
    model, _ = imported
    (mimic,) = [joint for joint in urdf.findall("joint") if joint.find("mimic") is not None]
    assert model.eq_type.tolist() == [int(mujoco.mjtEq.mjEQ_JOINT)]
    assert model.joint(model.eq_obj1id[0]).name == mimic.get("name")
    assert model.joint(model.eq_obj2id[0]).name == mimic.find("mimic").get("joint")
    np.testing.assert_allclose(model.eq_data[0, :5], [0, 1, 0, 0, 0], atol=1e-7)


def test_forward_kinematics_are_those_of_the_text(imported, urdf):
    model, _ = imported
    data = mujoco.MjData(model)
    random = np.random.default_rng(0)
    joints = urdf.findall("joint")
    for _ in range(20):
        positions = {
            joint.get("name"): random.uniform(float(limit.get("lower")), float(limit.get("upper")))
            for joint in joints
            if (limit := joint.find("limit")) is not None
        }
        for name, value in positions.items():
            data.qpos[model.joint(name).qposadr[0]] = value
        mujoco.mj_kinematics(model, data)
        poses = {"panda_link0": np.eye(4)}
        waiting = list(joints)
        while waiting:
            joint = waiting.pop(0)
            parent = joint.find("parent").get("link")
            if parent in poses:
                moved = _moved(joint, positions.get(joint.get("name"), 0.0))
                poses[joint.find("child").get("link")] = poses[parent] @ moved
            else:
                waiting.append(joint)
        for link in (link.get("name") for link in _solid(urdf)):
            pose = poses[link]
            np.testing.assert_allclose(data.body(link).xpos, pose[:3, 3], atol=2e-6, err_msg=link)
            np.testing.assert_allclose(data.body(link).xmat.reshape(3, 3), pose[:3, :3], atol=2e-6, err_msg=link)


def test_drawn_and_colliding_meshes_come_along(imported, urdf):
    """Ten meshes to look at, and as many colliders as the URDF has collision elements."""
    model, _ = imported
    seen = np.count_nonzero((model.geom_contype == 0) & (model.geom_conaffinity == 0))
    assert seen >= len(urdf.findall("link/visual"))
    assert np.count_nonzero(model.geom_contype | model.geom_conaffinity) == len(urdf.findall("link/collision"))


def test_the_arm_of_the_page_on_own_robots_is_fixed_and_keeps_its_limits(third_party, tmp_path):
    page = Path(__file__).parents[2] / "docs" / "own_robot.md"
    text = page.read_text().split('```xml title="my_arm.urdf"\n')[1].split("```")[0]
    (tmp_path / "my_arm.urdf").write_text(text)
    environment = third_party.environment("urdf", CONVERTERS, ("numpy", "numpy.libs"))
    task = [(str(tmp_path / "my_arm.urdf"), str(tmp_path / "my_arm"), [])]
    (stage,) = environment.run(Path(__file__).with_name("usd_convert.py"), task, tmp_path)
    assert Path(stage) == tmp_path / "my_arm" / "my_arm.usda"
    spec, report = load(stage)
    model = spec.compile()
    assert (report.bodies, report.joints, model.nv, model.nu) == (["base", "upper", "hand"], ["joint1", "joint2"], 2, 0)
    np.testing.assert_allclose(model.jnt_range, [[-1.5, 1.5], [-2.0, 2.0]], atol=1e-6)
    np.testing.assert_allclose(model.jnt_actfrcrange, [[-60.0, 60.0], [-30.0, 30.0]], atol=1e-6)
    assert model.body_mass.sum() == pytest.approx(2.0 + 1.5 + 0.8)

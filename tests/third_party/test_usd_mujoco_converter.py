"""Robots of other packages: MJCF -> mujoco-usd-converter -> import, against MuJoCo's own compile of the same MJCF.

USD keeps most of these numbers as float32 (1.2e-7 relative), so everything must agree to 1e-5. A stage has no prim for
a free joint: it is matched by its body.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import gymnasium
import mujoco
import numpy as np
import pytest

from lift_lab.usd import load

CONVERTERS = [
    "mujoco-usd-converter==0.8.0",
    "usd-exchange==3.0.1",
    "newton-usd-schemas==0.6.0",
    "numpy-stl==4.1.1",
    "python-utils==4.2.0",
    "typing-extensions==4.16.0",
    "tinyobjloader==2.0.0rc13",
    "mujoco==3.16.0",
]
PANDA = "dm-robotics-panda==0.4.8"
MJLAB = "mjlab==1.6.0"
ENVIRONMENTS = {"mjcf": CONVERTERS}
WHEELS = (PANDA, MJLAB)
RTOL = 1e-5
COARSE = {"humanoid": 1e-4}
"""Of a body turned by 0.004 rad the converter takes the angle from the arc cosine of a float32 near one: its half unit
in the last place, 3e-8, over the sine of half the angle, 0.002, is 3e-5 rad, and two such bodies follow each other."""
pytestmark = pytest.mark.slow

ROBOTS = ("panda", "g1", "go1", "yam", "humanoid", "ant")
GAINS = {"panda": (400.0, 40.0), "g1": (75.0, 5.0), "go1": (35.0, 0.5), "yam": (100.0, 4.0)}
"""Stiffness and damping of the position actuators given to robots whose MJCF has none."""


def _with_position_actuators(spec: mujoco.MjSpec, kp: float, kv: float, effort: float) -> None:
    driven = {actuator.target for actuator in spec.actuators}
    for joint in spec.joints:
        if joint.type == mujoco.mjtJoint.mjJNT_HINGE and joint.name not in driven:
            actuator = spec.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
            actuator.set_to_position(kp=kp, kv=kv)
            actuator.ctrllimited, actuator.ctrlrange = mujoco.mjtLimited.mjLIMITED_TRUE, joint.range
            actuator.forcelimited, actuator.forcerange = mujoco.mjtLimited.mjLIMITED_TRUE, (-effort, effort)


def _panda(folder: Path) -> mujoco.MjSpec:
    """Arm and hand, which the package keeps in two files, joined at the flange."""
    arm = mujoco.MjSpec.from_file(str(folder / "panda.xml"))
    hand = mujoco.MjSpec.from_file(str(folder / "panda_hand.xml"))
    frame = arm.body("panda_link8").add_frame(quat=[np.cos(np.pi / 8), 0, 0, -np.sin(np.pi / 8)])
    arm.attach(hand, frame=frame, prefix="hand_")
    return arm


@dataclass
class Pair:
    """MuJoCo's model of an MJCF and the one imported from its conversion, with matching indices."""

    theirs: mujoco.MjModel
    ours: mujoco.MjModel
    bodies: list[tuple[int, int]]
    joints: list[tuple[int, int]]
    tolerance: float

    def columns(self, kind: str) -> tuple[np.ndarray, np.ndarray]:
        """Indices of all joints in qpos or in qvel, in the same order for both models."""
        widths = {"qpos": {0: 7, 1: 4}, "qvel": {0: 6, 1: 3}}[kind]
        field = {"qpos": "jnt_qposadr", "qvel": "jnt_dofadr"}[kind]
        found = []
        for side, model in enumerate((self.theirs, self.ours)):
            starts = [(getattr(model, field)[pair[side]], int(model.jnt_type[pair[side]])) for pair in self.joints]
            found.append(np.concatenate([np.arange(a, a + widths.get(kind, 1)) for a, kind in starts]))
        return found[0], found[1]


def _pair(theirs: mujoco.MjModel, ours: mujoco.MjModel, tolerance: float) -> Pair:
    bodies, joints = [(0, 0)], []
    our_bodies = {ours.body(i).name: i for i in range(ours.nbody)}
    our_joints = {ours.joint(i).name: i for i in range(ours.njnt)}
    for i in range(1, theirs.nbody):
        name = theirs.body(i).name
        if name:  # a body without a name is compared through those that hang from it
            bodies.append((i, our_bodies[name]))
    for j in range(theirs.njnt):
        free = theirs.jnt_type[j] == mujoco.mjtJoint.mjJNT_FREE
        body = dict(bodies).get(theirs.jnt_bodyid[j])
        joints.append((j, ours.body_jntadr[body] if free else our_joints[theirs.joint(j).name]))
    return Pair(theirs, ours, bodies, joints, tolerance)


@pytest.fixture(scope="module")
def pairs(third_party, tmp_path_factory):
    """Robot -> pair of models."""
    environment = third_party.environment("mjcf", CONVERTERS, ("numpy", "numpy.libs"))
    folder = tmp_path_factory.mktemp("mjcf")
    panda = third_party.wheel(PANDA, "dm_robotics/panda/assets/panda/") / "dm_robotics/panda/assets/panda"
    mjlab = third_party.wheel(MJLAB, "mjlab/asset_zoo/robots/") / "mjlab/asset_zoo/robots"
    gym = Path(gymnasium.__file__).parent / "envs/mujoco/assets"
    specs = {"panda": _panda(panda)}
    for name, package in (("g1", "unitree_g1"), ("go1", "unitree_go1"), ("yam", "i2rt_yam")):
        specs[name] = mujoco.MjSpec.from_file(str(mjlab / package / "xmls" / f"{name}.xml"))
        specs[name].meshdir = str(mjlab / package / "xmls" / "assets")
    specs["panda"].meshdir = specs["panda"].texturedir = str(panda)
    files = {name: gym / f"{name}.xml" for name in ("humanoid", "ant")}
    for name, spec in specs.items():
        spec.modelname = name
        _with_position_actuators(spec, *GAINS[name], effort=87.0)
        spec.compile()
        files[name] = folder / f"{name}.xml"
        files[name].write_text(spec.to_xml())
    tasks = [(str(files[name]), str(folder / name), []) for name in ROBOTS]
    stages = environment.run(Path(__file__).with_name("usd_convert.py"), tasks, folder)
    return {
        name: _pair(mujoco.MjModel.from_xml_path(str(files[name])), load(stage)[0].compile(), COARSE.get(name, RTOL))
        for name, stage in zip(ROBOTS, stages, strict=True)
    }


@pytest.fixture(params=ROBOTS)
def pair(pairs, request):
    return pairs[request.param]


def _close(ours, theirs, scale=None, what="", tolerance=RTOL) -> None:
    """Agreement to `tolerance` of `scale`, or of the largest of their values."""
    theirs, ours = np.asarray(theirs, dtype=float), np.asarray(ours, dtype=float)
    scale = np.abs(theirs).max(initial=1e-9) if scale is None else scale
    np.testing.assert_array_less(np.abs(ours - theirs) / scale, tolerance, err_msg=what)


def _states(pair: Pair, count: int = 5):
    """Data of both models in the same random states within the joint ranges, with the same random commands."""
    random = np.random.default_rng(0)
    (q, q_ours), (v, v_ours) = pair.columns("qpos"), pair.columns("qvel")
    for _ in range(count):
        theirs, ours = mujoco.MjData(pair.theirs), mujoco.MjData(pair.ours)
        for joint in range(pair.theirs.njnt):
            at = pair.theirs.jnt_qposadr[joint]
            if pair.theirs.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE:
                quat = random.normal(size=4)
                theirs.qpos[at : at + 7] = [*random.normal(size=3), *quat / np.linalg.norm(quat)]
            else:
                low, high = pair.theirs.jnt_range[joint] if pair.theirs.jnt_limited[joint] else (-1.0, 1.0)
                theirs.qpos[at] = random.uniform(low, high)
        theirs.qvel[:] = random.normal(size=pair.theirs.nv)
        theirs.ctrl[:] = random.uniform(-1.0, 1.0, size=pair.theirs.nu)
        ours.qpos[q_ours], ours.qvel[v_ours] = theirs.qpos[q], theirs.qvel[v]
        for i, j in _actuators(pair):
            ours.ctrl[j] = theirs.ctrl[i]
        mujoco.mj_forward(pair.theirs, theirs)
        mujoco.mj_forward(pair.ours, ours)
        yield theirs, ours


def _actuators(pair: Pair) -> list[tuple[int, int]]:
    """Actuators in pairs: by name, those without one in their order."""
    names = {pair.ours.actuator(i).name: i for i in range(pair.ours.nu)}
    return [(i, names.get(pair.theirs.actuator(i).name, i)) for i in range(pair.theirs.nu)]


def test_the_import_has_the_same_bodies_joints_and_actuators(pair):
    theirs, ours = pair.theirs, pair.ours
    static = ours.nbody - theirs.nbody
    assert static in (0, 1)  # a floor hangs from the world in MJCF, from a body of its own in the import
    assert (ours.njnt, ours.nq, ours.nv, ours.nu, ours.neq, ours.ntendon) == (
        theirs.njnt, theirs.nq, theirs.nv, theirs.nu, theirs.neq, theirs.ntendon,
    )  # fmt: skip
    assert sorted(j for _, j in pair.joints) == list(range(ours.njnt))


def test_bodies_are_where_mujoco_puts_them(pair):
    for theirs, ours in _states(pair):
        extent = np.abs(theirs.xpos - theirs.xpos[1]).max() + 1.0
        for i, j in pair.bodies:
            _close(ours.xpos[j], theirs.xpos[i], extent, pair.theirs.body(i).name, pair.tolerance)
            _close(ours.xmat[j], theirs.xmat[i], 1.0, pair.theirs.body(i).name, pair.tolerance)


def test_masses_and_the_mass_matrix_agree(pair):
    i, j = np.array(pair.bodies).T
    _close(pair.ours.body_mass[j], pair.theirs.body_mass[i], np.maximum(pair.theirs.body_mass[i], 1e-9))
    v, v_ours = pair.columns("qvel")
    for theirs, ours in _states(pair):
        full, full_ours = np.zeros((pair.theirs.nv,) * 2), np.zeros((pair.ours.nv,) * 2)
        mujoco.mj_fullM(pair.theirs, theirs, full)
        mujoco.mj_fullM(pair.ours, ours, full_ours)
        diagonal = np.sqrt(np.diag(full))
        scale = np.outer(diagonal, diagonal)[np.ix_(v, v)]
        _close(full_ours[np.ix_(v_ours, v_ours)], full[np.ix_(v, v)], scale, tolerance=pair.tolerance)


@pytest.mark.parametrize("force", ["qfrc_bias", "qfrc_passive", "qfrc_gravcomp", "qfrc_actuator", "qfrc_smooth"])
def test_forces_agree(pair, force):
    v, v_ours = pair.columns("qvel")
    for theirs, ours in _states(pair):
        if np.abs(getattr(theirs, force)).max() > 0 or np.abs(getattr(ours, force)).max() > 0:
            _close(getattr(ours, force)[v_ours], getattr(theirs, force)[v], tolerance=pair.tolerance)


def test_limits_agree(pair):
    for i, j in pair.joints:
        name = pair.theirs.joint(i).name
        assert pair.ours.jnt_limited[j] == pair.theirs.jnt_limited[i], name
        if pair.theirs.jnt_limited[i]:
            _close(pair.ours.jnt_range[j], pair.theirs.jnt_range[i], what=name)
        assert pair.ours.jnt_actfrclimited[j] == pair.theirs.jnt_actfrclimited[i], name
        if pair.theirs.jnt_actfrclimited[i]:
            _close(pair.ours.jnt_actfrcrange[j], pair.theirs.jnt_actfrcrange[i], what=name)
        _close(pair.ours.jnt_solref[j], pair.theirs.jnt_solref[i], what=name)
        if pair.theirs.jnt_type[i] != mujoco.mjtJoint.mjJNT_FREE:  # has no limit to keep a margin from
            _close(pair.ours.jnt_margin[j], pair.theirs.jnt_margin[i], what=name)


def test_joints_resist_alike(pair):
    v, v_ours = pair.columns("qvel")
    for field in ("dof_armature", "dof_damping", "dof_frictionloss"):
        _close(getattr(pair.ours, field)[v_ours], getattr(pair.theirs, field)[v], what=field)


def test_actuators_agree(pair):
    for i, j in _actuators(pair):
        name = pair.theirs.actuator(i).name
        for field in ("gainprm", "biasprm", "dynprm", "gear", "ctrlrange", "forcerange"):
            theirs, ours = (getattr(m, f"actuator_{field}")[k] for m, k in ((pair.theirs, i), (pair.ours, j)))
            _close(ours, theirs, what=f"{name} {field}")
        for field in ("gaintype", "biastype", "dyntype", "trntype", "ctrllimited", "forcelimited"):
            theirs, ours = (getattr(m, f"actuator_{field}")[k] for m, k in ((pair.theirs, i), (pair.ours, j)))
            assert theirs == ours, f"{name} {field}"


def test_equalities_and_tendons_agree(pair):
    theirs, ours = pair.theirs, pair.ours
    np.testing.assert_array_equal(np.sort(ours.eq_type), np.sort(theirs.eq_type))
    if theirs.ntendon:
        for their_data, our_data in _states(pair, 2):
            _close(our_data.ten_length, their_data.ten_length, 1.0)
    joint = mujoco.mjtEq.mjEQ_JOINT
    for i in np.flatnonzero(theirs.eq_type == joint):
        names = [theirs.joint(theirs.eq_obj1id[i]).name, theirs.joint(theirs.eq_obj2id[i]).name]
        found = [k for k in np.flatnonzero(ours.eq_type == joint) if ours.joint(ours.eq_obj1id[k]).name == names[0]]
        assert [ours.joint(ours.eq_obj2id[k]).name for k in found] == names[1:]
        _close(ours.eq_data[found[0], :5], theirs.eq_data[i, :5])

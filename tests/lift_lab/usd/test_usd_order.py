"""PhysX's order of bodies and joints, against lists that public Isaac Lab deployments of those robots publish."""

import pytest

# limbs of the Unitree G1 (29 joints) in the order of its SDK, which is also that of its MuJoCo model
_G1_LIMBS = (
    ("pelvis", [f"left_{j}" for j in ("hip_pitch", "hip_roll", "hip_yaw", "knee", "ankle_pitch", "ankle_roll")]),
    ("pelvis", [f"right_{j}" for j in ("hip_pitch", "hip_roll", "hip_yaw", "knee", "ankle_pitch", "ankle_roll")]),
    ("pelvis", ["waist_yaw", "waist_roll", "waist_pitch"]),
    *(
        ("waist_pitch_link", [f"{side}_{j}" for j in ("shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow",
                                                      "wrist_roll", "wrist_pitch", "wrist_yaw")])
        for side in ("left", "right")
    ),
)  # fmt: skip
# SDK numbers in Isaac Lab's order: `joint_ids_map` of unitree_rl_lab's deploy.yaml, `mujoco_to_isaaclab` of
# GR00T-WholeBodyControl's policy_parameters.hpp
_G1_IDS = [0, 6, 12, 1, 7, 13, 2, 8, 14, 3, 9, 15, 22, 4, 10, 16, 23, 5, 11, 17, 24, 18, 25, 19, 26, 20, 27, 21, 28]


def _robot(author, root, limbs, scope="/Robot/joints"):
    """Bodies beside each other, and joints in a scope of their own, limb by limb."""
    stage = author()
    stage.body(f"/Robot/{root}")
    for _, joints in limbs:
        for joint in joints:
            stage.body(f"/Robot/{joint}_link")
    for parent, joints in limbs:
        for joint in joints:
            stage.joint(
                f"{scope}/{joint}",
                "RevoluteJoint",
                f"/Robot/{parent}",
                f"/Robot/{joint}_link",
                axis="Y",
                limits=(-9, 9),
            )
            parent = f"{joint}_link"
    return stage


def _scalar(report, *free):
    return [name for name in report.joints_breadth_first if name not in free]


def test_a_g1_has_the_joint_order_of_its_public_deployments(author):
    _, report = _robot(author, "pelvis", _G1_LIMBS).load()
    sdk = [joint for _, joints in _G1_LIMBS for joint in joints]
    assert _scalar(report, "pelvis") == [sdk[i] for i in _G1_IDS]
    assert report.bodies_breadth_first == ["pelvis", *(f"{sdk[i]}_link" for i in _G1_IDS)]
    assert report.bodies == ["pelvis", *(f"{joint}_link" for joint in sdk)]  # the model's stays depth first


def test_a_go2_has_the_joint_order_of_its_public_deployments(author):
    legs = ("FL", "FR", "RL", "RR")
    _, report = _robot(
        author, "base", [("base", [f"{leg}_{j}" for j in ("hip", "thigh", "calf")]) for leg in legs]
    ).load()
    expected = [f"{leg}_{joint}" for joint in ("hip", "thigh", "calf") for leg in legs]
    assert _scalar(report, "base") == expected


def test_children_follow_their_joints_on_the_stage_and_not_names_or_bodies(author):
    """Isaac Lab's humanoid names its right limbs first; PhysX creates links joint by joint."""
    stage = author()
    for name in ("torso", "a_arm", "b_arm", "c_arm", "b_hand", "c_hand"):
        stage.body(f"/Robot/{name}")
    for name, parent, child in (
        ("j5", "c_arm", "c_hand"),
        ("j4", "torso", "c_arm"),
        ("j3", "b_arm", "torso"),  # authored child first: the order is that of the joints all the same
        ("j2", "torso", "a_arm"),
        ("j1", "b_arm", "b_hand"),
    ):
        stage.joint(f"/Robot/{name}", "RevoluteJoint", f"/Robot/{parent}", f"/Robot/{child}", axis="Z", limits=(-9, 9))
    stage.joint("/Robot/hold", "FixedJoint", None, "/Robot/torso")
    _, report = stage.load()
    assert report.bodies_breadth_first == ["torso", "c_arm", "b_arm", "a_arm", "c_hand", "b_hand"]
    assert report.joints_breadth_first == ["j4", "j3", "j2", "j5", "j1"]
    assert report.bodies_on_stage == ["torso", "a_arm", "b_arm", "c_arm", "b_hand", "c_hand"]


@pytest.mark.parametrize("child_first", [False, True])
def test_axes_of_one_joint_come_in_physx_s_order(author, child_first):
    """X, Y, Z, whichever way the joint was authored; the engine's order inside the joint is reversed with it."""
    stage = author()
    stage.body("/Robot/base")
    stage.body("/Robot/ball")
    pair = ("/Robot/ball", "/Robot/base") if child_first else ("/Robot/base", "/Robot/ball")
    joint = stage.joint("/Robot/hip", "Joint", *pair)
    for axis in ("transX", "transY", "transZ"):
        stage.attrs(joint, {f"limit:{axis}:physics:low": 1.0, f"limit:{axis}:physics:high": -1.0})
        joint.AddAppliedSchema(f"PhysicsLimitAPI:{axis}")
    for axis in ("rotX", "rotY", "rotZ"):
        stage.attrs(joint, {f"limit:{axis}:physics:low": -30.0, f"limit:{axis}:physics:high": 30.0})
        joint.AddAppliedSchema(f"PhysicsLimitAPI:{axis}")
    stage.joint("/Robot/hold", "FixedJoint", None, "/Robot/base")
    _, report = stage.load()
    forward = ["hip_rotX", "hip_rotY", "hip_rotZ"]
    assert report.joints == (forward[::-1] if child_first else forward)
    assert report.joints_breadth_first == forward


def test_what_only_the_model_has_comes_last(author):
    """A joint that closes a loop moves a carrier of the importer's own; PhysX numbers no such body."""
    stage = author()
    for i, name in enumerate(("base", "left", "right")):
        stage.body(f"/Robot/{name}", pos=(0, i, 0))
    stage.joint("/Robot/hold", "FixedJoint", None, "/Robot/base")
    stage.joint("/Robot/jl", "RevoluteJoint", "/Robot/base", "/Robot/left", axis="X", limits=(-9, 9), pos0=(0, 1, 0))
    stage.joint("/Robot/jr", "RevoluteJoint", "/Robot/base", "/Robot/right", axis="X", limits=(-9, 9), pos0=(0, 2, 0))
    stage.joint(
        "/Robot/loop", "PrismaticJoint", "/Robot/left", "/Robot/right", axis="Y", limits=(-1, 1), pos0=(0, 1, 0)
    )
    model, report = stage.load()
    assert report.bodies_breadth_first == ["base", "left", "right", "loop_carrier"]
    assert report.joints_breadth_first == ["jl", "jr", "loop"]
    assert sorted(report.bodies_breadth_first) == sorted(report.bodies_on_stage) == sorted(report.bodies)
    assert model.nbody == 5

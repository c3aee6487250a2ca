"""Isaac Lab's names for an asset's state: what they show, and that an editor finds each of them in the source."""

import ast
import inspect

import pytest
import torch
from arm_and_box import arm_cfg, box_cfg, implicit, start

from lift_lab.assets import ArticulationData

ALL, LIN, ANG, POS, QUAT = slice(None), slice(0, 3), slice(3, 6), slice(0, 3), slice(3, 7)
NAMES = {
    "root_pos_w": ("root_link_state_w", POS),
    "root_quat_w": ("root_link_state_w", QUAT),
    "root_pose_w": ("root_link_state_w", slice(0, 7)),
    "root_vel_w": ("root_com_state_w", slice(7, 13)),
    "root_lin_vel_w": ("root_com_state_w", slice(7, 10)),
    "root_ang_vel_w": ("root_com_state_w", slice(10, 13)),
    "root_com_lin_vel_w": ("root_com_state_w", slice(7, 10)),
    "root_com_ang_vel_w": ("root_com_state_w", slice(10, 13)),
    "root_com_pos_w": ("root_com_state_w", POS),
    "root_com_quat_w": ("root_com_state_w", QUAT),
    "root_link_lin_vel_w": ("root_link_state_w", slice(7, 10)),
    "root_link_ang_vel_w": ("root_link_state_w", slice(10, 13)),
    "root_com_lin_vel_b": ("root_lin_vel_b", ALL),
    "root_com_ang_vel_b": ("root_ang_vel_b", ALL),
    "root_link_ang_vel_b": ("root_ang_vel_b", ALL),
    "body_pos_w": ("body_link_state_w", POS),
    "body_quat_w": ("body_link_state_w", QUAT),
    "body_pose_w": ("body_link_state_w", slice(0, 7)),
    "body_vel_w": ("body_com_state_w", slice(7, 13)),
    "body_lin_vel_w": ("body_com_state_w", slice(7, 10)),
    "body_ang_vel_w": ("body_com_state_w", slice(10, 13)),
    "body_com_lin_vel_w": ("body_com_state_w", slice(7, 10)),
    "body_com_ang_vel_w": ("body_com_state_w", slice(10, 13)),
    "body_link_lin_vel_w": ("body_link_state_w", slice(7, 10)),
    "body_link_ang_vel_w": ("body_link_state_w", slice(10, 13)),
    "body_acc_w": ("body_com_acc_w", ALL),
    "body_lin_acc_w": ("body_com_acc_w", LIN),
    "body_ang_acc_w": ("body_com_acc_w", ANG),
    "body_com_lin_acc_w": ("body_com_acc_w", LIN),
    "body_com_ang_acc_w": ("body_com_acc_w", ANG),
    "com_pos_b": ("body_com_pose_b", POS),
    "com_quat_b": ("body_com_pose_b", QUAT),
}
JOINT_NAMES = {
    "joint_limits": "joint_pos_limits",
    "default_joint_limits": "default_joint_pos_limits",
    "joint_velocity_limits": "joint_vel_limits",
    "joint_friction": "joint_friction_coeff",
    "default_joint_friction": "default_joint_friction_coeff",
}


@pytest.fixture(scope="module")
def scene(arm_file):
    sim, scene = start(arm=arm_cfg(arm_file, implicit()), box=box_cfg())
    scene["box"].write_root_velocity_to_sim(torch.tensor([[0.1, 0.2, 0.3, 1.0, 2.0, 3.0]]).repeat(3, 1))
    for _ in range(5):
        sim.step(render=False)
        scene.update(sim.get_physics_dt())
    return scene


@pytest.mark.parametrize("entity", ["arm", "box"])
@pytest.mark.parametrize("name", NAMES)
def test_a_name_shows_its_part_of_the_state(scene, entity, name):
    source, columns = NAMES[name]
    data = scene[entity].data
    expected = getattr(data, source)[..., columns]
    torch.testing.assert_close(getattr(data, name), expected, rtol=0, atol=0)
    if entity == "box" and "vel" in name:
        assert expected.abs().max() > 0.05  # the box moves: a part of zeros would show nothing


@pytest.mark.parametrize("name", JOINT_NAMES)
def test_an_older_name_is_the_newer_ones_tensor(scene, name):
    data = scene["arm"].data
    assert getattr(data, name) is getattr(data, JOINT_NAMES[name])


def test_every_public_attribute_of_an_articulations_data_is_written_in_its_classes(scene):
    written = set()
    for cls in ArticulationData.__mro__[:-1]:
        for node in ast.walk(ast.parse(inspect.getsource(cls))):
            if isinstance(node, ast.FunctionDef):
                written.add(node.name)
            elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
                written.add(node.target.id)
            elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
                written.add(node.attr)
    public = {name for name in dir(scene["arm"].data) if not name.startswith("_")}
    assert public - written == set()

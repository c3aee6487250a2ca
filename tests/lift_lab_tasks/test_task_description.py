"""A task described for a person."""

import io

import pytest
from rich.console import Console

import lift_lab_tasks  # noqa: F401
from lift_lab.utils.errors import NotFoundError
from lift_lab_tasks.utils.describe import describe


@pytest.fixture(scope="module")
def text():
    stream = io.StringIO()
    overrides = ["env.rewards.lifting_object.weight=12.5", "env.sim.physx.bounce_threshold_velocity=0.1"]
    for table in describe("Lift-Cube-Franka-CL", overrides):
        Console(file=stream, width=300).print(table)
    return stream.getvalue()


def row(text, *words):
    """The lines that hold all words."""
    return [line for line in text.splitlines() if all(word in line for word in words)]


def test_spaces_and_terms_are_told_with_their_sizes(text):
    assert row(text, "observation 'policy'", "36 numbers")
    assert row(text, "action", "8 numbers")
    assert row(text, "target_object_position", "7", "generated_commands", "command_name=object_pose")


def test_rewards_are_told_with_weights_as_overridden(text):
    assert row(text, "lifting_object", "12.5", "object_is_lifted", "minimal_height=0.04")
    assert row(text, "joint_vel", "-0.0001", "joint_vel_l2", "asset_cfg=robot")


def test_events_terminations_curricula_commands_and_metrics_are_told(text):
    assert row(text, "reset_object_position", "reset", "reset_root_state_uniform", "y: (-0.25, 0.25)")
    assert row(text, "object_dropping", "terminal", "minimum_height=-0.05")
    assert row(text, "action_rate", "modify_reward_weight", "num_steps=18000")
    assert row(text, "object_pose", "ObjectPoseCommand", "pos_z=(0.25, 0.5)")
    assert row(text, "success", "max", "object_reached_goal", "threshold=0.02")
    assert row(text, "object_pose/position_error", "last", "command_position_error")


def test_physics_and_what_has_no_effect_are_told(text):
    assert row(text, "physics step", "0.005 s, 4 in each")
    assert row(text, "integrator", "implicitfast")
    assert row(text, "sim.physx.bounce_threshold_velocity")


def test_an_unknown_task_is_refused():
    with pytest.raises(NotFoundError, match="did you mean"):
        describe("Lift-Cube-Frank")

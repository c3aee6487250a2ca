"""Joint and gripper actions on a stand-in for an articulation."""

from types import SimpleNamespace

import pytest
import torch

import lift_lab.envs.mdp as mdp
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.string import resolve_matching_names

NAMES = ["j1", "j2", "left_finger", "right_finger"]
DEFAULT = torch.tensor([[0.1, 0.2, 0.3, 0.4]]).repeat(2, 1)


class _Arm:
    """Joints whose targets can be looked at."""

    num_joints = 4

    def __init__(self):
        self.data = SimpleNamespace(
            joint_pos=torch.tensor([[1.0, 2.0, 3.0, 4.0], [5.0, 6.0, 7.0, 8.0]]),
            default_joint_pos=DEFAULT.clone(),
            default_joint_vel=0.5 * DEFAULT,
            soft_joint_pos_limits=torch.tensor([[[-1.0, 3.0], [0.0, 2.0], [0.0, 1.0], [0.0, 1.0]]]).repeat(2, 1, 1),
            root_quat_w=torch.tensor([[1.0, 0.0, 0.0, 0.0]]).repeat(2, 1),
            body_quat_w=torch.tensor([[[0.5**0.5, 0.0, 0.0, 0.5**0.5]], [[1.0, 0.0, 0.0, 0.0]]]),
        )
        self.targets = {kind: torch.full((2, 4), torch.nan) for kind in ("position", "velocity", "effort")}

    def find_joints(self, keys, preserve_order=False):
        return resolve_matching_names(keys, NAMES, preserve_order)

    def find_bodies(self, keys):
        return resolve_matching_names(keys, ["base"])

    def _set(self, kind, target, joint_ids):
        self.targets[kind][:, joint_ids] = target

    def set_joint_position_target(self, target, joint_ids):
        self._set("position", target, joint_ids)

    def set_joint_velocity_target(self, target, joint_ids):
        self._set("velocity", target, joint_ids)

    def set_joint_effort_target(self, target, joint_ids):
        self._set("effort", target, joint_ids)


@pytest.fixture
def env():
    return SimpleNamespace(num_envs=2, device="cpu", step_dt=0.02, scene={"robot": _Arm()})


def _apply(env, cfg, action):
    term = cfg.class_type(cfg, env)
    term.process_actions(torch.tensor(action))
    term.apply_actions()
    return term, env.scene["robot"].targets


def test_a_position_action_is_scaled_and_added_to_the_default(env):
    cfg = mdp.JointPositionActionCfg(asset_name="robot", joint_names=[".*"], scale=0.5)
    term, targets = _apply(env, cfg, [[1.0, 2.0, 3.0, 4.0], [0.0, 0.0, 0.0, 2.0]])
    torch.testing.assert_close(targets["position"], DEFAULT + torch.tensor([[0.5, 1.0, 1.5, 2.0], [0, 0, 0, 1.0]]))
    assert term.action_dim == 4
    assert term._joint_ids == slice(None)
    torch.testing.assert_close(term.raw_actions[1], torch.tensor([0.0, 0.0, 0.0, 2.0]))


def test_scale_offset_and_clip_may_name_joints(env):
    cfg = mdp.JointPositionActionCfg(
        asset_name="robot",
        joint_names=["j.*"],
        scale={"j2": 10.0},
        offset={"j1": 1.0},
        use_default_offset=False,
        clip={"j2": (-5.0, 5.0)},
    )
    term, targets = _apply(env, cfg, [[1.0, 1.0], [2.0, -0.1]])
    torch.testing.assert_close(term.processed_actions, torch.tensor([[2.0, 5.0], [3.0, -1.0]]))
    torch.testing.assert_close(targets["position"][:, :2], term.processed_actions)
    assert targets["position"][:, 2:].isnan().all()
    torch.testing.assert_close(term.raw_actions, torch.tensor([[1.0, 1.0], [2.0, -0.1]]))


@pytest.mark.parametrize(("preserve_order", "expected"), [(False, [2.0, 1.0]), (True, [1.0, 2.0])])
def test_columns_follow_the_articulation_unless_told_otherwise(env, preserve_order, expected):
    cfg = mdp.JointPositionActionCfg(
        asset_name="robot",
        joint_names=["right_finger", "j1"],
        preserve_order=preserve_order,
        use_default_offset=False,
    )
    _, targets = _apply(env, cfg, [[1.0, 2.0], [1.0, 2.0]])
    # right_finger, then j1
    assert targets["position"][0, [3, 0]].tolist() == expected
    assert targets["position"][0, 1:3].isnan().all()


def test_a_relative_action_is_added_to_the_current_position(env):
    cfg = mdp.RelativeJointPositionActionCfg(asset_name="robot", joint_names=["j2", "left_finger"])
    term, targets = _apply(env, cfg, [[0.1, 0.2], [0.3, 0.4]])
    torch.testing.assert_close(targets["position"][:, 1:3], torch.tensor([[2.1, 3.2], [6.3, 7.4]]))
    assert not term.constant_over_substeps
    assert term._joint_ids == [1, 2]


@pytest.mark.parametrize(("use_zero_offset", "offset"), [(True, 0.0), (False, 0.5)])
def test_a_relative_action_has_an_offset_only_where_zero_does_not_replace_it(env, use_zero_offset, offset):
    cfg = mdp.RelativeJointPositionActionCfg(
        asset_name="robot", joint_names=["j2"], offset=0.5, use_zero_offset=use_zero_offset
    )
    _, targets = _apply(env, cfg, [[0.1], [0.3]])
    torch.testing.assert_close(targets["position"][:, 1], torch.tensor([2.1, 6.3]) + offset)


def test_velocity_and_effort_actions_set_their_own_targets(env):
    velocity = mdp.JointVelocityActionCfg(asset_name="robot", joint_names=["j1"])
    effort = mdp.JointEffortActionCfg(asset_name="robot", joint_names=["j1"], scale=3.0)
    _apply(env, velocity, [[1.0], [2.0]])
    _, targets = _apply(env, effort, [[1.0], [2.0]])
    torch.testing.assert_close(targets["velocity"][:, 0], torch.tensor([1.05, 2.05]))
    torch.testing.assert_close(targets["effort"][:, 0], torch.tensor([3.0, 6.0]))
    assert targets["position"].isnan().all()


def test_a_reset_zeroes_the_raw_action_of_its_environments(env):
    cfg = mdp.JointPositionActionCfg(asset_name="robot", joint_names=["j1"])
    term, _ = _apply(env, cfg, [[1.0], [2.0]])
    term.reset(torch.tensor([1]))
    assert term.raw_actions.tolist() == [[1.0], [0.0]]
    term.reset()
    assert term.raw_actions.tolist() == [[0.0], [0.0]]


def test_minus_one_to_one_spans_the_soft_limits(env):
    cfg = mdp.JointPositionToLimitsActionCfg(asset_name="robot", joint_names=["j.*"], scale=2.0)
    _, targets = _apply(env, cfg, [[0.25, -0.5], [9.0, -9.0]])
    # j1 within [-1, 3]: 0.5 of the way is 2; j2 within [0, 2]
    torch.testing.assert_close(targets["position"][:, :2], torch.tensor([[2.0, 0.0], [3.0, 0.0]]))


def test_the_moving_average_starts_at_the_joint_positions(env):
    cfg = mdp.EMAJointPositionToLimitsActionCfg(asset_name="robot", joint_names=["j1"], alpha=0.25)
    term = cfg.class_type(cfg, env)
    term.reset(torch.tensor([0]))
    term.process_actions(torch.ones(2, 1))
    # new target 3: from 1, and from 0 where there was no reset
    torch.testing.assert_close(term.processed_actions, torch.tensor([[1.5], [0.75]]))
    term.process_actions(-torch.ones(2, 1))
    torch.testing.assert_close(term.processed_actions, torch.tensor([[0.875], [0.3125]]))
    env.scene["robot"].data.joint_pos[0, 0] = 9.0  # far beyond the limits [-1, 3]
    term.reset(torch.tensor([0]))
    term.process_actions(torch.ones(2, 1))
    assert term.processed_actions[0] == 3.0
    bad = mdp.EMAJointPositionToLimitsActionCfg(asset_name="robot", joint_names=["j1"], alpha={"j1": 1.5})
    with pytest.raises(ConfigError, match="alpha"):
        bad.class_type(bad, env)


GRIPPER = {
    "asset_name": "robot",
    "joint_names": [".*_finger"],
    "open_command_expr": {".*_finger": 0.04},
    "close_command_expr": {"left_finger": 0.0, "right_finger": 0.01},
}


def test_a_negative_action_closes_the_gripper_and_any_other_opens_it(env):
    cfg = mdp.BinaryJointPositionActionCfg(**GRIPPER)
    term, targets = _apply(env, cfg, [[-1e-6], [0.0]])
    torch.testing.assert_close(targets["position"][:, 2:], torch.tensor([[0.0, 0.01], [0.04, 0.04]]))
    assert term.action_dim == 1
    assert term.constant_over_substeps


def test_a_boolean_action_opens_when_true(env):
    cfg = mdp.BinaryJointVelocityActionCfg(**GRIPPER)
    _, targets = _apply(env, cfg, [[True], [False]])
    torch.testing.assert_close(targets["velocity"][:, 2:], torch.tensor([[0.04, 0.04], [0.0, 0.01]]))


@pytest.mark.parametrize(("positive", "expected"), [(True, [0.0, 0.04]), (False, [0.04, 0.0])])
def test_an_absolute_action_opens_beyond_its_threshold(env, positive, expected):
    cfg = mdp.AbsBinaryJointPositionActionCfg(**GRIPPER, threshold=0.3, positive_threshold=positive)
    _, targets = _apply(env, cfg, [[0.2], [0.4]])
    assert targets["position"][:, 2].tolist() == pytest.approx(expected)


@pytest.mark.parametrize("positive", [True, False])
def test_an_absolute_action_at_its_threshold_closes(env, positive):
    cfg = mdp.AbsBinaryJointPositionActionCfg(**GRIPPER, threshold=0.5, positive_threshold=positive)
    _, targets = _apply(env, cfg, [[0.5], [0.5]])
    assert targets["position"][:, 2].tolist() == [0.0, 0.0]


def _open_at_each_step(env, term, actions: list[float]) -> list[bool]:
    """Whether the gripper of environment 0 is told to open, step by step; environment 1 stays open."""
    told = []
    for action in actions:
        term.process_actions(torch.tensor([[action], [1.0]]))
        told.append(bool(term.processed_actions[0, 0] > 0.03))
        assert term.processed_actions[1, 0] > 0.03
    return told


def test_a_gripper_that_closes_stays_closed_for_its_least_time(env):
    cfg = mdp.BinaryJointPositionActionCfg(**GRIPPER, min_close_time_s=3 * env.step_dt)
    term = cfg.class_type(cfg, env)
    actions = [1.0, -1.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0, 1.0]
    expected = [True, False, False, False, True, False, False, False, False, True]
    assert _open_at_each_step(env, term, actions) == expected


def test_a_reset_ends_the_least_time_of_a_closed_gripper(env):
    cfg = mdp.BinaryJointPositionActionCfg(**GRIPPER, min_close_time_s=3 * env.step_dt)
    term = cfg.class_type(cfg, env)
    assert _open_at_each_step(env, term, [-1.0]) == [False]
    term.reset(torch.tensor([0]))
    assert _open_at_each_step(env, term, [1.0, -1.0]) == [True, False]
    term.reset(torch.tensor([0]))
    # what closes in the first step of an episode has just begun to
    assert _open_at_each_step(env, term, [-1.0, 1.0, 1.0, 1.0]) == [False, False, False, True]


def test_the_least_time_of_a_closed_gripper_can_be_set_while_it_runs(env):
    cfg = mdp.BinaryJointPositionActionCfg(**GRIPPER)
    term = cfg.class_type(cfg, env)
    assert _open_at_each_step(env, term, [-1.0, 1.0]) == [False, True]
    term.set_min_close_time(2 * env.step_dt)
    assert _open_at_each_step(env, term, [-1.0, 1.0, 1.0]) == [False, False, True]
    with pytest.raises(ConfigError, match="min_close_time_s is -1"):
        term.set_min_close_time(-1.0)


def test_a_gripper_command_must_cover_every_joint(env):
    cfg = mdp.BinaryJointPositionActionCfg(**{**GRIPPER, "close_command_expr": {"left_finger": 0.0}})
    with pytest.raises(ConfigError, match="close_command_expr says nothing about right_finger"):
        cfg.class_type(cfg, env)


def test_a_non_holonomic_base_moves_where_it_is_heading(env):
    cfg = mdp.NonHolonomicActionCfg(
        asset_name="robot",
        body_name="base",
        x_joint_name="j1",
        y_joint_name="right_finger",
        yaw_joint_name="j2",
        scale=(2.0, 1.0),
        offset=(0.0, 0.1),
    )
    _, targets = _apply(env, cfg, [[0.5, 1.0], [0.5, 1.0]])
    velocity = targets["velocity"][:, [0, 3, 1]]
    # environment 0 is turned by 90 degrees
    torch.testing.assert_close(velocity, torch.tensor([[0.0, 1.0, 1.1], [1.0, 0.0, 1.1]]), atol=1e-6, rtol=0)
    # with both roots turned as far, the joints of environment 0 move along its heading, those of 1 across
    env.scene["robot"].data.root_quat_w[:] = env.scene["robot"].data.body_quat_w[0, 0]
    _, targets = _apply(env, cfg, [[0.5, 1.0], [0.5, 1.0]])
    velocity = targets["velocity"][:, [0, 3, 1]]
    torch.testing.assert_close(velocity, torch.tensor([[1.0, 0.0, 1.1], [0.0, -1.0, 1.1]]), atol=1e-6, rtol=0)

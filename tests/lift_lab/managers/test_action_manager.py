"""Actions: cut into slices, stored raw, zeroed by resets."""

from dataclasses import MISSING

import pytest
import torch

from lift_lab.managers import ActionManager, ActionTerm, ActionTermCfg
from lift_lab.utils import configclass


class Scaled(ActionTerm):
    def __init__(self, cfg, env):
        super().__init__(cfg, env)
        self._raw = torch.zeros(env.num_envs, cfg.dim)
        self._processed = torch.zeros(env.num_envs, cfg.dim)

    @property
    def action_dim(self):
        return self.cfg.dim

    @property
    def raw_actions(self):
        return self._raw

    @property
    def processed_actions(self):
        return self._processed

    def process_actions(self, actions):
        self._raw[:] = actions
        self._processed = actions * self.cfg.scale

    def apply_actions(self):
        self._env.calls.append((self.cfg.asset_name, self._processed[0].tolist()))

    def reset(self, env_ids=None):
        self._raw[env_ids] = 0.0


class Drawn(Scaled):
    def _set_debug_vis_impl(self, debug_vis):
        self._env.calls.append(("made", debug_vis))

    def _debug_vis_callback(self, event):
        self._env.calls.append("drawn")


@configclass
class ScaledCfg(ActionTermCfg):
    class_type: type = Scaled
    dim: int = MISSING
    scale: float = 1.0


@configclass
class Actions:
    arm = ScaledCfg(asset_name="robot", dim=2, scale=10.0)
    gone = None
    gripper = ScaledCfg(asset_name="object", dim=1, scale=100.0)


@pytest.fixture
def manager(env):
    return ActionManager(Actions(), env)


def row_of(action, num_envs=4):
    return torch.tensor([action]).repeat(num_envs, 1)


def test_each_term_gets_its_slice_in_declaration_order(env, manager):
    assert manager.active_terms == ["arm", "gripper"]
    assert manager.action_term_dim == [2, 1]
    assert manager.total_action_dim == 3
    manager.process_action(row_of([1.0, 2.0, 3.0]))
    manager.apply_action()
    assert env.calls == [("robot", [10.0, 20.0]), ("object", [300.0])]
    assert manager.get_term("arm").raw_actions[3].tolist() == [1.0, 2.0]


def test_the_raw_action_and_the_one_before_are_kept(manager):
    assert torch.equal(manager.action, torch.zeros(4, 3))
    for value in (1.0, 2.0, 3.0):
        manager.process_action(torch.full((4, 3), value))
    assert torch.equal(manager.action, torch.full((4, 3), 3.0))
    assert torch.equal(manager.prev_action, torch.full((4, 3), 2.0))


def test_the_callers_action_is_copied(manager):
    action = torch.ones(4, 3)
    manager.process_action(action)
    action += 1
    assert torch.equal(manager.action, torch.ones(4, 3))


def test_a_reset_zeroes_both_actions_and_the_terms(manager):
    manager.process_action(torch.ones(4, 3))
    manager.process_action(torch.full((4, 3), 2.0))
    assert manager.reset([0, 2]) == {}
    assert manager.action[:, 0].tolist() == [0.0, 2.0, 0.0, 2.0]
    assert manager.prev_action[:, 0].tolist() == [0.0, 1.0, 0.0, 1.0]
    assert manager.get_term("gripper").raw_actions[:, 0].tolist() == [0.0, 2.0, 0.0, 2.0]
    manager.reset()
    assert not manager.action.any()


def test_actions_given_in_inference_mode_can_be_reset_outside(manager):
    with torch.inference_mode():
        manager.process_action(torch.ones(4, 3))
    manager.reset([1])
    assert manager.action[:, 0].tolist() == [1.0, 0.0, 1.0, 1.0]


@pytest.mark.parametrize("shape", [(4, 2), (3, 3), (3,)])
def test_an_action_of_another_shape_is_refused(manager, shape):
    with pytest.raises(ValueError, match=r"expected \(4, 3\).*'arm', 'gripper'"):
        manager.process_action(torch.zeros(shape))


def test_a_config_is_needed_but_may_be_empty(env):
    with pytest.raises(ValueError, match="no actions"):
        ActionManager(None, env)
    empty = ActionManager({}, env)
    empty.process_action(torch.zeros(4, 0))
    assert empty.action.shape == (4, 0)


def test_a_class_that_is_no_action_term_is_refused(env):
    with pytest.raises(TypeError, match="term 'arm': class_type must be a sub-class of ActionTerm"):
        ActionManager({"arm": ScaledCfg(class_type=lambda cfg, env: 3, asset_name="robot", dim=1)}, env)


def test_an_unknown_term_is_reported_with_the_closest_name(manager):
    with pytest.raises(KeyError, match="did you mean 'gripper'"):
        manager.get_term("griper")


def test_markers_are_made_at_the_first_frame_only(env, manager):
    drawn = ActionManager({"arm": ScaledCfg(class_type=Drawn, asset_name="robot", dim=1, debug_vis=True)}, env)
    assert env.calls == []
    drawn.update_debug_vis()
    drawn.update_debug_vis()
    drawn.set_debug_vis(False)
    drawn.update_debug_vis()
    assert env.calls == [("made", True), "drawn", "drawn", ("made", False)]
    assert drawn.has_debug_vis_implementation
    assert not manager.has_debug_vis_implementation
    manager.update_debug_vis()


def test_viewers_and_tables_show_every_term(manager):
    manager.process_action(row_of([1.0, 2.0, 3.0]))
    assert manager.get_active_iterable_terms(1) == [("arm", [1.0, 2.0]), ("gripper", [3.0])]
    assert "(shape: 3)" in str(manager)
    assert "gripper" in str(manager)
    assert manager.serialize()["arm"]["cfg"]["scale"] == 10.0

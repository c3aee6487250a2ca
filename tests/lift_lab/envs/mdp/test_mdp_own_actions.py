"""Action terms that a user derives from Isaac Lab's, with the attributes and the calls that those have."""

import pytest
import torch

import lift_lab.envs.mdp as mdp
from lift_lab.assets import ArticulationCfg
from lift_lab.envs import ManagerBasedEnv, ManagerBasedEnvCfg
from lift_lab.managers import ObservationGroupCfg, ObservationTermCfg
from lift_lab.scene import InteractiveSceneCfg
from lift_lab.utils import configclass
from lift_lab_assets import CARTPOLE_CFG

DECIMATION = 4


class LateEffort(mdp.JointEffortAction):
    """Its effort arrives two physics steps after the action."""

    applied: list[float]

    def process_actions(self, actions):
        super().process_actions(actions)
        self.applied = []

    def apply_actions(self):
        effort = self._processed_actions if len(self.applied) >= 2 else torch.zeros_like(self._processed_actions)
        self.applied.append(float(effort[0, 0]))
        self._asset.set_joint_effort_target(effort, joint_ids=self._joint_ids)


class Halved(mdp.JointEffortAction):
    """Processes its actions as Isaac Lab's does, halves them, and applies them as its base does."""

    def process_actions(self, actions):
        self._raw_actions[:] = actions
        self._processed_actions = self._raw_actions * self._scale + self._offset
        if self.cfg.clip is not None:
            self._processed_actions = torch.clamp(
                self._processed_actions, min=self._clip[:, :, 0], max=self._clip[:, :, 1]
            )
        self._processed_actions = 0.5 * self._processed_actions


class _Applies:
    """Something to derive from besides a term."""

    def apply_actions(self):
        """Apply nothing."""


def _env(class_type) -> ManagerBasedEnv:
    @configclass
    class SceneCfg(InteractiveSceneCfg):
        robot: ArticulationCfg = CARTPOLE_CFG.replace(prim_path="{ENV_REGEX_NS}/Robot")

    @configclass
    class Actions:
        effort = mdp.JointEffortActionCfg(
            class_type=class_type,
            asset_name="robot",
            joint_names=["slider_to_cart"],
            scale=100.0,
            clip={".*": (-30.0, 30.0)},
        )

    @configclass
    class Observations:
        @configclass
        class Policy(ObservationGroupCfg):
            position = ObservationTermCfg(func=mdp.joint_pos)

        policy: Policy = Policy()

    cfg = ManagerBasedEnvCfg(
        scene=SceneCfg(num_envs=2, env_spacing=4.0),
        actions=Actions(),
        observations=Observations(),
        decimation=DECIMATION,
        seed=1,
    )
    cfg.sim.device = "cpu"
    return ManagerBasedEnv(cfg)


def test_a_term_with_its_own_apply_actions_is_applied_at_every_physics_step(caplog):
    with caplog.at_level("INFO", "lift_lab"):
        env = _env(LateEffort)
    assert "every physics step is a call of its own, for the sake of env.actions.effort" in caplog.messages
    try:
        env.reset()
        env.step(torch.full((2, 1), 0.2))
        assert env.action_manager.get_term("effort").applied == pytest.approx([0.0, 0.0, 20.0, 20.0])
    finally:
        env.close()


def test_a_term_that_processes_actions_as_isaac_labs_does_finds_its_limits_and_joints():
    env = _env(Halved)
    try:
        env.reset()
        env.step(torch.tensor([[1.0], [-0.1]]))
        term = env.action_manager.get_term("effort")
        torch.testing.assert_close(term.processed_actions, torch.tensor([[15.0], [-5.0]]))
        assert [env.scene["robot"].joint_names[i] for i in term._joint_ids] == ["slider_to_cart"]
    finally:
        env.close()


def test_only_what_a_class_says_of_its_own_apply_actions_counts():
    class Mixed(_Applies, mdp.JointPositionAction):
        pass

    class Stated(mdp.JointPositionAction):
        constant_over_substeps = True

        def apply_actions(self):
            """Apply nothing."""

    assert mdp.JointPositionAction.constant_over_substeps
    assert Halved.constant_over_substeps  # its base applies
    assert not LateEffort.constant_over_substeps
    assert not Mixed.constant_over_substeps
    assert Stated.constant_over_substeps

"""Perturbations change what they name, and nothing else."""

import pytest
import torch

from lift_lab.envs import ManagerBasedRLEnv, mdp
from lift_lab.managers import EventTermCfg, SceneEntityCfg
from lift_lab.utils.errors import ConfigError
from lift_lab_rl.perturbations import STANDARD, parse_perturbation, perturb, perturb_all
from lift_lab_tasks.manager_based.manipulation.lift.config.franka.joint_pos_env_cfg import FrankaCubeLiftEnvCfg
from lift_lab_tasks.manager_based.manipulation.lift.config.franka.soft_cube_env_cfg import FrankaSoftCubeLiftEnvCfg


def _make(*texts, num_envs=4, edit=None):
    cfg = FrankaCubeLiftEnvCfg()
    cfg.scene.num_envs, cfg.sim.device, cfg.seed = num_envs, "cpu", 5
    if edit is not None:
        edit(cfg)
    for text in texts:
        perturb(cfg, text)
    return ManagerBasedRLEnv(cfg)


@pytest.mark.parametrize("text", ["mass", "mass=0", "mass=-1", "pose=1", "delay=-0.01", "mass=x", "friction=inf"])
def test_a_perturbation_that_makes_no_sense_is_refused(text):
    with pytest.raises(ConfigError, match=f"perturbation '{text}'"):
        parse_perturbation(text)


def test_an_unknown_perturbation_names_the_nearest():
    with pytest.raises(ConfigError, match="did you mean 'friction'"):
        parse_perturbation("frictoin=2")
    assert [parse_perturbation(text)[0] for text in STANDARD].count("pose") == 2


def test_mass_and_friction_are_scaled_whatever_the_task_randomises():
    def randomise(cfg):
        cfg.events.random_mass = EventTermCfg(
            func=mdp.randomize_rigid_body_mass,
            mode="reset",
            params={
                "asset_cfg": SceneEntityCfg("object"),
                "mass_distribution_params": (5.0, 6.0),
                "operation": "scale",
            },
        )

    plain = _make()
    env = _make("mass=2.0", "friction=0.5", edit=randomise)
    for one in (plain, env):
        one.reset()
    masses = [one.scene["object"].get_masses() for one in (plain, env)]
    torch.testing.assert_close(masses[1], 2.0 * masses[0])
    frictions = [one.sim.physics.randomizable("geom_friction").float() for one in (plain, env)]
    torch.testing.assert_close(frictions[1][..., 0], 0.5 * frictions[0][..., 0])
    torch.testing.assert_close(frictions[1][..., 1:], frictions[0][..., 1:])
    plain.close()
    env.close()


def test_the_object_starts_outside_the_trained_range_and_inside_the_widened_one():
    env = _make("pose=1.5", num_envs=64)
    env.reset()
    offset = env.scene["object"].data.root_pos_w - env.scene.env_origins - torch.tensor([0.5, 0.0, 0.02])
    share = (offset[:, :2] / torch.tensor([0.1, 0.25])).abs().amax(1)
    assert share.min() >= 1.0 - 1e-4
    assert share.max() <= 1.5 + 1e-4
    torch.testing.assert_close(offset[:, 2], torch.zeros(64), atol=1e-6, rtol=0)
    env.close()


def test_a_soft_object_is_perturbed_as_a_rigid_one_is():
    def make(*texts):
        cfg = FrankaSoftCubeLiftEnvCfg()
        cfg.scene.num_envs, cfg.sim.device, cfg.seed = 16, "cpu", 5
        for text in texts:
            perturb(cfg, text)
        env = ManagerBasedRLEnv(cfg)
        env.reset()
        return env

    plain, env = make(), make("mass=2.0", "friction=0.5", "pose=1.5")
    torch.testing.assert_close(env.scene["object"].get_masses(), 2.0 * plain.scene["object"].get_masses())
    for name in ("geom_friction", "flex_friction"):
        before, after = (one.sim.physics.randomizable(name)[..., 0] for one in (plain, env))
        torch.testing.assert_close(after, 0.5 * before)
    for one, least, most in ((plain, 0.0, 1.0), (env, 1.0, 1.5)):
        offset = one.scene["object"].data.root_pos_w - one.scene.env_origins - torch.tensor([0.5, 0.0, 0.02])
        share = (offset[:, :2] / torch.tensor([0.1, 0.25])).abs().amax(1)
        assert least - 1e-4 <= share.min() < share.max() <= most + 1e-4
        one.close()


def test_delayed_actions_reach_the_joints_two_physics_steps_late():
    env = _make("delay=0.01", num_envs=2)
    env.reset()
    robot, targets = env.scene["robot"], []
    arm = env.action_manager.get_term("arm_action")
    apply = arm.apply_actions

    def watch():
        apply()
        targets.append((robot.data.joint_pos_target - robot.data.default_joint_pos)[0, 0].item())

    arm.apply_actions = watch
    for value in (1.0, -1.0):
        env.step(torch.full((2, 8), value))
    # half a radian per unit of action; at rest until the first action arrives
    assert targets == pytest.approx([0.0, 0.0, 0.5, 0.5, 0.5, 0.5, -0.5, -0.5], abs=1e-6)
    assert env.action_manager.action.tolist() == [[-1.0] * 8] * 2
    env.close()


def test_a_delay_must_be_a_multiple_of_the_physics_step():
    with pytest.raises(ConfigError, match="multiple of the physics step"):
        perturb(FrankaCubeLiftEnvCfg(), "delay=0.007")


def test_a_perturbation_that_comes_twice_or_has_no_object_is_refused():
    with pytest.raises(ConfigError, match="perturbation 'mass' is given twice"):
        perturb_all(FrankaCubeLiftEnvCfg(), ["mass=2", "friction=0.5", "mass=3"])
    cfg = FrankaCubeLiftEnvCfg()
    cfg.scene.object = None
    with pytest.raises(ConfigError, match="this task has no 'object' to perturb"):
        perturb(cfg, "mass=2")


def test_a_delay_leaves_the_filter_of_an_action_as_it_is():
    def filtered(cfg):
        cfg.actions.arm_action = mdp.EMAJointPositionToLimitsActionCfg(
            asset_name="robot", joint_names=["panda_joint.*"], alpha=0.5
        )

    def targets(env):
        env.reset()
        arm = env.action_manager.get_term("arm_action")
        apply, found = arm.apply_actions, []

        def watch():
            apply()
            found.append(env.scene["robot"].data.joint_pos_target[0, 0].item())

        arm.apply_actions = watch
        for value in (1.0, -0.5, 0.25):
            env.step(torch.full((2, 8), value))
        env.close()
        return found

    plain = targets(_make(num_envs=2, edit=filtered))
    delayed = targets(_make("delay=0.01", num_envs=2, edit=filtered))
    # without a delay the targets are written once in the four physics steps of a step
    steps = plain if len(plain) == 3 else plain[::4]
    assert delayed[2:] == pytest.approx([value for value in steps for _ in range(4)][:10], abs=1e-6)

"""A symmetric policy acts mirrored at mirrored observations, in every form: live, loaded, averaged and exported."""

import numpy as np
import pytest
import torch
from rsl_rl.models import MLPModel
from tensordict import TensorDict

from lift_lab.envs import ManagerBasedRLEnv
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.mirror import MirrorMap
from lift_lab_rl.rsl_rl import LiftLabRunner, RslRlSymmetryCfg, RslRlVecEnvWrapper, to_rsl_rl
from lift_lab_rl.rsl_rl.symmetric_policy import SymmetricMlp
from lift_lab_tasks.manager_based.classic.cartpole.agents.rsl_rl_ppo_cfg import CartpolePPORunnerCfg
from lift_lab_tasks.manager_based.classic.cartpole.cartpole_env_cfg import CartpoleEnvCfg

pytestmark = pytest.mark.usefixtures("one_torch_thread")

OBS, ACTIONS = 5, 3


def image_of_obs(obs):
    """Two numbers change places, one its sign, one is at 0.7 - x."""
    return torch.stack([obs[:, 1], obs[:, 0], -obs[:, 2], 0.7 - obs[:, 3], obs[:, 4]], 1)


def image_of_actions(actions):
    return torch.stack([-actions[:, 1], -actions[:, 0], 0.2 - actions[:, 2]], 1)


def make_policy() -> SymmetricMlp:
    torch.manual_seed(2)
    obs = TensorDict({"policy": torch.zeros(1, OBS)}, batch_size=[1])
    distribution = {"class_name": "GaussianDistribution", "init_std": 0.5}
    settings = {"hidden_dims": (16, 8), "obs_normalization": True, "distribution_cfg": distribution}
    policy = SymmetricMlp(obs, {"actor": ["policy"]}, "actor", ACTIONS, **settings)
    policy.obs_normalizer.update(torch.randn(50, OBS) * 2.0 + 1.0)
    policy.mirror.set_maps(
        MirrorMap.of([1, 1, -1, -1, 1], [1, 0, 2, 3, 4], [0, 0, 0, 0.7, 0]),
        MirrorMap.of([-1, -1, -1], [1, 0, 2], [0, 0, 0.2]),
    )
    return policy.eval()


def test_it_acts_mirrored_at_mirrored_observations_whatever_its_weights():
    policy, obs = make_policy(), torch.randn(20, OBS)
    with torch.no_grad():
        there, here = (policy(TensorDict({"policy": x}, batch_size=[20])) for x in (image_of_obs(obs), obs))
        plain = policy.mlp(policy.obs_normalizer(obs))
        mirrored = policy.mlp(policy.obs_normalizer(image_of_obs(obs)))
    torch.testing.assert_close(there, image_of_actions(here), atol=1e-6, rtol=1e-6)
    torch.testing.assert_close(here, (plain + image_of_actions(mirrored)) / 2.0, atol=1e-6, rtol=1e-6)
    assert (here - plain).abs().max() > 1e-2


def test_the_derivative_by_the_outputs_is_autograds():
    mirror, both = make_policy().mirror, torch.randn(2, 7, ACTIONS, requires_grad=True)
    grad = torch.randn(7, ACTIONS)
    mirror.mean(both).backward(grad)
    torch.testing.assert_close(mirror.mean_gradient(grad), both.grad)


def own_function(env, obs=None, actions=None):
    return (None if obs is None else torch.cat([obs, obs])), (None if actions is None else actions.repeat(2, 1))


def runner_of(folder=None, average=False, num_envs=4) -> LiftLabRunner:
    cfg, env_cfg = CartpolePPORunnerCfg(), CartpoleEnvCfg()
    env_cfg.scene.num_envs, env_cfg.seed = num_envs, 5
    cfg.average_share, cfg.save_interval, cfg.num_steps_per_env = 0.5, 1, 4
    if average:
        cfg.algorithm.symmetry_cfg = RslRlSymmetryCfg(average_policy=True)
    torch.manual_seed(5)
    return LiftLabRunner(RslRlVecEnvWrapper(ManagerBasedRLEnv(env_cfg)), to_rsl_rl(cfg), log_dir=folder)


def actions(runner: LiftLabRunner, obs: torch.Tensor) -> torch.Tensor:
    with torch.no_grad():
        return runner.get_inference_policy()(TensorDict({"policy": obs}, batch_size=[len(obs)]))


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    """Folder of a training with a symmetric policy."""
    folder = tmp_path_factory.mktemp("run")
    runner = runner_of(folder, average=True)
    runner.learn(2)
    runner.env.close()
    return folder


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plain")
    runner = runner_of(folder)
    runner.learn(2)
    runner.env.close()
    return folder


def test_a_checkpoint_acts_symmetrically_also_where_the_settings_do_not_say_so(trained, plain, tmp_path):
    """A cart-pole mirrored has all signs changed, so a symmetric policy is odd."""
    runner, obs = runner_of(), torch.randn(9, 4)
    assert type(runner.alg.get_policy()) is MLPModel
    runner.load_policy(str(trained / "model_2.pt"))
    found = actions(runner, obs)
    torch.testing.assert_close(actions(runner, -obs), -found, atol=1e-6, rtol=0.0)
    policy = runner.alg.get_policy()
    same = runner_of(average=True)
    same.load_policy(str(trained / "model_2.pt"))
    assert torch.equal(actions(same, obs), found)
    same.env.close()

    runner.export_policy_to_jit(str(tmp_path))  # each export compares its actions with the policy's
    exported = torch.jit.load(str(tmp_path / "policy.pt"))
    torch.testing.assert_close(exported(-obs), -found, atol=1e-5, rtol=0.0)
    runner.export_policy_to_onnx(str(tmp_path))
    from onnx.reference import ReferenceEvaluator

    session = ReferenceEvaluator(str(tmp_path / "policy.onnx"))
    rows = [session.run(None, {"obs": row[None].numpy()})[0][0] for row in -obs]
    np.testing.assert_allclose(np.stack(rows), -found.numpy(), atol=1e-5)

    runner.load_policy(str(plain / "model_2.pt"))  # the same runner, then with a plain policy
    assert runner.alg.get_policy() is policy
    fresh = runner_of()
    fresh.load_policy(str(plain / "model_2.pt"))
    torch.testing.assert_close(actions(runner, obs), actions(fresh, obs), atol=1e-6, rtol=0.0)
    assert (actions(fresh, obs) + actions(fresh, -obs)).abs().max() > 1e-4
    for one in (runner, fresh):
        one.env.close()


def test_a_plain_policy_can_act_symmetrically(plain):
    runner, obs = runner_of(average=True), torch.randn(9, 4)
    runner.load_policy(str(plain / "model_2.pt"))
    torch.testing.assert_close(actions(runner, -obs), -actions(runner, obs), atol=1e-6, rtol=0.0)
    runner.env.close()


def test_a_training_continues_exactly_and_only_as_what_it_was(trained, tmp_path):
    straight = runner_of(tmp_path / "a", average=True)
    straight.learn(3)
    resumed = runner_of(tmp_path / "b", average=True)
    resumed.load(str(trained / "model_2.pt"))
    resumed.load_resume_state(trained / "model_2.pt")
    resumed.learn(1)
    for name, value in straight.alg.actor.state_dict().items():
        assert torch.equal(resumed.alg.actor.state_dict()[name], value), name
    other = runner_of()
    with pytest.raises(ConfigError, match=r"exactly symmetric policy: set agent\.algorithm\.symmetry_cfg\.average_pol"):
        other.load(str(trained / "model_2.pt"))
    for runner in (straight, resumed, other):
        runner.env.close()


def test_a_damaged_map_is_refused(trained, tmp_path):
    content = torch.load(trained / "model_2.pt", weights_only=True)
    for name in ("actor_state_dict", "actor_average_state_dict"):
        content[name]["mirror.obs_index"][0] = 99
    torch.save(content, tmp_path / "model_2.pt")
    runner = runner_of()
    with pytest.raises(ConfigError, match=r"'mirror\.obs_index' does not name each number once"):
        runner.load_policy(str(tmp_path / "model_2.pt"))
    runner.env.close()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda cfg: setattr(cfg.policy, "state_dependent_std", True), "average_policy needs agent.policy.class_name"),
        (lambda cfg: setattr(cfg.algorithm, "class_name", "PPO"), "agent.algorithm.symmetry_cfg.average_policy=null"),
        (
            lambda cfg: setattr(cfg.algorithm.symmetry_cfg, "data_augmentation_func", own_function),
            "average_policy needs the task's declared symmetry",
        ),
        (
            lambda cfg: setattr(cfg.algorithm.symmetry_cfg, "data_augmentation_func", "math:mirror"),
            "symmetry_cfg.data_augmentation_func: no function 'math:mirror'",
        ),
    ],
    ids=["deviation by observation", "rsl_rl's PPO", "a function of one's own", "no function"],
)
def test_what_cannot_be_averaged_is_refused(change, message):
    cfg = CartpolePPORunnerCfg()
    cfg.algorithm.symmetry_cfg = RslRlSymmetryCfg(average_policy=True)
    change(cfg)
    env_cfg = CartpoleEnvCfg()
    env_cfg.scene.num_envs = 2
    env = RslRlVecEnvWrapper(ManagerBasedRLEnv(env_cfg))
    with pytest.raises(ConfigError, match=message):
        LiftLabRunner(env, to_rsl_rl(cfg))
    env.close()

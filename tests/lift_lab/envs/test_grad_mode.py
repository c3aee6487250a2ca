"""An environment may be stepped in inference mode, and out of it again."""

import torch


def _trajectory(env, modes):
    """Observations of steps, each in or out of inference mode, with a reset of environment 1 after each."""
    env.reset(seed=3)
    seen = []
    for inside in modes:
        with torch.inference_mode(inside):
            obs, *_ = env.step(torch.full((env.num_envs, env.action_manager.total_action_dim), 0.3))
            env.reset(env_ids=torch.tensor([1]))
        seen.append(obs["policy"].clone())
    return torch.stack(seen)


def test_steps_in_and_out_of_inference_mode_mix(make_env):
    outside = _trajectory(make_env(), [False] * 4)
    mixed = _trajectory(make_env(), [False, True, False, True])
    torch.testing.assert_close(mixed, outside, rtol=0, atol=0)


def test_what_a_step_outside_of_inference_mode_returns_can_be_trained_on(make_env):
    env = make_env()
    env.reset()
    action = torch.zeros(env.num_envs, env.action_manager.total_action_dim)
    with torch.inference_mode():
        env.step(action)
    obs, reward, *_ = env.step(action)
    weight = torch.ones(obs["policy"].shape[1], requires_grad=True)
    ((obs["policy"] @ weight) * reward).sum().backward()
    torch.testing.assert_close(weight.grad, (obs["policy"] * reward[:, None]).sum(0))

"""Before any learning: a scripted expert picks up the cube and brings it to the goal, on both engines."""

import pytest
import torch
from scripted_expert import ScriptedExpert

from lift_lab.envs import ManagerBasedRLEnv
from lift_lab_tasks.manager_based.manipulation.lift import mdp
from lift_lab_tasks.manager_based.manipulation.lift.config.franka.joint_pos_env_cfg import FrankaCubeLiftEnvCfg


def _successes(physics: str, num_envs: int, seed: int) -> int:
    """Environments in which the cube came within 0.02 m of its goal in their first episode."""
    cfg = FrankaCubeLiftEnvCfg()
    cfg.scene.num_envs = num_envs
    cfg.sim.device = "cpu"
    cfg.sim.physics = physics
    cfg.seed = seed
    env = ManagerBasedRLEnv(cfg)
    env.reset()
    expert = ScriptedExpert(env)
    reached = torch.zeros(num_envs, dtype=torch.bool)
    over = torch.zeros(num_envs, dtype=torch.bool)
    for _ in range(env.max_episode_length - 1):
        _, _, terminated, truncated, _ = env.step(expert.act())
        over |= terminated | truncated
        reached |= mdp.object_reached_goal(env, threshold=0.02) & ~over
    env.close()
    return int(reached.sum())


@pytest.mark.parametrize("seed", [11, 12])
def test_the_expert_lifts_99_of_100_cubes_on_the_native_engine(seed):
    assert _successes("native", 100, seed) >= 99


@pytest.mark.slow
def test_the_expert_lifts_15_of_16_cubes_on_the_warp_engine():
    assert _successes("warp", 16, 11) >= 15

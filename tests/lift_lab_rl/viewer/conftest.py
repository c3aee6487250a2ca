"""One small environment and a session that shows it, without a browser."""

import gymnasium as gym
import pytest

import lift_lab_tasks  # noqa: F401
from lift_lab.visualizers import open_server
from lift_lab_rl.evaluation import add_success_probe
from lift_lab_rl.rsl_rl import RslRlVecEnvWrapper
from lift_lab_rl.viewer import ViewerSession, ZeroPolicy
from lift_lab_tasks.utils import parse_env_cfg

pytest.importorskip("viser")


@pytest.fixture(scope="package")
def env():
    cfg = parse_env_cfg("Lift-Cube-Franka", device="cpu", num_envs=3)
    cfg.sim.num_threads, cfg.seed = 1, 4
    add_success_probe(cfg, "lift_lab_tasks.manager_based.manipulation.lift.mdp:object_reached_goal")
    env = RslRlVecEnvWrapper(gym.make("Lift-Cube-Franka", cfg=cfg))
    yield env
    env.close()


@pytest.fixture
def session(env):
    server = open_server(port=0)
    session = ViewerSession(env, ZeroPolicy(env), server, "Lift")
    session._do_speed("as fast as possible")
    yield session
    server.stop()


@pytest.fixture
def go(env, session):
    """Takes environment steps in the session: all but the first call go on where the last one ended."""
    reset = env.reset

    def go(steps):
        session.run(session.steps + steps)
        session._env.reset = lambda: (env.get_observations(), {})

    yield go
    env.__dict__.pop("reset", None)
    assert env.reset == reset

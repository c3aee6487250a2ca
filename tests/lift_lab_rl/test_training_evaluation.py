"""Evaluation during a training: when it takes place, what it measures, and that it ends a training that is solved."""

from types import SimpleNamespace

import gymnasium as gym
import pytest
import torch
from point_task import AgentCfg, PointEnv

import lift_lab_tasks  # noqa: F401
from lift_lab.utils.errors import ConfigError
from lift_lab_rl.evaluation import Episode, Evaluation, add_success_probe, evaluate
from lift_lab_rl.files import load_torch
from lift_lab_rl.rsl_rl import LiftLabRunner, RslRlEvaluationCfg, RslRlVecEnvWrapper, to_rsl_rl
from lift_lab_rl.rsl_rl.run_files import solved_by
from lift_lab_rl.rsl_rl.training_evaluation import TrainingEvaluation, evaluation_env_cfg
from lift_lab_rl.study.curves import read_scalars
from lift_lab_tasks.manager_based.classic.cartpole.mdp import pole_balanced
from lift_lab_tasks.settings import Settings
from lift_lab_tasks.utils import parse_env_cfg
from lift_lab_tasks.utils.runs import fingerprint

pytestmark = pytest.mark.usefixtures("one_torch_thread")

ENVS, STEPS = 8, 8


@pytest.fixture
def make():
    """Makes runners of cart-poles with episodes of 12 steps; a folder, and settings of the evaluation or None."""
    runners = []

    def build(folder, evaluation, average_share=0.0, engine="native"):
        overrides = [f"env.scene.num_envs={ENVS}", "env.episode_length_s=0.2", f"agent.average_share={average_share}"]
        overrides += [f"agent.num_steps_per_env={STEPS}", "agent.max_iterations=8", "agent.save_interval=1"]
        overrides += ["agent.keep_resume_states=9"]
        overrides += [
            f"env.sim.physics={engine}",
            "env.sim.device=cpu",
            "env.sim.num_threads=1",
            "env.seed=4",
            "agent.seed=4",
        ]
        overrides += [f"agent.evaluation.{name}={value}" for name, value in (evaluation or {}).items()]
        settings = Settings("Cartpole", "rsl_rl_cfg_entry_point", overrides)
        settings.resolve(training=True)
        env = RslRlVecEnvWrapper(gym.make("Cartpole", cfg=settings.env))
        plain = to_rsl_rl(settings.agent, env.get_observations().keys())
        same = fingerprint(settings.env, settings.agent)
        runners.append(LiftLabRunner(env, plain, folder, "cpu", same))
        return runners[-1]

    yield build
    for runner in runners:
        runner.env.close()


EARLY = {"from_success": "null", "interval": 2, "max_share": 1.0, "episodes": 4, "min_success": 0.0}
"""Evaluations of 48 steps that all pass, in a training of 64 steps an iteration."""


def end(folder, iteration):
    """Bytes of the model, and the state beside it without times and without what evaluations keep there."""
    state = load_torch(folder / f"resume_state_{iteration}.pt")
    state["logger"].pop("total_time_s")
    kept = state.pop("evaluation", None)
    return (folder / f"model_{iteration}.pt").read_bytes(), torch.cat(list(state["obs"].values())), state["rng"], kept


@pytest.mark.parametrize("engine", ["native", pytest.param("warp", marks=pytest.mark.slow)])
def test_a_training_has_the_same_bits_with_and_without_evaluations(tmp_path, make, engine):
    assert make(tmp_path / "off", None, engine=engine).learn(5)
    with_evaluations = make(tmp_path / "on", EARLY | {"consecutive": 6}, engine=engine)
    assert with_evaluations.learn(5)
    assert with_evaluations.evaluation.passes == 3
    off, on = end(tmp_path / "off", 5), end(tmp_path / "on", 5)
    assert off[0] == on[0]
    assert torch.equal(off[1], on[1])
    assert torch.equal(off[2]["torch"], on[2]["torch"])
    assert torch.equal(off[2]["numpy"][1], on[2]["numpy"][1])


def test_a_solved_task_ends_the_training_and_a_resumed_run_ends_alike(tmp_path, make):
    runner = make(tmp_path, EARLY | {"consecutive": 3, "start_after": 1})
    assert runner.learn(8, init_at_random_ep_len=True)
    assert runner.solved
    assert runner.stopped_by is None
    assert runner.current_learning_iteration == 6  # evaluated after iterations 2, 4, 6
    scalars = read_scalars(tmp_path)
    assert [point[0] for point in points(scalars["Evaluation/success_rate"])] == [2, 4, 6]
    assert solved_by(tmp_path / "model_5.pt") is None
    assert solved_by(tmp_path / "model_6.pt") == runner.evaluation.criteria()

    other = make(tmp_path / "other", EARLY | {"consecutive": 3, "start_after": 1})
    other.load(str(tmp_path / "model_3.pt"))
    assert other.load_resume_state(tmp_path / "model_3.pt") == "continuing the episodes of iteration 3"
    assert other.learn(5)
    assert other.current_learning_iteration == 6
    whole, resumed = end(tmp_path, 6), end(tmp_path / "other", 6)
    assert whole[0] == resumed[0]
    assert whole[3] == resumed[3]

    again = make(tmp_path / "again", EARLY | {"consecutive": 3, "start_after": 1})
    again.load(str(tmp_path / "model_6.pt"))
    again.load_resume_state(tmp_path / "model_6.pt")
    assert again.learn(2)
    assert again.current_learning_iteration == 6
    stricter = make(tmp_path / "stricter", EARLY | {"consecutive": 4, "start_after": 1})
    stricter.load(str(tmp_path / "model_6.pt"))
    stricter.load_resume_state(tmp_path / "model_6.pt")
    assert stricter.evaluation.passes == 0
    assert stricter.evaluation.steps == runner.evaluation.steps


def points(curve):
    """Pairs of iteration and value of a curve."""
    return [(int(step), value) for step, value in zip(*curve, strict=True)]


def test_an_evaluation_measures_the_policy_that_ships_as_the_evaluate_command_does(tmp_path, make):
    settings = EARLY | {"interval": 3, "episodes": 6, "seed": 77, "consecutive": 2}
    runner = make(tmp_path, settings, average_share=0.9)
    runner.learn(3)
    found = points(read_scalars(tmp_path)["Evaluation/mean_reward"])
    assert [iteration for iteration, _ in found] == [2]

    alone = make(tmp_path / "alone", settings, average_share=0.9)
    cfg = parse_env_cfg("Cartpole", "cpu", 6)
    cfg.episode_length_s = 0.2
    add_success_probe(cfg, pole_balanced)
    env = RslRlVecEnvWrapper(gym.make("Cartpole", cfg=cfg))
    alone.load_policy(str(tmp_path / "model_2.pt"))
    env.seed(77)
    env.reset()
    expected = evaluate(env, alone.get_inference_policy("cpu"), 6).summary()["mean_reward"]
    assert found[0][1] == pytest.approx(expected, rel=1e-6)
    last = alone.alg.actor
    last.load_state_dict(load_torch(tmp_path / "model_2.pt")["actor_state_dict"])
    env.seed(77)
    env.reset()
    assert evaluate(env, last, 6).summary()["mean_reward"] != pytest.approx(expected, rel=1e-6)
    env.close()
    assert (tmp_path / "model_best.pt").read_bytes() == (tmp_path / "model_2.pt").read_bytes()


# -- when an evaluation takes place, and what it says


class Evaluations(TrainingEvaluation):
    """Evaluations of given results: successes, error."""

    def __init__(self, results=(), most_steps=10**6, **settings):
        cfg = RslRlEvaluationCfg(episodes=10, max_share=0.5, **settings).to_dict()
        env, alg = SimpleNamespace(max_episode_length=10), SimpleNamespace(get_policy=lambda: torch.nn.Linear(1, 1))
        super().__init__(cfg, alg, env, None, most_steps)
        self.results = list(results)

    def _evaluate(self):
        torch.rand(1)
        self.steps += 100
        won, error = self.results.pop(0) if self.results else (10, 0.0)
        episodes = [Episode(1.0, 10, int(k < won), "time_out") for k in range(10)]
        return Evaluation(0.02, episodes, {"Metrics/error": error})

    def iterations(self, successes, steps=100):
        """Iterations with an evaluation, for the smoothed success rate after each iteration."""
        return [k for k, success in enumerate(successes, 1) if self.after_iteration(k, k * steps, success) is not None]


def test_evaluations_wait_for_the_success_rate_the_schedules_and_their_share():
    rates = [None, 0.3, 0.95, 0.7, *[0.99] * 20]
    assert Evaluations(from_success=0.9, interval=5, consecutive=9).iterations(rates) == [3, 8, 13, 18, 23]
    assert Evaluations(from_success=0.9, start_after=4, interval=6).iterations(rates) == [7, 13, 19]
    assert Evaluations(from_success=None, interval=6).iterations(rates) == [2, 8, 14, 20]  # 100 steps are half of 200
    assert Evaluations(from_success=None, interval=1).iterations(rates, steps=50) == [4, 8, 12, 16, 20, 24]
    assert Evaluations(from_success=1.0, interval=1).iterations(rates) == []


def test_evaluations_in_a_row_have_to_pass():
    results = [(9, 0.0), (10, 0.03), (10, 0.02), (9, 0.01), (10, 0.01), (10, 0.02), (10, 0.0)]
    given = Evaluations(results, from_success=None, interval=1, error_metric="Metrics/error", max_error=0.02)
    torch.manual_seed(3)
    passes, before = [], torch.get_rng_state()
    for k in range(2, 9):
        result = given.after_iteration(k, 10**5, None)
        passes.append((result.passed, given.passes, given.solved))
    assert passes == [
        *[(False, 0, False), (False, 0, False), (True, 1, False), (False, 0, False), (True, 1, False)],
        *[(True, 2, True), (True, 3, True)],
    ]
    assert torch.equal(torch.get_rng_state(), before)
    some = Evaluations([(8, 0.0), (7, 0.0)], from_success=None, interval=1, min_success=0.8)
    first, second = (some.after_iteration(k, 10**5, None) for k in (1, 2))
    assert (first.note, second.note) == (
        "evaluation at iteration 1: success 8 of 10: passed (1 of 2)",
        "evaluation at iteration 2: success 7 of 10: not passed",
    )
    assert first.rank > second.rank


# -- mistakes


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"error_metric": "Metrics/error"}, "agent.evaluation: error_metric and max_error .* give both or none"),
        ({"num_envs": 101}, "agent.evaluation.num_envs is 101, more than the 100 episodes"),
        ({"min_success": 1.1}, "agent.evaluation.min_success is 1.1"),
        ({"max_share": 0.0}, "agent.evaluation.max_share is 0; it must be above 0"),
    ],
)
def test_settings_that_could_not_work_are_refused(settings, message):
    with pytest.raises(ConfigError, match=message):
        to_rsl_rl(AgentCfg(evaluation=RslRlEvaluationCfg(**settings)))


def test_a_training_that_is_too_short_to_end_early_says_so():
    assert Evaluations(most_steps=400).too_short() is None
    assert Evaluations(most_steps=301).too_short() == (
        "agent.evaluation: this training cannot end early: 2 evaluations of 10 episodes need up to 200 environment "
        "steps, and max_share=0.5 of 301 is less; max_share=0.665 is enough"
    )
    assert Evaluations(most_steps=199).too_short().endswith("is less; train for longer, or evaluate fewer episodes")


def test_a_metric_that_is_not_there_is_named(tmp_path, make):
    wrong = EARLY | {"error_metric": "Metrics/sucess_rate", "max_error": 0.1}
    with pytest.raises(ConfigError, match=r"agent\.evaluation\.error_metric: .* did you mean 'Metrics/success_rate'"):
        make(tmp_path, wrong)


def test_a_task_without_success_cannot_be_evaluated(make):
    runner = make(None, EARLY)
    inner = runner.env.unwrapped
    inner.cfg.metrics, inner.spec = None, None
    with pytest.raises(ConfigError, match=r"agent\.evaluation: this task does not say .*--no_evaluation"):
        runner.learn(1)


def test_aids_of_training_are_left_out_of_evaluations():
    cfg = parse_env_cfg("Lift-Cube-Franka-CL", "cpu", 2)
    env = RslRlVecEnvWrapper(gym.make("Lift-Cube-Franka-CL", cfg=cfg))
    own = evaluation_env_cfg(env, RslRlEvaluationCfg(episodes=20, num_envs=8, seed=9).to_dict())
    assert (own.curriculum.missed_goals, own.curriculum.gripper_hold) == (None, None)
    assert own.curriculum.action_rate is not None
    assert (own.scene.num_envs, own.seed) == (8, 9)
    assert (cfg.scene.num_envs, cfg.curriculum.missed_goals is None) == (2, False)
    env.close()


def test_an_environment_of_another_kind_cannot_be_evaluated():
    runner = LiftLabRunner(PointEnv(), to_rsl_rl(AgentCfg(evaluation=RslRlEvaluationCfg())))
    with pytest.raises(ConfigError, match="manager-based"):
        runner.learn(1)

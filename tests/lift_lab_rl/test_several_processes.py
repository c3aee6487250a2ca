"""Several processes train one policy: the same bits on each, one writer, and an end that is clean or soon."""

import dataclasses
import filecmp
import multiprocessing
import os
import runpy
import signal
import socket
import sys
import time
from pathlib import Path

import pytest
import torch
from point_task import AgentCfg, PointEnv, with_algorithm
from rsl_rl.models import MLPModel
from rsl_rl.storage import RolloutStorage
from tensordict import TensorDict

from lift_lab.app import cli
from lift_lab.utils.errors import ConfigError
from lift_lab_rl import distributed
from lift_lab_rl.evaluation import Episode, Evaluation
from lift_lab_rl.files import load_torch, save_torch
from lift_lab_rl.rsl_rl import LiftLabRunner, RslRlEvaluationCfg, to_rsl_rl
from lift_lab_rl.rsl_rl.gaussian import log_normaliser
from lift_lab_rl.rsl_rl.ppo import LiftLabPPO
from lift_lab_rl.rsl_rl.training_evaluation import TrainingEvaluation

TRAIN = Path(__file__).parents[2] / "scripts" / "rsl_rl" / "train.py"
SIZE = 2


# -- what a process does


def train(place, folder, on_step=None, **settings):
    torch.manual_seed(5 + place.rank)
    env = PointEnv(on_step=on_step)
    first, cfg = env.position.clone(), with_algorithm(AgentCfg(num_threads=1), **settings)
    runner = LiftLabRunner(env, to_rsl_rl(cfg), folder / "run", place=place)
    finished = runner.learn(4, init_at_random_ep_len=True)
    content = {
        "model": runner.alg.save(),
        "rate": runner.alg.learning_rate,
        "iterations": runner.current_learning_iteration,
        "finished": finished,
        "first_positions": first,
        "writes": runner.logger.writer is not None,
    }
    save_torch(folder / f"end{place.rank}.pt", content)


def train_with_rsl_rls_ppo(place, folder):
    train(place, folder, class_name="PPO")


def train_with_rsl_rls_update(place, folder):
    train(place, folder, micro_batches=False)


def train_and_interrupt_one(place, folder):
    def twice(step):
        if step == 10 and place.rank == 1:
            os.kill(os.getpid(), signal.SIGINT)
            os.kill(os.getpid(), signal.SIGINT)

    save = LiftLabRunner.save

    def save_late(*args):
        # the other's own signal, after both have agreed to end
        os.kill(os.getpid(), signal.SIGINT)
        save(*args)

    LiftLabRunner.save = save_late
    train(place, folder, twice)


def train_until_solved(place, folder):
    """The main process's evaluations pass from iteration 2 on."""
    cfg = RslRlEvaluationCfg(from_success=None, interval=1, max_share=1.0, episodes=10, consecutive=2)
    runner = LiftLabRunner(PointEnv(), to_rsl_rl(AgentCfg(num_threads=1)), folder / "run", place=place)
    runner.evaluation = TrainingEvaluation(cfg.to_dict(), runner.alg, runner.env, None, 10**6)
    won, evaluations = Episode(1.0, 20, 1, "time_out"), []
    lost = dataclasses.replace(won, success_step=0)

    def evaluate():
        evaluations.append(place.rank)
        return Evaluation(0.02, [lost if len(evaluations) == 1 else won] * 10)

    runner.evaluation._evaluate = evaluate
    finished = runner.learn(4)
    end = [finished, runner.solved, runner.current_learning_iteration, len(evaluations)]
    save_torch(folder / f"end{place.rank}.pt", {"end": end})


def train_and_kill_one(place, folder):
    train(place, folder, lambda step: os._exit(9) if step == 10 and place.rank == 1 else None)


def train_and_hang_one(place, folder):
    train(place, folder, lambda step: time.sleep(20) if step == 10 and place.rank == 1 else None)


def disagree(place, folder):
    distributed.check_equal([torch.zeros(3), torch.full((2,), float(place.rank))], "the policy")


def samples():
    """A rollout of 8 environments, 6 steps: observations, noise, rewards, ends."""
    generator = torch.Generator().manual_seed(7)
    return [torch.randn(7, 8, 5, generator=generator), *(torch.rand(6, 8, 3, generator=generator) for _ in range(2))]


def ppo_after_updates(envs, multi=None, by_batch=False):
    """Two updates from these columns of the samples, everything in one minibatch."""
    torch.manual_seed(0)
    observed, rewards, ends = (values[:, envs] for values in samples())
    obs = TensorDict({"policy": observed[0]}, batch_size=[len(envs)])
    groups = {"actor": ["policy"], "critic": ["policy"]}
    shape = {"hidden_dims": (16, 8), "activation": "elu", "obs_normalization": True}
    distribution = {"class_name": "GaussianDistribution", "init_std": 0.8, "std_type": "log"}
    actor = MLPModel(obs, groups, "actor", 3, distribution_cfg=distribution, **shape)
    critic = MLPModel(obs, groups, "critic", 1, **shape)
    storage = RolloutStorage("rl", len(envs), 6, obs, [3])
    settings = {"learning_rate": 3e-3, "num_learning_epochs": 3, "num_mini_batches": 1, "entropy_coef": 0.01}
    settings["normalize_advantage_per_mini_batch"] = by_batch
    ppo = LiftLabPPO(actor, critic, storage, num_threads=1, multi_gpu_cfg=multi, schedule="adaptive", **settings)
    for _ in range(2):
        with torch.inference_mode():
            for step in range(6):
                ppo.act(TensorDict({"policy": observed[step]}, batch_size=[len(envs)]))
                # actions that depend on the environment alone, not on a process's random numbers
                ppo.transition.actions = rewards[step] * 2.0 - 1.0
                mean, std = ppo.transition.distribution_params
                deviation = (ppo.transition.actions - mean) / std
                ppo.transition.actions_log_prob = -0.5 * deviation.square().sum(-1) - log_normaliser(std[0])
                done = (ends[step, :, 0] < 0.2).long()
                ppo.process_env_step(obs, rewards[step, :, 0], done, {"time_outs": done.bool()})
            ppo.compute_returns(TensorDict({"policy": observed[6]}, batch_size=[len(envs)]))
        ppo.update()
    state = [*ppo._raw_actor.state_dict().values(), *ppo._raw_critic.state_dict().values()]
    return torch.cat([value.detach().double().flatten() for value in state]), ppo.learning_rate


def update_half_of_the_samples(place, folder):
    envs = list(range(8))[place.rank :: SIZE]
    multi = {"global_rank": place.rank, "local_rank": place.local_rank, "world_size": SIZE}
    for by_batch in (False, True):
        weights, rate = ppo_after_updates(envs, multi, by_batch)
        problem = distributed.first_problem(f"of {place.rank}" if by_batch and place.rank else None)
        end = {"weights": weights, "rate": rate, "problem": problem}
        save_torch(folder / f"{'by_batch' if by_batch else 'end'}{place.rank}.pt", end)


def process(rank, port, folder, job, timeout_s):
    """Body of a process that torchrun would start; its output goes to files."""
    for name, number in (("stdout", 1), ("stderr", 2)):
        os.dup2(os.open(folder / f"{name}{rank}", os.O_WRONLY | os.O_CREAT | os.O_TRUNC), number)
    local = {"RANK": rank, "LOCAL_RANK": rank, "WORLD_SIZE": SIZE, "LOCAL_WORLD_SIZE": SIZE}
    os.environ |= {"MASTER_ADDR": "127.0.0.1", "MASTER_PORT": str(port), "TORCHELASTIC_RUN_ID": "test"}
    os.environ |= {name: str(value) for name, value in local.items()}
    torch.set_num_threads(1)
    if isinstance(job, list):
        os.chdir(folder)
        sys.path.insert(0, str(TRAIN.parent))
        sys.argv = [str(TRAIN), *job]
        runpy.run_path(str(TRAIN), run_name="__main__")

    def main():
        place = distributed.place(True)
        with distributed.group(place, "cpu", timeout_s):
            job(place, folder)

    cli.run(main)


def together(folder, job, timeout_s=120.0):
    """Run a job in two processes.

    Returns:
        Exit statuses, and what each wrote to standard error.
    """
    folder.mkdir(exist_ok=True)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["lift_lab_rl.rsl_rl", "lift_lab_tasks", "lift_lab.envs", __name__])
    processes = [context.Process(target=process, args=(r, port, folder, job, timeout_s)) for r in range(SIZE)]
    for one in processes:
        one.start()
    for one in processes:
        one.join(300)
    for one in processes:
        if one.is_alive():
            one.kill()
            one.join()
    return [one.exitcode for one in processes], [(folder / f"stderr{r}").read_text() for r in range(SIZE)]


def ends(folder):
    return [load_torch(folder / f"end{rank}.pt") for rank in range(SIZE)]


def equal(one, other):
    """Whether two nests of containers hold the same, bit by bit."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(equal(one[key], other[key]) for key in one)
    if isinstance(one, (list, tuple)):
        return len(one) == len(other) and all(equal(a, b) for a, b in zip(one, other, strict=True))
    return torch.equal(one, other) if isinstance(one, torch.Tensor) else one == other


# -- tests


def test_processes_see_different_samples_and_end_with_the_same_policy_and_one_writer(tmp_path):
    statuses, errors = together(tmp_path, train)
    assert statuses == [0, 0], errors
    first, second = ends(tmp_path)
    assert not torch.equal(first["first_positions"], second["first_positions"])
    assert equal(first["model"], second["model"])
    assert first["rate"] == second["rate"]
    assert (first["writes"], second["writes"]) == (True, False)
    names = {path.name for path in (tmp_path / "run").iterdir() if not path.name.startswith("events.")}
    states = {f"{kind}_state_{n}.pt" for kind in ("resume", "rank1") for n in (2, 4)}
    assert names == {"model_2.pt", "model_4.pt", *states}
    assert len(list((tmp_path / "run").glob("events.*"))) == 1


@pytest.mark.parametrize("job", [train_with_rsl_rls_ppo, train_with_rsl_rls_update])
def test_rsl_rls_update_keeps_the_policies_of_all_processes_equal(tmp_path, job):
    statuses, errors = together(tmp_path, job)
    assert statuses == [0, 0], errors
    first, second = ends(tmp_path)
    assert equal(first["model"], second["model"])
    assert first["rate"] == second["rate"]


def test_two_processes_with_half_the_samples_take_the_steps_of_one_with_all(tmp_path):
    statuses, errors = together(tmp_path, update_half_of_the_samples)
    assert statuses == [0, 0], errors
    torch.set_num_threads(1)
    for name, by_batch in (("end", False), ("by_batch", True)):
        first, second = (load_torch(tmp_path / f"{name}{rank}.pt") for rank in range(SIZE))
        assert torch.equal(first["weights"], second["weights"])
        weights, rate = ppo_after_updates(list(range(8)), by_batch=by_batch)
        torch.testing.assert_close(first["weights"], weights, atol=2e-5, rtol=1e-4)
        assert first["rate"] == second["rate"] == rate
        assert first["problem"] == second["problem"] == ("of 1" if by_batch else None)


def test_a_signal_to_one_process_ends_all_after_the_same_iteration(tmp_path):
    statuses, errors = together(tmp_path, train_and_interrupt_one)
    assert statuses == [0, 0], errors
    assert [(end["iterations"], end["finished"]) for end in ends(tmp_path)] == [(2, False)] * SIZE
    assert (tmp_path / "run" / "model_2.pt").is_file()


def test_the_main_process_evaluates_and_all_end_when_the_task_is_solved(tmp_path):
    statuses, errors = together(tmp_path, train_until_solved)
    assert statuses == [0, 0], errors
    assert [end["end"] for end in ends(tmp_path)] == [[True, True, 3, 3], [True, True, 3, 0]]


def test_a_process_whose_peer_died_ends_at_once_with_one_line(tmp_path):
    begin = time.monotonic()
    statuses, errors = together(tmp_path, train_and_kill_one, timeout_s=200.0)
    assert statuses == [cli.USAGE_ERROR, 9]
    assert errors[0].startswith("error: process 0 lost another process of this training")
    assert len(errors[0].splitlines()) == 1
    assert time.monotonic() - begin < 150.0


def test_a_process_whose_peer_hangs_waits_no_longer_than_it_was_told(tmp_path):
    statuses, errors = together(tmp_path, train_and_hang_one, timeout_s=8.0)
    assert statuses[0] == cli.USAGE_ERROR
    assert "lost another process" in errors[0]


def test_policies_that_differ_are_named(tmp_path):
    statuses, errors = together(tmp_path, disagree)
    assert statuses == [cli.USAGE_ERROR] * SIZE
    assert "the policy of process 1 is not that of process 0" in errors[0]


def test_the_script_continues_a_run_of_two_processes_to_the_bytes_of_one_that_never_stopped(tmp_path):
    common = ["--distributed", "--task=Cartpole", "--device=cpu", "--num_envs=8", "--seed=3", "agent.save_interval=2"]
    whole = [*common, "--run_name=whole", "--max_iterations=4"]
    half = [*common, "--run_name=half", "--max_iterations=2"]
    rest = [*common, "--run_name=rest", "--max_iterations=4", "--resume", "--load_run=.*_half"]
    for job in (whole, half, rest):
        statuses, errors = together(tmp_path, job)
        assert statuses == [0, 0], errors
    assert "continuing the episodes of iteration 2" in (tmp_path / "stdout0").read_text()
    assert (tmp_path / "stdout1").read_text() == ""
    models = {run: next(tmp_path.glob(f"logs/rsl_rl/*/*_{run}/model_4.pt")) for run in ("whole", "rest")}
    assert filecmp.cmp(models["whole"], models["rest"], shallow=False)
    states = [load_torch(models["whole"].with_name(f"{kind}_state_4.pt"))["obs"] for kind in ("resume", "rank1")]
    assert not equal(*states)


def test_without_torchrun_the_flag_says_how_to_start(monkeypatch):
    for name in ("RANK", "WORLD_SIZE"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(ConfigError, match="torchrun --nproc_per_node"):
        distributed.place(True)
    assert distributed.place(False) == distributed.Place()


def test_torchrun_without_the_flag_is_a_mistake(monkeypatch):
    variables = {"RANK": 1, "LOCAL_RANK": 1, "WORLD_SIZE": 4, "LOCAL_WORLD_SIZE": 2, "MASTER_ADDR": "a"}
    for name, value in (variables | {"MASTER_PORT": 1, "TORCHELASTIC_RUN_ID": "x"}).items():
        monkeypatch.setenv(name, str(value))
    with pytest.raises(ConfigError, match="add --distributed"):
        distributed.place(False)
    place = distributed.place(True)
    assert (place.rank, place.local_rank, place.world_size, place.local_world_size) == (1, 1, 4, 2)
    assert not place.is_main


def test_processes_of_a_machine_share_its_cpus_and_need_a_gpu_each(monkeypatch):
    monkeypatch.setattr(distributed, "available_cpus", lambda: 16)
    place = distributed.Place(rank=5, local_rank=1, world_size=8, local_world_size=4)
    assert place.num_threads() == 4
    assert distributed.Place().num_threads() == 16
    monkeypatch.setattr(torch.cuda, "device_count", lambda: 4)
    assert place.device("cuda") == place.device("cuda:0") == "cuda:1"
    assert place.device("cpu") == "cpu"
    monkeypatch.setattr(torch.cuda, "device_count", lambda: 1)
    with pytest.raises(ConfigError, match="4 processes on this machine but 1 GPUs"):
        place.device("cuda:0")

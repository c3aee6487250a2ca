"""One vocabulary: what other libraries and older runs call a scalar is read and written under one name."""

import numpy as np
import pytest
from torch.utils.tensorboard import SummaryWriter

from lift_lab_rl.scalar_names import in_order, renamed_evaluation, renamed_scalars
from lift_lab_rl.study.curves import find_runs

OLD = {
    "Reward / Total reward (mean)": 1.0,
    "Reward / Instantaneous reward (min)": 2.0,
    "Episode / Total timesteps (max)": 3.0,
    "Loss / Entropy loss": 4.0,
    "Metrics/object_pose/success": 5.0,
    "Metrics/object_pose/position_error": 6.0,
}
PRESENT = {
    "Train/mean_reward": 1.0,
    "Train/min_step_reward": 2.0,
    "Train/max_episode_length": 3.0,
    "Loss/entropy_loss": 4.0,
    "Metrics/success_rate": 5.0,
    "Metrics/object_pose/position_error": 6.0,
}


def test_an_older_runs_curves_are_read_under_the_present_names(tmp_path):
    writer = SummaryWriter(str(tmp_path / "run"))
    for tag, value in OLD.items():
        writer.add_scalar(tag, value, 1)
    writer.close()
    (run,) = find_runs([tmp_path])
    assert {tag: float(values[0]) for tag, (_, values) in run.scalars.items()} == PRESENT


def test_of_two_names_the_present_one_counts():
    old, present = np.zeros(1), np.ones(1)
    assert renamed_scalars({"Train/mean_reward": present, "Reward / Total reward (mean)": old}) == {
        "Train/mean_reward": present
    }
    assert renamed_scalars({"Reward / Total reward (mean)": old, "Train/mean_reward": present}) == {
        "Train/mean_reward": present
    }


def test_an_older_evaluation_is_read_under_the_present_keys():
    old = {
        "episodes": 10,
        "success": {"10": 0.9},
        "success_interval": {"10": [0.6, 1.0]},
        "reward_mean": 1.0,
        "reward_std": 2.0,
        "reward_min": 3.0,
        "reward_max": 4.0,
        "length_mean": 5.0,
        "length_min": 6,
        "time_to_success_s": 0.5,
        "ends": {"time_out": 10},
        "logs": {"Metrics/pose/success": 0.9, "Metrics/pose/error": 0.1},
    }
    assert renamed_evaluation(old) == {
        "episodes": 10,
        "success_rate": {"10": 0.9},
        "success_rate_interval": {"10": [0.6, 1.0]},
        "mean_reward": 1.0,
        "std_reward": 2.0,
        "min_reward": 3.0,
        "max_reward": 4.0,
        "mean_episode_length": 5.0,
        "min_episode_length": 6,
        "time_to_success_s": 0.5,
        "terminations": {"time_out": 10},
        "logs": {"Metrics/success_rate": 0.9, "Metrics/pose/error": 0.1},
    }
    assert renamed_evaluation(renamed_evaluation(old)) == renamed_evaluation(old)


def test_success_comes_first_and_unknown_groups_last():
    tags = ["Zebra/x", "Loss/value", "Metrics/a", "Train/mean_reward", "Metrics/success_rate"]
    assert in_order(tags) == ["Metrics/success_rate", "Train/mean_reward", "Metrics/a", "Loss/value", "Zebra/x"]


@pytest.mark.parametrize("library", ["sb3", "skrl"])
def test_no_two_scalars_of_a_library_get_one_name(library):
    from lift_lab_rl import scalar_names

    names = [name for name, _ in getattr(scalar_names, f"{library.upper()}_NAMES").values()]
    assert len(set(names)) == len(names)


def test_stable_baselines3_shows_and_writes_our_names_with_success_first(tmp_path, capsys):
    pytest.importorskip("stable_baselines3")
    from lift_lab_rl.sb3_runs import log_to
    from lift_lab_rl.study.curves import read_scalars

    class Agent:
        def set_logger(self, logger):
            self.logger = logger

    agent = Agent()
    log_to(agent, tmp_path)
    for name, value in (("Curriculum/a", 1.0), ("Metrics/success_rate", 0.5), ("train/entropy_loss", -1.25)):
        agent.logger.record(name, value)
    agent.logger.dump(7)
    agent.logger.close()
    scalars = {tag: (steps.tolist(), values.tolist()) for tag, (steps, values) in read_scalars(tmp_path).items()}
    assert scalars == {
        "Curriculum/a": ([7], [1.0]),
        "Metrics/success_rate": ([7], [0.5]),
        "Loss/entropy": ([7], [1.25]),
    }
    table = [line for line in capsys.readouterr().out.splitlines() if line.startswith("|")]
    assert "success_rate" in table[0]

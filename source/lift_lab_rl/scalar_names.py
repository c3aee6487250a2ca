"""Names of scalars: what other libraries and older runs call them, and what we call them.

There is one vocabulary: Isaac Lab's names for what the environment logs (``Episode_Reward/<term>``,
``Episode_Termination/<term>``, ``Curriculum/<term>``, ``Metrics/<name>``), and rsl_rl's names for the learner's
(``Loss/...``, ``Policy/...``, ``Perf/...``, ``Train/...``). ``Evaluation/...`` is ours. ``docs/logging.md`` lists every
scalar.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

SUCCESS_RATE = "Metrics/success_rate"
"""Share of the episodes that ended with success; the metrics term ``success`` of a task."""

SPREAD = ("mean", "max", "min")
"""Statistics of rewards and lengths, in the order in which they are written."""

OLD_NAMES: dict[str, str] = {
    "Loss / Entropy loss": "Loss/entropy_loss",
    "Loss/value_function": "Loss/value",
    **{f"Reward / Total reward ({kind})": f"Train/{kind}_reward" for kind in SPREAD},
    **{f"Episode / Total timesteps ({kind})": f"Train/{kind}_episode_length" for kind in SPREAD},
    **{f"Reward / Instantaneous reward ({kind})": f"Train/{kind}_step_reward" for kind in SPREAD},
}
"""Names in the event files of older runs of rsl_rl."""

_OLD_SUCCESS = re.compile(r"Metrics/\w+/success")
"""The success rate of older runs, which had the command's name in it."""

SKRL_NAMES: dict[str, tuple[str, float]] = {
    **{old: (new, 1.0) for old, new in OLD_NAMES.items() if " / " in old},
    "Loss / Policy loss": ("Loss/surrogate", 1.0),
    "Loss / Value loss": ("Loss/value", 1.0),
    "Learning / Learning rate": ("Loss/learning_rate", 1.0),
    "Policy / Standard deviation": ("Policy/mean_std", 1.0),
    "Stats / Inference time (ms)": ("Perf/inference_time", 1e-3),
    "Stats / Env stepping time (ms)": ("Perf/env_step_time", 1e-3),
    "Stats / Algorithm update time (ms)": ("Perf/learning_time", 1e-3),
}
"""Names of skrl's PPO, with the factor that makes the value ours."""

SB3_NAMES: dict[str, tuple[str, float]] = {
    "rollout/ep_rew_mean": ("Train/mean_reward", 1.0),
    "rollout/ep_len_mean": ("Train/mean_episode_length", 1.0),
    "time/fps": ("Perf/total_fps", 1.0),
    "train/policy_gradient_loss": ("Loss/surrogate", 1.0),
    "train/value_loss": ("Loss/value", 1.0),
    "train/entropy_loss": ("Loss/entropy", -1.0),
    "train/approx_kl": ("Loss/kl", 1.0),
    "train/clip_fraction": ("Loss/clip_fraction", 1.0),
    "train/explained_variance": ("Loss/explained_variance", 1.0),
    "train/loss": ("Loss/total", 1.0),
    "train/learning_rate": ("Loss/learning_rate", 1.0),
    "train/clip_range": ("Policy/clip_range", 1.0),
    "train/clip_range_vf": ("Policy/clip_range_vf", 1.0),
    "train/std": ("Policy/mean_std", 1.0),
    "train/n_updates": ("Perf/num_updates", 1.0),
}
"""Names of Stable-Baselines3's PPO, with the factor that makes the value ours."""

OLD_EVALUATION_KEYS: dict[str, str] = {
    "success": "success_rate",
    "success_interval": "success_rate_interval",
    **{f"reward_{kind}": f"{kind}_reward" for kind in (*SPREAD, "std")},
    **{f"length_{kind}": f"{kind}_episode_length" for kind in ("mean", "min")},
    "ends": "terminations",
}
"""Keys of an evaluation in older results files."""


def renamed_scalars(scalars: Mapping[str, Any]) -> dict[str, Any]:
    """Scalars of a run under our present names. Where a run has both names, the present one counts.

    Args:
        scalars: tag -> curve, as they are in an event file.
    """
    names = {tag: SUCCESS_RATE if _OLD_SUCCESS.fullmatch(tag) else OLD_NAMES.get(tag, tag) for tag in scalars}
    old = {name: scalars[tag] for tag, name in names.items() if name != tag}
    return old | {tag: scalars[tag] for tag, name in names.items() if name == tag}


def renamed_evaluation(entry: Mapping[str, Any]) -> dict[str, Any]:
    """An evaluation under our present keys.

    Args:
        entry: what ``evaluate`` wrote, now or in an older version.
    """
    found = {OLD_EVALUATION_KEYS.get(key, key): value for key, value in entry.items()}
    if isinstance(found.get("logs"), dict):
        found["logs"] = renamed_scalars(found["logs"])
    return found


def in_order(tags: Iterable[str]) -> list[str]:
    """Tags in the order in which people are shown them: success first, then the groups as :data:`GROUPS` has them."""
    rank = {name: k for k, name in enumerate(GROUPS)}

    def place(tag: str) -> tuple[int, int]:
        return (tag != SUCCESS_RATE, rank.get(tag.partition("/")[0], len(rank)))

    return sorted(tags, key=place)  # stable: within a group the order stays


GROUPS: dict[str, str] = {
    "Train": "Reward and length of episodes",
    "Metrics": "Metrics of the task",
    "Evaluation": "Evaluation on held-out starts",
    "Episode_Reward": "Reward terms",
    "Episode_Termination": "Why episodes end",
    "Curriculum": "Curriculum",
    "Loss": "Losses and learning rate",
    "Policy": "Exploration noise",
    "Perf": "Speed",
    "Rnd": "Random network distillation",
    "Episode": "Other entries of the environment",
}
"""Groups of scalars by the part of their tag before the first slash, and their titles."""

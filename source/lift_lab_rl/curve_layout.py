"""The order of curves in TensorBoard: a page (Custom Scalars) with success first, as one event of a run's file."""

from __future__ import annotations

import re
from typing import Any

from .scalar_names import GROUPS, SUCCESS_RATE

OVERVIEW = {
    "success rate": SUCCESS_RATE,
    "mean reward": "Train/mean_reward",
    "mean episode length": "Train/mean_episode_length",
}
"""Charts of the first section, and their scalars."""


def layout() -> dict[str, dict[str, list[Any]]]:
    """Sections of TensorBoard's page "Custom Scalars", in the form that ``SummaryWriter.add_custom_scalars`` takes.

    The overview comes first, then each group of scalars: all scalars of a group in one chart.
    """
    charts: dict[str, list[Any]] = {title: ["Multiline", [f"^{re.escape(tag)}$"]] for title, tag in OVERVIEW.items()}
    return {"Overview": charts} | {title: {name: ["Multiline", [f"^{name}/"]]} for name, title in GROUPS.items()}


def layout_summary() -> Any:
    """The same as a summary for an event file."""
    from torch.utils.tensorboard.summary import custom_scalars

    return custom_scalars(layout())

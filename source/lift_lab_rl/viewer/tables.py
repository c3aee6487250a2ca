"""The panel's live figures as small HTML tables."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

import numpy as np

from lift_lab.visualizers import Contact, sum_by_pair

_STYLE = "font-size:11px;width:100%;padding:0 1em;border-spacing:0"


def table(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Rows under headings; all but the first column to the right."""

    def line(cells: Sequence[object], tag: str) -> str:
        styles = ["text-align:left;overflow-wrap:anywhere", *["text-align:right;white-space:nowrap"] * (len(cells) - 1)]
        return "".join(f'<{tag} style="{s}">{escape(str(c))}</{tag}>' for c, s in zip(cells, styles, strict=True))

    body = "".join(f"<tr>{line(row, 'td')}</tr>" for row in rows)
    return f'<table style="{_STYLE}"><tr>{line(columns, "th")}</tr>{body}</table>'


def join(*tables: str) -> str:
    """Tables below each other, without empty ones."""
    return "<br>".join(part for part in tables if part)


def rewards(env: Any, env_id: int) -> str:
    """Each reward term: weight, its value now (per second), and its sum over the running episode."""
    manager = env.reward_manager
    now = {name: values[0] for name, values in manager.get_active_iterable_terms(env_id)}
    sums = dict(zip(manager.active_terms, manager.term_sums[:, env_id].tolist(), strict=True))
    rows = [
        (name, f"{manager.get_term_cfg(name).weight:g}", f"{now[name]:.3f}", f"{sums[name]:.3f}")
        for name in manager.active_terms
    ]
    rows.append(("all", "", f"{sum(now.values()):.3f}", f"{sum(sums.values()):.3f}"))
    return table(("reward", "weight", "now", "episode"), rows)


def commands(env: Any, env_id: int) -> str:
    """Each command and its metrics, then the metrics of no command."""
    manager, rows = env.command_manager, []
    metrics = {name: values[0] for name, values in env.metrics_manager.get_active_iterable_terms(env_id)}
    for name, values in manager.get_active_iterable_terms(env_id):
        rows.append((name, " ".join(f"{value:.2f}" for value in values)))
        own = {metric: float(tensor[env_id]) for metric, tensor in manager.get_term(name).metrics.items()}
        of_command = [metric for metric in metrics if metric.startswith(f"{name}/")]
        own |= {metric.removeprefix(f"{name}/"): metrics.pop(metric) for metric in of_command}
        rows += [(f"· {metric}", _number(value)) for metric, value in own.items()]
    rows += [(metric, _number(value)) for metric, value in metrics.items()]
    return table(("command", "value"), rows) if rows else ""


def _number(value: float) -> str:
    """Three decimals, or a dash for what has no value yet."""
    return "-" if math.isnan(value) else f"{value:.3f}"


def curriculum(env: Any) -> str:
    """State of each curriculum term; empty before the first reset and without terms."""
    rows = [
        (name, " ".join(f"{value:g}" for value in values))
        for name, values in env.curriculum_manager.get_active_iterable_terms(0)
    ]
    return table(("curriculum", "value"), rows) if rows else ""


def contacts(found: list[Contact], body_names: list[str]) -> str:
    """Contact points of each pair of bodies that touch, and the size of their summed force; empty if none touch."""
    rows = [
        (f"{body_names[body]} ← {body_names[other]}", count, f"{np.linalg.norm(force):.2f} N")
        for (body, other), (count, force) in sum_by_pair(found).items()
    ]
    return table(("contact: on ← from", "points", "force"), rows) if rows else ""


def episode(env: Any, env_id: int, success: Any) -> str:
    """The running episode, and success."""
    step = int(env.episode_length_buf[env_id])
    rows: list[tuple[str, str]] = [
        ("time", f"{step * env.step_dt:.2f} of {env.max_episode_length_s:g} s"),
        ("reward of the step", f"{float(env.reward_buf[env_id]):.4f}"),
    ]
    if success.is_known:
        rows.append(("success", "yes" if success.has_succeeded(env_id) else "not yet"))
        rate = "-" if success.rate is None else f"{success.rate:.0%} of {success.episodes}"
        rows.append(("episodes that succeeded, all environments", rate))
    return table(("episode", ""), rows)

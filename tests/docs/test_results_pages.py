"""Pages of results agree with the settings and the pretrained policies that ship."""

import json
import re
from pathlib import Path

import pytest

import lift_lab_tasks  # noqa: F401
from lift_lab_assets.files import PRETRAINED_DIR
from lift_lab_tasks.utils import load_cfg_from_registry, parse_env_cfg

ROOT = Path(__file__).resolve().parents[2]
LEARNING = (ROOT / "docs" / "learning.md").read_text()
COLUMNS = {
    "lift": "Lift-Cube-Franka-CL",
    "lift, IK-Rel": "Lift-Cube-Franka-IK-Rel",
    "lift, IK-Abs": "Lift-Cube-Franka-IK-Abs",
    "reach": "Reach-Franka",
    "drawer": "Open-Drawer-Franka",
    "cart-pole": "Cartpole",
}
"""Head of a column in the table of settings -> task."""


def table(page: str, head: str) -> list[dict[str, str]]:
    """Rows of the first table of a page whose first cell in the head is this, by head of the column."""
    lines = page.splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith(f"| {head} |"))
    cells = [
        [cell.strip() for cell in line.strip("| ").split(" | ")]
        for line in lines[first:]
        if set(line) - set("|-")  # not the line below the head
    ]
    end = next(i for i, line in enumerate(lines[first:]) if not line.startswith("|"))
    return [dict(zip(cells[0], row, strict=True)) for row in cells[1 : end - 1]]


def schedule(value: float, final: float | None) -> list[float]:
    return [value] if final is None else [value, final]


def settings(task: str) -> dict[str, object]:
    """The settings of a task's agent as the page writes them."""
    agent = load_cfg_from_registry(task, "rsl_rl_cfg_entry_point")
    ppo, policy = agent.algorithm, agent.policy
    return {
        "hidden layers": "-".join(map(str, policy.actor_hidden_dims)),
        "normalised observations": "yes" if policy.actor_obs_normalization else "no",
        "steps in a rollout": str(agent.num_steps_per_env),
        "epochs": str(ppo.num_learning_epochs),
        "`gamma`": schedule(ppo.gamma, ppo.gamma_final),
        "`desired_kl`": schedule(ppo.desired_kl, ppo.desired_kl_final),
        "`entropy_coef`": schedule(ppo.entropy_coef, ppo.entropy_coef_final),
        "clipped value loss": "yes" if ppo.use_clipped_value_loss else "no",
        "`mean_reg_coef`": [ppo.mean_reg_coef],
        "`average_share`": [agent.average_share],
    }


@pytest.mark.parametrize("column", COLUMNS)
def test_the_table_of_settings_is_that_of_the_code(column):
    expected = settings(COLUMNS[column])
    rows = {row["setting"]: row[column] for row in table(LEARNING, "setting")}
    assert expected.keys() <= rows.keys()
    for name, value in expected.items():
        shown = rows[name]
        assert (shown if isinstance(value, str) else [float(part) for part in shown.split(" to ")]) == value, name


@pytest.mark.parametrize("row", table(LEARNING, "task"), ids=lambda row: row["task"].strip("`"))
def test_environments_iterations_and_samples_are_the_defaults(row):
    task = row["task"].strip("`")
    agent = load_cfg_from_registry(task, "rsl_rl_cfg_entry_point")
    num_envs = parse_env_cfg(task, device="cpu").scene.num_envs
    assert int(row["environments"].replace(",", "")) == num_envs
    assert int(row["iterations"].replace(",", "")) == agent.max_iterations
    samples = num_envs * agent.max_iterations * agent.num_steps_per_env
    assert row["samples"] == f"{samples / 1e6:.1f} M"


def test_every_pretrained_policy_is_listed_with_the_success_of_its_card():
    rows = table((ROOT / "docs" / "pretrained.md").read_text(), "task")
    shown = {row["task"].strip("`"): row["success in 1,000 episodes (several `--seed`)"] for row in rows}
    cards = {path.parent.name: json.loads(path.read_text()) for path in PRETRAINED_DIR.glob("*/card.json")}
    assert shown.keys() == cards.keys()
    for task, card in cards.items():
        percents = [float(number) for number in re.findall(r"[\d.]+(?= (?:%|to|and))", shown[task])]
        assert min(percents) <= round(100 * card["evaluation"]["success_rate"]["1000"], 1) <= max(percents), task


@pytest.mark.parametrize("page", ["concepts.md", "soft_objects.md"])
def test_python_of_a_page_runs(page):
    blocks = re.findall(r"^```python\n(.*?)^```$", (ROOT / "docs" / page).read_text(), flags=re.DOTALL | re.MULTILINE)
    assert blocks
    for block in blocks:
        exec(compile(block, page, "exec"), {"__name__": "page"})

"""The report's page: contents, success first, light and dark, nothing beside it; and notes on what runs lack."""

import re

import numpy as np
import pytest

from lift_lab_rl.study.comparison import Roles
from lift_lab_rl.study.curves import Group, TrainingRun
from lift_lab_rl.study.missing import missing_scalars
from lift_lab_rl.study.page import write_report
from lift_lab_tasks.manager_based.manipulation.lift.paper import PAPER

TAGS = [figure.tags[0] for figure in (*PAPER.figures, *PAPER.further)]


def group(label, tags=TAGS):
    curves = {tag: (np.array([1, 2, 3]), np.array([0.1, 0.2, 0.3])) for tag in tags}
    return Group(label, [TrainingRun(label, 1, [], curves)])


def evaluation(rate, logs):
    return {"episodes": 10, "success_rate": {"10": rate}, "mean_reward": 140.0, "logs": dict.fromkeys(logs, 1.0)}


CLAIMED = [claim.tag.removeprefix("evaluation:Metrics") for claim in PAPER.claims if "evaluation:Metrics" in claim.tag]
LOGS = [f"Metrics{tag}" for tag in CLAIMED]
RESULTS = {
    "command": "a command",
    "runs": [
        {"label": "base", "evaluation": evaluation(0.9, LOGS), "perturbed": {"mass=2.0": evaluation(0.5, LOGS)}},
        {"label": "base-CL", "evaluation": evaluation(1.0, LOGS)},
    ],
}


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """The page of a baseline and a curriculum, as text, and its folder."""
    folder = tmp_path_factory.mktemp("report")
    groups = [group("base"), group("base-CL")]
    page = write_report(groups, RESULTS, PAPER, Roles("base", "base-CL"), folder, notes=["one is <missing>"])
    return page.read_text(), folder


def test_the_page_needs_nothing_beside_it_and_every_figure_is_a_file(written):
    text, folder = written
    assert text.count("data:image/png;base64,") == len(TAGS)
    assert not re.search(r"(src|href|url)\s*[=(]\s*[\"']?(?!data:|#)[\w/.]+", text.split("</style>")[1])
    assert "@import" not in text
    assert "url(" not in text.split("</style>")[0]
    files = sorted((folder / "figures").iterdir())
    assert {path.suffix for path in files} == {".png", ".pdf"}
    assert len(files) == 2 * len(TAGS)


def test_the_contents_lead_to_every_section_and_figure_and_success_is_first(written):
    text, _ = written
    targets = re.findall(r"<a href='#([^']+)'", text.split("</nav>")[0])
    ids = re.findall(r" id='([^']+)'", text)
    assert sorted(targets) == sorted(set(ids)) == sorted(ids)
    titles = [title for _, title in re.findall(r"<h2 id='([^']+)'>(.*?)</h2>", text)]
    assert titles == [
        "Success", "Notes", "The paper&#x27;s claims", "End of training", "Evaluation", "Curves", "Runs"
    ]  # fmt: skip
    success = text.split("<h2 id='success'>")[1].split("<h2")[0]
    for part in ("Table 1", "Success at the end of training", "Success under perturbations", "Metrics/success_rate"):
        assert part in success
    assert "one is &lt;missing&gt;" in text


def test_the_page_names_the_paper_and_says_which_scalar_each_figure_shows(written):
    text, _ = written
    assert PAPER.citation in text
    assert "We compare <strong>base</strong> with its baseline and <strong>base-CL</strong> with its curriculum" in text
    captions = dict(re.findall(r"<figcaption>(.*?) <code>(.*?)</code></figcaption>", text))
    assert captions["Fig. 21. Total Reward: Mean"] == "Train/mean_reward"
    assert captions["Fig. 11. Fine-Grained Tracking Reward"] == "Episode_Reward/object_goal_tracking_fine_grained"
    assert captions["Squared Action Change"] == "Metrics/object_pose/squared_action_change"


def test_the_page_follows_the_readers_light_or_dark(written):
    style = written[0].split("</style>")[0]
    assert "prefers-color-scheme: dark" in style
    assert "color-scheme: light dark" in style


def test_groups_stand_in_the_papers_order():
    groups = [group("other"), group("cl"), group("base")]
    assert [g.label for g in Roles("base", "cl").ordered(groups)] == ["base", "cl", "other"]


def test_runs_with_every_scalar_get_no_note():
    assert missing_scalars([group("base"), group("base-CL")], RESULTS, PAPER) == []


def test_a_renamed_term_is_one_line_with_what_was_looked_for_and_what_there_is():
    tags = [tag for tag in TAGS if "fine_grained" not in tag] + ["Episode_Reward/fine_tracking", "Loss/rnd"]
    (line,) = missing_scalars([group("mine", tags)], {}, PAPER)
    assert line == (
        "the runs of 'mine' have no Episode_Reward/object_goal_tracking_fine_grained (Fig. 11 Fine-Grained Tracking "
        "Reward); they have Episode_Reward/fine_tracking, which no figure uses"
    )


def test_the_time_to_success_is_not_missed_where_nothing_succeeded():
    runs = group("mine", [tag for tag in TAGS if "time_to_success" not in tag])
    (line,) = missing_scalars([runs], {}, PAPER)
    assert "time_to_success_s (Time to Success)" in line
    steps, values = runs.runs[0].scalars["Metrics/success_rate"]
    runs.runs[0].scalars["Metrics/success_rate"] = (steps, 0.0 * values)
    assert missing_scalars([runs], {}, PAPER) == []


def test_what_an_evaluation_lacks_for_a_claim_is_named():
    results = {"runs": [{"label": "mine", "evaluation": evaluation(1.0, [*LOGS[1:], "Metrics/jerk"])}]}
    (line,) = missing_scalars([group("mine")], results, PAPER)
    assert line.startswith(f"the evaluations of 'mine' have no {LOGS[0]} ('")
    assert line.endswith("they have Metrics/jerk, which no figure uses")


def test_runs_of_another_task_get_a_line_for_each_group_of_scalars():
    lines = missing_scalars([group("poles", ["Episode_Reward/alive", "Train/mean_reward"])], {}, PAPER)
    missing = {tag.partition("/")[0] for tag in TAGS} - {"Episode_Reward"}
    assert len(lines) == len(missing) + 1
    assert sum("Episode_Reward/alive, which no figure uses" in line for line in lines) == 1

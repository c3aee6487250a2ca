"""Reports join continued runs, average over seeds, and set our numbers beside the study's."""

import json
import re

import numpy as np
import pytest
from scipy import stats
from torch.utils.tensorboard import SummaryWriter

from lift_lab.utils.errors import ConfigError, FileError
from lift_lab.utils.io import dump_yaml
from lift_lab_rl.intervals import wilson_interval
from lift_lab_rl.study import comparison
from lift_lab_rl.study.comparison import Roles, verdict
from lift_lab_rl.study.curves import Group, TrainingRun, find_runs, group_runs, remarks, smooth
from lift_lab_rl.study.evaluations import collect, find_results, load_results
from lift_lab_rl.study.figures import draw, save
from lift_lab_tasks.manager_based.manipulation.lift.paper import PAPER

REWARD = "Train/mean_reward"
SUCCESS = "Metrics/success_rate"


def _write(folder, tags, first=1, seed=None, run_name="", task=None, **run):
    """A run's folder: tag -> values from iteration ``first`` on."""
    writer = SummaryWriter(str(folder))
    for tag, values in tags.items():
        for k, value in enumerate(values):
            writer.add_scalar(tag, value, first + k)
    writer.close()
    if seed is not None:
        dump_yaml(folder / "params" / "agent.yaml", {"seed": seed, "run_name": run_name})
    if task is not None:
        dump_yaml(folder / "params" / "run.yaml", {"task": task, **run})


# -- curves


def test_a_place_may_have_an_equals_sign_in_its_name(tmp_path):
    place = tmp_path / "lr=1" / "study"
    _write(place / "2026-01-01_00-00-00_x-s7", {REWARD: [1, 2]}, seed=7, run_name="x-s7")
    (plain,), (named,) = find_runs([place]), find_runs([f"mine={place}"])
    assert named.label == "mine"
    assert plain.label != "mine"


def test_a_continued_run_is_one_curve_and_what_was_done_again_counts(tmp_path):
    _write(tmp_path / "2026-01-01_00-00-00_x-s7", {REWARD: [1, 2, 3, 4]}, seed=7, run_name="x-s7")
    _write(tmp_path / "2026-01-01_01-00-00_x-s7", {REWARD: [30, 40, 50]}, first=3, seed=7, run_name="x-s7")
    (run,) = find_runs([tmp_path])
    steps, values = run.scalars[REWARD]
    assert steps.tolist() == [1, 2, 3, 4, 5]
    assert values.tolist() == [1, 2, 30, 40, 50]
    assert (run.label, run.seed, run.iterations, len(run.folders)) == ("x", 7, 5, 2)


def test_a_run_that_branches_off_another_begins_with_its_curve(tmp_path):
    _write(tmp_path / "2026-01-01_00-00-00_cl-s7", {REWARD: [1, 2, 3, 4]}, seed=7, run_name="cl-s7")
    for time, name, origin in (("01", "b-s7", "2026-01-01_00-00-00_cl-s7"), ("02", "c-s7", "2026-01-01_01-00-00_b-s7")):
        folder = tmp_path / f"2026-01-01_{time}-00-00_{name}"
        _write(folder, {REWARD: [10 * int(time)] * 2}, first=2 + int(time), seed=7, run_name=name)
        dump_yaml(folder / "params" / "run.yaml", {"task": "T", "continues": f"{origin}/model_2.pt"})
    curves = {run.label: run.scalars[REWARD] for run in find_runs([tmp_path])}
    assert {label: values.tolist() for label, (_, values) in curves.items()} == {
        "cl": [1, 2, 3, 4],
        "b": [1, 2, 10, 10],
        "c": [1, 2, 10, 20, 20],
    }
    assert curves["c"][0].tolist() == [1, 2, 3, 4, 5]
    (alone,) = find_runs([tmp_path / "2026-01-01_01-00-00_b-s7"])
    assert alone.scalars[REWARD][0].tolist() == [3, 4]  # the run it branched off is not given


def test_runs_without_a_name_stay_apart_and_are_labelled_by_task(tmp_path):
    for hour in (1, 2):
        _write(tmp_path / f"2026-01-01_0{hour}-00-00", {REWARD: [1.0]}, seed=1, task="Lift-Cube-Franka")
    runs = find_runs([tmp_path])
    assert [run.label for run in runs] == ["Lift-Cube-Franka"] * 2
    assert [run.label for run in find_runs([f"mine={tmp_path}"])] == ["mine"] * 2
    with pytest.raises(FileError, match="no event files"):
        find_runs([tmp_path / "2026-01-01_01-00-00" / "params"])


def test_a_run_counts_once_however_often_it_is_given(tmp_path):
    place = tmp_path / "2026-01-01_00-00-00"
    _write(place, {REWARD: [1.0]}, seed=1, task="T")
    (run,) = find_runs([tmp_path, place, f"{tmp_path}/../{tmp_path.name}"])
    assert run.folders == [place]
    with pytest.raises(ConfigError, match="given twice, with different labels"):
        find_runs([tmp_path, f"mine={place}"])


def test_runs_of_other_overrides_have_other_labels_and_a_repeated_seed_is_told(tmp_path):
    for hour, overrides in enumerate(([], ["env.x=1", "agent.seed=1"], ["agent.seed=1"])):
        folder = tmp_path / f"2026-01-01_0{hour}-00-00"
        _write(folder, {REWARD: [1.0]}, seed=1, task="T", overrides=overrides)
    runs = find_runs([tmp_path])
    assert [run.label for run in runs] == ["T", "T env.x=1", "T"]
    (remark,) = remarks(runs)
    assert "'T' has 2 runs of seed 1" in remark


def test_runs_are_joined_only_where_one_goes_on_from_the_other(tmp_path):
    for hour in (1, 2):  # two trainings of one name and seed
        folder = tmp_path / f"2026-01-01_0{hour}-00-00_again"
        _write(folder, {REWARD: [hour, hour]}, seed=1, run_name="again", task="T")
    last = tmp_path / "2026-01-01_03-00-00_third"
    origin = "2026-01-01_02-00-00_again/model_2.pt"
    _write(last, {REWARD: [3.0]}, first=3, seed=1, run_name="third", task="T", continues=origin)
    first, second = find_runs([last, tmp_path])[::-1]
    assert first.scalars[REWARD][1].tolist() == [1, 1]
    assert second.scalars[REWARD][1].tolist() == [2, 2, 3]


def test_a_run_without_curves_is_left_out_and_told(tmp_path):
    (tmp_path / "full").mkdir()
    _write(tmp_path / "full", {REWARD: [1.0]})
    _write(tmp_path / "begun", {})
    runs = find_runs([f"x={tmp_path}"])
    (group,) = group_runs(runs)
    assert len(group.runs) == 1
    (remark,) = remarks(runs)
    assert "begun' is left out" in remark
    with pytest.raises(FileError, match="no curves in"):
        group_runs(find_runs([tmp_path / "begun"]))


@pytest.mark.parametrize(("first", "content"), [(0.5, None), (0.5, b"\0" * 40), (0.0, b"words\n")])
def test_an_event_file_that_cannot_be_read_to_its_end_is_told(tmp_path, first, content):
    for name in ("whole", "damaged"):
        _write(tmp_path / name, {"Train/mean_reward": [1.0, 2.0, 3.0, 4.0]}, seed=1, run_name=name)
    (path,) = (tmp_path / "damaged").glob("events.out.*")
    whole = path.read_bytes()
    half = whole[: int(len(whole) * first)]
    path.write_bytes(half + (content or b""))
    lines = [line for line in remarks(find_runs([tmp_path])) if "later points" in line]
    assert len(lines) == 1
    size = len(half + (content or b""))
    assert re.fullmatch(rf"'{path}' is damaged after \d+ of {size} bytes: later points .* are missing", lines[0])


def test_a_group_averages_seeds_over_environment_steps(tmp_path):
    # 100 steps an iteration in one run, 200 in the other: at 200 steps they are at iterations 2 and 1
    _write(tmp_path / "a", {REWARD: [0, 1, 2, 3], "Perf/total_steps": [100, 200, 300, 400]})
    _write(tmp_path / "b", {REWARD: [5, 9], "Perf/total_steps": [200, 400]})
    (group,) = group_runs(find_runs([f"same={tmp_path}"]))
    band = group.band([REWARD])
    assert band.steps.tolist() == [100, 200, 300, 400]
    assert band.mean.tolist() == [0, (1 + 5) / 2, (2 + 7) / 2, (3 + 9) / 2]
    assert band.low.tolist() == [0, 1, 2, 3]
    assert band.high.tolist() == [0, 5, 7, 9]
    assert group.at_end([REWARD], tail=0.5) == [2.5, 9.0]
    assert group.at_end(["none", REWARD], tail=0.0) == [3.0, 9.0]
    assert group.band(["none"]) is None


def test_smoothing_keeps_a_constant_and_weighs_the_past():
    assert smooth(np.full(5, 2.0), 0.9).tolist() == pytest.approx([2.0] * 5)
    # (0.5 * 0.5 * 1 + 0.5 * 3) / (0.5 * 0.5 + 0.5)
    assert smooth(np.array([1.0, 3.0]), 0.5)[1] == pytest.approx((0.25 + 1.5) / 0.75)


# -- tables


def test_the_studys_rewards_add_up_to_its_total():
    ends = {figure.number: figure for figure in PAPER.figures}
    for side, total in (("baseline", 134.98), ("curriculum", 142.87)):
        rates = [getattr(ends[number], side) for number in range(7, 13)]
        assert sum(rates) * 5.0 == pytest.approx(total, rel=0.01)
    assert sorted(ends) == list(range(4, 23))
    assert [row.curriculum / row.episodes for row in PAPER.table] == [1.0, 1.0, 0.99]


@pytest.mark.parametrize(
    ("sign", "difference", "ends", "expected"),
    [
        (1, 2.0, (1.0, 3.0), "as the paper"),
        (-1, 2.0, (1.0, 3.0), "opposite"),
        (1, 2.0, (-1.0, 5.0), "undecided"),
        (-1, -2.0, None, "as the paper (too few seeds for an interval)"),
    ],
)
def test_a_claim_holds_where_the_interval_of_the_difference_has_its_sign(sign, difference, ends, expected):
    assert verdict(sign, difference, ends) == expected


def _group(label, task=None, seeds=(1,), start=None, **scalars):
    runs = []
    for k, seed in enumerate(seeds):
        curves = {tag: (np.array([1]), np.array([values[k]], float)) for tag, values in scalars.items()}
        runs.append(TrainingRun(label, seed, [], curves, task, None if start is None else start.runs[k]))
    return Group(label, runs)


def test_roles_go_to_the_studys_tasks_unless_they_are_asked_for():
    groups = [_group("linear", "lift_lab_tasks:Lift-Cube-Franka-CL"), _group("plain", "Lift-Cube-Franka")]
    assert Roles.guess(groups, PAPER) == Roles("plain", "linear")
    others = [_group("a", "Cartpole"), _group("b"), _group("a-CL", "Reach-Franka")]
    assert Roles.guess(others, PAPER) == Roles()
    assert Roles.guess(others, PAPER, curriculum="b") == Roles(None, "b")
    with pytest.raises(ConfigError, match="'b' cannot be both"):
        Roles.guess(others, PAPER, "b", "b")
    with pytest.raises(ConfigError, match="no runs are labelled 'plan': did you mean 'plain'"):
        Roles.guess(groups, PAPER, "plan")


def _evaluation(wins, trials, change):
    return {
        "episodes": trials,
        "success_rate": {"10": min(wins, 10) / 10, str(trials): wins / trials},
        "mean_reward": 140.0,
        "logs": {"Metrics/object_pose/squared_action_change": change},
    }


RESULTS = {
    "runs": [
        {
            "label": "base",
            "evaluation": _evaluation(96, 100, 5.0),
            "perturbed": {"mass=2.0": _evaluation(50, 100, 5.0)},
        },
        {"label": "base", "evaluation": _evaluation(98, 100, 6.0)},
        {"label": "base-CL", "evaluation": _evaluation(100, 100, 1.0)},
        {"label": "base-CL", "evaluation": _evaluation(99, 100, 2.0)},
    ]
}


def test_success_is_pooled_over_seeds_beside_the_studys():
    table = comparison.success_table(RESULTS, ["base", "base-CL"], PAPER, Roles("base", "base-CL"))
    low, high = wilson_interval(194, 200)
    assert table.rows[1] == ["base", "100", "96 of 100", "96, 98", f"97.0% [{low:.1%}, {high:.1%}]"]
    assert table.rows[2][:4] == ["base-CL", "10", "10 of 10", "10, 10"]


def test_perturbed_success_stands_under_the_unperturbed():
    table = comparison.generalisation_table(RESULTS, ["base", "base-CL"])
    assert [row[0] for row in table.rows] == ["none", "mass=2.0"]
    assert table.rows[1][1].startswith("50.0% [")
    assert table.rows[1][2] == comparison.NONE


def test_claims_compare_the_ends_of_training_and_the_evaluations(tmp_path):
    for label, ends in (("base", (130.0, 132.0)), ("base-CL", (140.0, 144.0))):
        for k, end in enumerate(ends):
            _write(tmp_path / f"{label}{k}", {REWARD: [0.0, end]})
    places = [f"{label}={tmp_path / label}{k}" for label in ("base", "base-CL") for k in (0, 1)]
    groups = group_runs(find_runs(places))
    table = comparison.claims_table(groups, RESULTS, PAPER, Roles("base", "base-CL"))
    rows = {row[0]: row for row in table.rows}
    assert rows["higher mean total reward"][2:4] == ["131.00", "142.00"]
    welch = stats.ttest_ind([140.0, 144.0], [130.0, 132.0], equal_var=False).confidence_interval(0.95)
    ends = f"[{comparison.number(welch.low)}, {comparison.number(welch.high)}]"
    assert rows["higher mean total reward"][4:] == [f"11.00 {ends}", "undecided"]
    # equal spreads: two degrees of freedom, standard error sqrt(0.5), 4.30265 * 0.70711 = 3.04244
    assert rows["smoother actions"][4:] == ["-4.000 [-7.042, -0.9576]", "as the paper"]


def test_claims_are_paired_by_seed_where_one_side_began_from_the_other():
    curriculum = _group("cl", seeds=(1, 2, 3), **{REWARD: (3.09, 3.33, 3.49)})
    baseline = _group("base", seeds=(1, 2, 3), start=curriculum, **{REWARD: (2.50, 2.85, 3.14)})
    table = comparison.claims_table([curriculum, baseline], {}, PAPER, Roles("base", "cl"))
    ends = stats.ttest_rel([3.09, 3.33, 3.49], [2.50, 2.85, 3.14]).confidence_interval(0.95)
    (row,) = table.rows
    assert row[4:] == [f"0.4733 [{ends.low:.4f}, {ends.high:.4f}]", "as the paper"]
    baseline.runs[0].start = None  # one began anew
    (row,) = comparison.claims_table([curriculum, baseline], {}, PAPER, Roles("base", "cl")).rows
    assert row[5] == "undecided"


# -- evaluations


def _study(folder, label, seed, wins):
    """A study of one run and its results file."""
    run = folder / f"2026-01-01_00-00-00_{label}-s{seed}"
    _write(run, {REWARD: [1.0]}, seed=seed, run_name=f"{label}-s{seed}")
    entry = {"label": label, "seed": seed, "checkpoint": f"/moved/{run.name}/model_1.pt"}
    content = {"command": "study", "runs": [entry | {"evaluation": _evaluation(wins, 100, 1.0)}]}
    (folder / "results.json").write_text(json.dumps(content))
    return run


def _shown(*places):
    runs = find_runs(places)
    results, left_out = collect(find_results(runs), runs)
    groups = group_runs(runs)
    rows = comparison.success_table(results, [group.label for group in groups], PAPER, Roles()).rows
    return {row[0]: row[3] for row in rows if row[1] == "100"}, left_out


def test_evaluations_of_all_places_are_shown_under_the_labels_of_the_report(tmp_path):
    place = tmp_path / "lr=1"
    one, two = _study(place, "x", 1, 90), _study(tmp_path / "b", "x", 1, 80)
    assert one.name == two.name
    assert _shown(f"first={place}", f"second={tmp_path / 'b'}") == ({"first": "90", "second": "80"}, [])
    assert _shown(place) == _shown(one) == ({"x": "90"}, [])
    _write(place / "2026-01-01_00-00-00_y-s1", {REWARD: [1.0]}, seed=1, run_name="y-s1")
    shown, (line,) = _shown(place / "2026-01-01_00-00-00_y-s1")
    assert shown == {}
    assert "'x', seed 1, in" in line
    # a file that is named is matched with runs elsewhere
    named = (place / "results.json").rename(tmp_path / "named.json")
    results, left_out = collect([named], find_runs([two]))
    assert len(results["runs"]) == 1
    assert left_out == []


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"[]", "has no 'runs'"),
        (b'{"episodes": 4, "success": {}}', "has no 'runs'"),
        (b'{"runs": [{"seed": 1}]}', "a run has no 'label'"),
        (
            b'{"runs": [{"label": "a", "seed": 1, "evaluation": {"x": 1}}]}',
            "an evaluation of 'a' has no 'success_rate",
        ),
        (b"\xff\x00", "it is not JSON"),
        (b"{", "it is not JSON"),
    ],
)
def test_a_file_of_other_content_is_no_results_file(tmp_path, content, message):
    (tmp_path / "r.json").write_bytes(content)
    with pytest.raises(FileError, match=message) as caught:
        load_results(tmp_path / "r.json")
    assert "r.json'" in str(caught.value)


# -- curriculum jumps and figures


def test_a_jump_of_a_penalty_is_found_with_the_success_around_it(tmp_path):
    tags = {"Curriculum/action_rate": [-1e-4] * 3 + [-0.1] * 3, SUCCESS: [0.8, 0.9, 1.0, 0.4, 0.7, 0.95]}
    tags["Curriculum/gripper_hold"] = [0.0, 0.1, 0.1, 0.0, 0.0, 0.0]  # no penalty, and earlier
    _write(tmp_path / "jump", tags)
    _write(tmp_path / "ramp", {"Curriculum/action_rate": [-0.1, -0.2, -0.3, -0.4], SUCCESS: [1.0] * 4})
    groups = group_runs(find_runs([tmp_path / "jump", tmp_path / "ramp"]))
    table = comparison.jump_table(groups, [SUCCESS], window=2)
    assert table.rows == [["jump", comparison.NONE, "4", "95.0%", "40.0%", "95.0%"]]


def test_a_label_is_no_mathematics(tmp_path):
    plot = draw(PAPER.figures[0], [_group(r"a $\{x$", **{PAPER.figures[0].tags[0]: [1.0]})], {})
    assert all(path.is_file() for path in save(plot, tmp_path, "a"))

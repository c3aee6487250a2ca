"""Reports join continued runs, average over seeds, and set our numbers beside the study's."""

import json
import re

import numpy as np
import pytest
from scipy import stats
from scipy.stats import binomtest
from torch.utils.tensorboard import SummaryWriter

from lift_lab.utils.errors import ConfigError, FileError
from lift_lab.utils.io import dump_yaml
from lift_lab_rl.intervals import t_interval, t_quantile, welch_interval, wilson_interval
from lift_lab_rl.study import comparison
from lift_lab_rl.study.comparison import Roles, verdict
from lift_lab_rl.study.curves import Group, TrainingRun, find_runs, group_runs, remarks, smooth
from lift_lab_rl.study.evaluations import collect, find_results, load_results
from lift_lab_rl.study.figures import draw, save
from lift_lab_rl.study.jobs import (
    Variant,
    best_checkpoint,
    check_settings,
    check_start,
    checkpoint_at,
    in_rounds,
    make_jobs,
    newest_checkpoint,
    read_evaluation,
)
from lift_lab_rl.study.page import write_report
from lift_lab_rl.study.paper import FIGURES, TABLE_1

REWARD = "Reward / Total reward (mean)"
SUCCESS = "Metrics/object_pose/success"


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


# -- intervals


@pytest.mark.parametrize(("wins", "trials"), [(0, 10), (10, 10), (48, 50), (99, 100), (995, 1000)])
def test_wilson_intervals_are_scipys(wins, trials):
    expected = binomtest(wins, trials).proportion_ci(0.95, method="wilson")
    assert wilson_interval(wins, trials) == pytest.approx((expected.low, expected.high), abs=1e-9)


@pytest.mark.parametrize(("dof", "expected"), [(1, 12.706), (2, 4.303), (4, 2.776), (9, 2.262), (1e6, 1.960)])
def test_quantiles_of_students_t_are_those_of_the_tables(dof, expected):
    assert t_quantile(0.95, dof) == pytest.approx(expected, abs=5e-4)


def test_intervals_of_means_and_differences_are_scipys():
    first, second = [2.5, 2.85, 3.14], [3.09, 3.33, 3.49, 3.6]
    low, high = stats.t.interval(0.95, 2, loc=np.mean(first), scale=stats.sem(first))
    assert t_interval(first) == pytest.approx((low, high), rel=1e-6)
    welch = stats.ttest_ind(second, first, equal_var=False).confidence_interval(0.95)
    assert welch_interval(first, second) == pytest.approx((welch.low, welch.high), rel=1e-6)
    assert t_interval([3.0]) is welch_interval([1.0], [3.0, 3.0]) is None
    assert t_interval([3.0, 3.0]) == (3.0, 3.0)
    assert welch_interval([1.0, 1.0], [3.0, 3.0]) == (2.0, 2.0)


def test_an_interval_over_three_seeds_holds_the_mean_as_often_as_it_says():
    draws = np.random.default_rng(1).normal(5.0, 2.0, (1000, 3))
    ends = np.array([t_interval(list(values)) for values in draws])
    # the binomial's deviation is 0.7 points
    assert np.mean((ends[:, 0] < 5.0) & (ends[:, 1] > 5.0)) == pytest.approx(0.95, abs=0.021)


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
    ends = {figure.number: figure for figure in FIGURES}
    for side, total in (("baseline", 134.98), ("curriculum", 142.87)):
        rates = [getattr(ends[number], side) for number in range(7, 13)]
        assert sum(rates) * 5.0 == pytest.approx(total, rel=0.01)
    assert sorted(ends) == list(range(4, 23))
    assert [row.curriculum / row.episodes for row in TABLE_1] == [1.0, 1.0, 0.99]


@pytest.mark.parametrize(
    ("sign", "difference", "ends", "expected"),
    [
        (1, 2.0, (1.0, 3.0), "as the study"),
        (-1, 2.0, (1.0, 3.0), "opposite"),
        (1, 2.0, (-1.0, 5.0), "undecided"),
        (-1, -2.0, None, "as the study (too few seeds for an interval)"),
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
    assert Roles.guess(groups) == Roles("plain", "linear")
    others = [_group("a", "Cartpole"), _group("b"), _group("a-CL", "Reach-Franka")]
    assert Roles.guess(others) == Roles()
    assert Roles.guess(others, curriculum="b") == Roles(None, "b")
    with pytest.raises(ConfigError, match="'b' cannot be both"):
        Roles.guess(others, "b", "b")
    with pytest.raises(ConfigError, match="no runs are labelled 'plan': did you mean 'plain'"):
        Roles.guess(groups, "plan")


def _evaluation(wins, trials, change):
    return {
        "episodes": trials,
        "success": {"10": min(wins, 10) / 10, str(trials): wins / trials},
        "reward_mean": 140.0,
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
    table = comparison.success_table(RESULTS, ["base", "base-CL"], Roles("base", "base-CL"))
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
    table = comparison.claims_table(groups, RESULTS, Roles("base", "base-CL"))
    rows = {row[0]: row for row in table.rows}
    assert rows["higher mean total reward"][2:4] == ["131.00", "142.00"]
    welch = stats.ttest_ind([140.0, 144.0], [130.0, 132.0], equal_var=False).confidence_interval(0.95)
    ends = f"[{comparison.number(welch.low)}, {comparison.number(welch.high)}]"
    assert rows["higher mean total reward"][4:] == [f"11.00 {ends}", "undecided"]
    # equal spreads: two degrees of freedom, standard error sqrt(0.5), 4.30265 * 0.70711 = 3.04244
    assert rows["smoother actions"][4:] == ["-4.000 [-7.042, -0.9576]", "as the study"]


def test_claims_are_paired_by_seed_where_one_side_began_from_the_other():
    curriculum = _group("cl", seeds=(1, 2, 3), **{REWARD: (3.09, 3.33, 3.49)})
    baseline = _group("base", seeds=(1, 2, 3), start=curriculum, **{REWARD: (2.50, 2.85, 3.14)})
    table = comparison.claims_table([curriculum, baseline], {}, Roles("base", "cl"))
    ends = stats.ttest_rel([3.09, 3.33, 3.49], [2.50, 2.85, 3.14]).confidence_interval(0.95)
    (row,) = table.rows
    assert row[4:] == [f"0.4733 [{ends.low:.4f}, {ends.high:.4f}]", "as the study"]
    baseline.runs[0].start = None  # one began anew
    (row,) = comparison.claims_table([curriculum, baseline], {}, Roles("base", "cl")).rows
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
    rows = comparison.success_table(results, [group.label for group in groups], Roles()).rows
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
        (b'{"runs": [{"label": "a", "seed": 1, "evaluation": {"x": 1}}]}', "an evaluation of 'a' has no 'success'"),
        (b"\xff\x00", "it is not JSON"),
        (b"{", "it is not JSON"),
    ],
)
def test_a_file_of_other_content_is_no_results_file(tmp_path, content, message):
    (tmp_path / "r.json").write_bytes(content)
    with pytest.raises(FileError, match=message) as caught:
        load_results(tmp_path / "r.json")
    assert "r.json'" in str(caught.value)


# -- pages and curriculum jumps


def test_a_jump_of_a_penalty_is_found_with_the_success_around_it(tmp_path):
    tags = {"Curriculum/action_rate": [-1e-4] * 3 + [-0.1] * 3, SUCCESS: [0.8, 0.9, 1.0, 0.4, 0.7, 0.95]}
    tags["Curriculum/gripper_hold"] = [0.0, 0.1, 0.1, 0.0, 0.0, 0.0]  # no penalty, and earlier
    _write(tmp_path / "jump", tags)
    _write(tmp_path / "ramp", {"Curriculum/action_rate": [-0.1, -0.2, -0.3, -0.4], SUCCESS: [1.0] * 4})
    groups = group_runs(find_runs([tmp_path / "jump", tmp_path / "ramp"]))
    table = comparison.jump_table(groups, window=2)
    assert table.rows == [["jump", comparison.NONE, "4", "95.0%", "40.0%", "95.0%"]]


def test_the_page_needs_nothing_beside_it_and_every_figure_is_a_file(tmp_path):
    tags = {figure.tags[0]: [0.1, 0.2, 0.3] for figure in FIGURES}
    places = []
    for label in ("base", "base-CL"):
        _write(tmp_path / label, tags)
        places.append(f"{label}={tmp_path / label}")
    groups = group_runs(find_runs(places))
    page = write_report(groups, RESULTS, Roles("base", "base-CL"), tmp_path / "out", notes=["one is missing"])
    text = page.read_text()
    assert text.count("data:image/png;base64,") == len(FIGURES)
    assert not re.search(r"(src|href)=\"(?!data:)", text)
    for title in (
        "Note: one is missing",
        "Table 1",
        "The study&#x27;s claims",
        "Generalisation",
        "Fig. 22. Total Reward",
    ):
        assert title in text
    files = sorted((tmp_path / "out" / "figures").iterdir())
    assert {path.suffix for path in files} == {".png", ".pdf"}
    assert len(files) == 2 * len(FIGURES)


def test_a_label_is_no_mathematics(tmp_path):
    plot = draw(FIGURES[0], [_group(r"a $\{x$", **{FIGURES[0].tags[0]: [1.0]})], {})
    assert all(path.is_file() for path in save(plot, tmp_path, "a"))


# -- jobs


def test_a_variant_is_a_task_with_a_label_and_overrides():
    assert Variant.parse("Lift-Cube-Franka") == Variant("Lift-Cube-Franka", "Lift-Cube-Franka")
    parsed = Variant.parse("linear=Lift-Cube-Franka-CL env/curriculum=linear 'env.x=[1, 2]'")
    assert parsed == Variant("linear", "Lift-Cube-Franka-CL", ("env/curriculum=linear", "env.x=[1, 2]"))
    for wrong in ("", "a/b=Task", "label="):
        with pytest.raises(ConfigError, match="expected TASK"):
            Variant.parse(wrong)
    with pytest.raises(ConfigError, match="no closing quotation"):
        Variant.parse("a=Cartpole 'x")


def test_a_variant_may_start_from_anothers_checkpoint():
    parsed = Variant.parse("base=Lift-Cube-Franka env.x=1 from=Lift-Cube-Franka-CL@750")
    assert parsed == Variant("base", "Lift-Cube-Franka", ("env.x=1",), ("Lift-Cube-Franka-CL", 750))
    assert parsed.settings == ["Lift-Cube-Franka", "from=Lift-Cube-Franka-CL@750", "env.x=1"]
    for wrong in ("T from=x", "T from=@5", "T from=x@y", "T from=x@1 from=x@2"):
        with pytest.raises(ConfigError, match="expected one from=LABEL@ITERATION"):
            Variant.parse(wrong)


def test_what_starts_from_another_comes_in_a_later_round():
    def rounds(*variants, trained=()):
        return [[job.name for job in now] for now in in_rounds(make_jobs(variants, [1, 2]), trained)]

    a, b, c = Variant("a", "T"), Variant("b", "T", start=("a", 5)), Variant("c", "T", start=("b", 7))
    assert rounds(c, b, a) == [["a-s1", "a-s2"], ["b-s1", "b-s2"], ["c-s1", "c-s2"]]
    assert rounds(b, trained=["a"]) == [["b-s1", "b-s2"]]
    assert rounds(b, a, trained=["a"]) == [["a-s1", "a-s2"], ["b-s1", "b-s2"]]  # of other seeds
    with pytest.raises(ConfigError, match="'x' cannot start from 'aa': did you mean 'a'"):
        rounds(a, Variant("x", "T", start=("aa", 1)))
    with pytest.raises(ConfigError, match="circle"):
        rounds(Variant("x", "T", start=("y", 1)), Variant("y", "T", start=("x", 1)))


def test_the_checkpoint_of_an_iteration_is_that_of_the_newest_piece(tmp_path):
    for folder in ("2026-01-01_00-00-00_x-s1", "2026-01-02_00-00-00_x-s1", "2026-01-03_00-00-00_y-s1"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "model_50.pt").touch()
    (tmp_path / "2026-01-01_00-00-00_x-s1" / "model_100.pt").touch()
    assert checkpoint_at(tmp_path, "x-s1", 50).parent.name == "2026-01-02_00-00-00_x-s1"
    assert checkpoint_at(tmp_path, "x-s1", 100).parent.name == "2026-01-01_00-00-00_x-s1"
    with pytest.raises(FileError, match="no checkpoint of iteration 75; it has 50, 100"):
        checkpoint_at(tmp_path, "x-s1", 75)
    with pytest.raises(FileError, match="it has none"):
        checkpoint_at(tmp_path, "z-s1", 50)


def test_jobs_go_seed_by_seed_and_names_are_used_once():
    a, b = Variant("a", "T"), Variant("b", "T")
    assert [job.name for job in make_jobs([a, b], [1, 2])] == ["a-s1", "b-s1", "a-s2", "b-s2"]
    with pytest.raises(ConfigError, match="label 'a' is given twice"):
        make_jobs([a, a], [1])


def test_the_newest_checkpoint_is_the_one_with_most_iterations(tmp_path):
    assert newest_checkpoint(tmp_path / "none", "x-s1") is None
    for folder, names in (
        ("2026-01-01_00-00-00_x-s1", ["model_50.pt", "model_9.pt", "model_best.pt"]),
        ("2026-01-02_00-00-00_x-s1-2", ["model_100.pt"]),
        ("2026-01-03_00-00-00_x-s11", ["model_900.pt"]),
    ):
        (tmp_path / folder).mkdir()
        for name in names:
            (tmp_path / folder / name).touch()
    path, iterations = newest_checkpoint(tmp_path, "x-s1")
    assert (path.parent.name, iterations) == ("2026-01-02_00-00-00_x-s1-2", 100)


def test_the_best_checkpoint_may_be_in_an_earlier_piece(tmp_path):
    for folder, name in (("2026-01-01_00-00-00_x-s1", "model_best.pt"), ("2026-01-02_00-00-00_x-s1", "model_9.pt")):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / name).touch()
    assert best_checkpoint(tmp_path, "x-s1") == tmp_path / "2026-01-01_00-00-00_x-s1" / "model_best.pt"
    assert best_checkpoint(tmp_path, "y-s1") is None


@pytest.mark.parametrize(
    ("start", "message"),
    [(40, "saves every 50 iterations up to 90"), (0, "saves every"), (100, "trained to 100 only"), (95, "saves every")],
)
def test_a_start_that_will_not_be_saved_is_refused(start, message):
    for saved in (50, 90):  # the last iteration is saved, too
        check_start(Variant("b", "T", start=("a", saved)), 100, 50, 90)
    with pytest.raises(ConfigError, match=message):
        check_start(Variant("b", "T", start=("a", start)), 100, 50, 90)


def test_an_evaluation_that_was_cut_off_is_not_done(tmp_path):
    path, done = tmp_path / "e.json", {"checkpoint": "c", "episodes": 4, "seed": 1}
    path.write_text(json.dumps(done))
    assert read_evaluation(path, "c", 4, 1) == done
    for text in ('{"checkpoint": "c", "epi', "[]", "{}"):
        path.write_text(text)
        assert read_evaluation(path, "c", 4, 1) is None


def test_a_study_of_other_settings_is_refused(tmp_path):
    old = {"variants": {"a": ["T"]}, "num_envs": 8}
    check_settings(old, {"variants": {"b": ["U"]}, "num_envs": 8}, tmp_path)
    check_settings({}, {"variants": {}, "num_envs": 9}, tmp_path)
    with pytest.raises(ConfigError, match="num_envs 8, not 9"):
        check_settings(old, {"variants": {}, "num_envs": 9}, tmp_path)
    with pytest.raises(ConfigError, match="other settings for 'a'"):
        check_settings(old, {"variants": {"a": ["U"]}, "num_envs": 8}, tmp_path)

"""Reports join continued runs, average over seeds, and set our numbers beside the study's."""

import re

import numpy as np
import pytest
from scipy.stats import binomtest
from torch.utils.tensorboard import SummaryWriter

from lift_lab.utils.errors import ConfigError, FileError
from lift_lab.utils.io import dump_yaml
from lift_lab_rl.intervals import bootstrap_difference, bootstrap_interval, wilson_interval
from lift_lab_rl.study import comparison
from lift_lab_rl.study.comparison import Roles, verdict
from lift_lab_rl.study.curves import find_runs, group_runs, smooth
from lift_lab_rl.study.jobs import Variant, check_settings, checkpoint_at, in_rounds, make_jobs, newest_checkpoint
from lift_lab_rl.study.page import write_report
from lift_lab_rl.study.paper import FIGURES, TABLE_1

REWARD = "Reward / Total reward (mean)"
SUCCESS = "Metrics/object_pose/success"


def _write(folder, tags, first=1, seed=None, run_name="", task=None):
    """A run's folder: tag -> values from iteration ``first`` on."""
    writer = SummaryWriter(str(folder))
    for tag, values in tags.items():
        for k, value in enumerate(values):
            writer.add_scalar(tag, value, first + k)
    writer.close()
    if seed is not None:
        dump_yaml(folder / "params" / "agent.yaml", {"seed": seed, "run_name": run_name})
    if task is not None:
        dump_yaml(folder / "params" / "run.yaml", {"task": task})


# -- intervals


@pytest.mark.parametrize(("wins", "trials"), [(0, 10), (10, 10), (48, 50), (99, 100), (995, 1000)])
def test_wilson_intervals_are_scipys(wins, trials):
    expected = binomtest(wins, trials).proportion_ci(0.95, method="wilson")
    assert wilson_interval(wins, trials) == pytest.approx((expected.low, expected.high), abs=1e-9)


def test_the_bootstrap_of_two_values_spans_them_and_of_one_says_nothing():
    # The resampled mean of 0 and 1 is 0, 1/2 or 1 with probability 1/4, 1/2, 1/4.
    assert bootstrap_interval([0.0, 1.0]) == (0.0, 1.0)
    assert bootstrap_interval([0.0, 1.0], confidence=0.4) == (0.5, 0.5)
    assert bootstrap_interval([3.0]) is None
    assert bootstrap_difference([1.0, 1.0], [3.0, 3.0]) == (2.0, 2.0)
    assert bootstrap_difference([1.0], [3.0, 3.0]) is None


def test_a_bootstrap_interval_of_many_values_is_the_normal_one():
    values = np.random.default_rng(1).normal(5.0, 2.0, 400)
    half = 1.96 * values.std() / 20.0
    assert bootstrap_interval(values) == pytest.approx((values.mean() - half, values.mean() + half), abs=0.02)


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


def test_roles_are_guessed_from_labels():
    assert Roles.guess(["Lift-Cube-Franka-CL", "Lift-Cube-Franka"]) == Roles("Lift-Cube-Franka", "Lift-Cube-Franka-CL")
    assert Roles.guess(["a", "b"], curriculum="a") == Roles("b", "a")


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
    assert rows["higher mean total reward"][2:] == ["131.00", "142.00", "11.00 [8.000, 14.00]", "as the study"]
    assert rows["smoother actions"][4:] == ["-4.000 [-5.000, -3.000]", "as the study"]
    # 0.96, 0.98 against 1.00, 0.99: from 0.99 - 0.98 to 1.00 - 0.96
    assert rows["higher success rate"][4] == "0.0250 [0.0100, 0.0400]"


def test_a_jump_of_a_penalty_is_found_with_the_success_around_it(tmp_path):
    tags = {"Curriculum/action_rate": [-1e-4] * 3 + [-0.1] * 3, SUCCESS: [0.8, 0.9, 1.0, 0.4, 0.7, 0.95]}
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
    page = write_report(groups, RESULTS, Roles("base", "base-CL"), tmp_path / "out")
    text = page.read_text()
    assert text.count("data:image/png;base64,") == len(FIGURES)
    assert not re.search(r"(src|href)=\"(?!data:)", text)
    for title in ("Table 1", "The study&#x27;s claims", "Generalisation", "Fig. 22. Total Reward"):
        assert title in text
    files = sorted((tmp_path / "out" / "figures").iterdir())
    assert {path.suffix for path in files} == {".png", ".pdf"}
    assert len(files) == 2 * len(FIGURES)


# -- jobs


def test_a_variant_is_a_task_with_a_label_and_overrides():
    assert Variant.parse("Lift-Cube-Franka") == Variant("Lift-Cube-Franka", "Lift-Cube-Franka")
    parsed = Variant.parse("linear=Lift-Cube-Franka-CL env/curriculum=linear 'env.x=[1, 2]'")
    assert parsed == Variant("linear", "Lift-Cube-Franka-CL", ("env/curriculum=linear", "env.x=[1, 2]"))
    for wrong in ("", "a/b=Task", "label="):
        with pytest.raises(ConfigError, match="expected TASK"):
            Variant.parse(wrong)


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


def test_a_study_of_other_settings_is_refused(tmp_path):
    old = {"variants": {"a": ["T"]}, "num_envs": 8}
    check_settings(old, {"variants": {"b": ["U"]}, "num_envs": 8}, tmp_path)
    check_settings({}, {"variants": {}, "num_envs": 9}, tmp_path)
    with pytest.raises(ConfigError, match="num_envs 8, not 9"):
        check_settings(old, {"variants": {}, "num_envs": 9}, tmp_path)
    with pytest.raises(ConfigError, match="other settings for 'a'"):
        check_settings(old, {"variants": {"a": ["U"]}, "num_envs": 8}, tmp_path)

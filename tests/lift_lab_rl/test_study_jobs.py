"""The jobs of a study: which variants it trains, in which order, and from which checkpoints they go on."""

import json

import pytest

from lift_lab.utils.errors import ConfigError, FileError
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

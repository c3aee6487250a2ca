"""Every number of the configuration classes has a declared range, and validate() names what lies outside of it."""

import dataclasses
import importlib
import math
import pkgutil
import typing
from typing import Annotated, ClassVar

import numpy as np
import pytest
import torch

import lift_lab
import lift_lab_rl
import lift_lab_tasks
from lift_lab.envs import mdp
from lift_lab.managers import ManagerTermBase, RewardTermCfg
from lift_lab.sim import SimulationCfg
from lift_lab.utils import configclass
from lift_lab.utils.config_update import field_hints
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.ranges import (
    COUNT,
    FINITE,
    FRACTION,
    POSITIVE,
    POSITIVE_OR_INF,
    SEED,
    SIZES,
    SPAN,
    Ranges,
    may_be_none,
    param_ranges,
    ranges_of,
)


def config_classes():
    """All configuration classes of the packages, those inside of others included."""
    found = {}

    def take(value):
        ours = isinstance(value, type) and value.__module__.startswith("lift_lab")
        if not ours or value in found or not dataclasses.is_dataclass(value) or not hasattr(value, "validate"):
            return
        found[value] = None
        for inner in vars(value).values():
            take(inner)

    for package in (lift_lab, lift_lab_rl, lift_lab_tasks):
        for info in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            try:
                module = importlib.import_module(info.name)
            except ImportError:  # of an extra that is not installed
                continue
            for value in list(vars(module).values()):
                take(value)
    return list(found)


def holds_numbers(hint):
    if hint in (int, float, np.ndarray, torch.Tensor):
        return True
    return typing.get_origin(hint) not in (typing.Literal, type) and any(map(holds_numbers, typing.get_args(hint)))


def test_every_number_of_every_configuration_class_has_a_declared_range():
    classes = config_classes()
    assert len(classes) > 150
    numbers = missing = 0
    for cls in classes:
        hints = field_hints(cls)
        for field in dataclasses.fields(cls):
            if "Callable" in str(field.type) or not holds_numbers(hints.get(field.name)):
                continue
            numbers += 1
            if field.name not in ranges_of(cls):
                missing += 1
                print(f"{cls.__module__}.{cls.__qualname__}.{field.name}: {field.type}")
    assert numbers > 500
    assert missing == 0, "declare the ranges of the fields that are printed"


def test_every_declared_range_is_of_a_field():
    for cls in config_classes():
        assert set(ranges_of(cls)) <= {field.name for field in dataclasses.fields(cls)}, cls


def test_the_defaults_of_every_class_are_within_their_ranges():
    for cls in config_classes():
        for field in dataclasses.fields(cls):
            default = field.default if field.default is not dataclasses.MISSING else None
            known = ranges_of(cls).get(field.name)
            if known is not None and default is not None:
                assert known.problem(field.name, default) is None


@pytest.mark.parametrize(
    ("known", "good", "bad", "text"),
    [
        (POSITIVE, [1e-9, 3, np.float32(2)], [0, -1.0, math.inf, math.nan], "finite and above 0"),
        (POSITIVE_OR_INF, [1, math.inf], [0.0, -math.inf, math.nan], "above 0"),
        (COUNT, [1, np.int64(7)], [0, -3], "at least 1"),
        (FRACTION, [0, 0.5, 1], [-0.1, 1.1, math.nan], "at least 0 and at most 1"),
        (FINITE, [-1e30, 0], [math.inf, -math.inf, math.nan], "finite"),
        (SEED, [-1, 0, 2**32 - 1], [-2, 2**32], "at least 0 and at most 4294967295, or -1"),
    ],
)
def test_a_range_takes_what_it_says(known, good, bad, text):
    assert str(known) == text
    assert [known.problem("x", value) for value in good] == [None] * len(good)
    for value in bad:
        assert known.problem("x", value) == f"x is {value}; it must be {text}".replace(".0;", ";")


@pytest.mark.parametrize("value", [2.5, 4.0, np.float32(4)])
def test_a_count_is_whole(value):
    assert COUNT.problem("x", value) == f"x is {float(value)}; it must be a whole number, at least 1"


def test_entries_of_lists_dictionaries_and_tensors_are_named():
    assert SIZES.problem("dims", [8, 0]) == "dims[1] is 0; it must be at least 1"
    assert SIZES.problem("dims", []) == "dims is empty; it needs at least 1 entry"
    assert FINITE.problem("gains", {"arm": 1.0, "hand": math.nan}) == "gains.hand is nan; it must be finite"
    assert FINITE.problem("bias", torch.tensor([0.0, math.inf])) == "bias[1] is inf; it must be finite"
    assert SPAN.problem("x", (2.0, 1.0)) == "x is (2, 1); the first number must not be above the second"
    assert SPAN.problem("x", (1.0, 1.0)) is None
    assert SPAN.problem("x", [1.0]) == "x has 1 numbers; it needs two, (low, high)"
    assert SPAN.problem("pose", {"x": (0, 1), "yaw": (1, 0)}) is not None
    assert POSITIVE.problem("x", "fast") == "x is 'fast'; it must be finite and above 0"
    assert COUNT.problem("x", True) == "x is True; it must be at least 1"


def term(env, std: Annotated[float, POSITIVE], limit: "Annotated[float, FRACTION]" = 0.5, other: float = 1.0):
    return std


class Term(ManagerTermBase):
    def __call__(self, env, std: Annotated[float, POSITIVE]):
        return std


@pytest.mark.parametrize("func", [term, Term])
def test_arguments_of_terms_have_the_ranges_of_their_annotations(func):
    cfg = RewardTermCfg(func=func, weight=1.0, params={"std": 0.0})
    with pytest.raises(ConfigError, match=r"^env.rewards.near.params.std is 0; it must be finite and above 0$"):
        cfg.validate("env.rewards.near")
    cfg.params["std"] = 0.1
    cfg.validate()


def test_text_annotations_are_read():
    assert param_ranges(term) == {"std": POSITIVE, "limit": FRACTION}
    assert param_ranges(mdp.reset_joints_by_offset)["position_range"] is SPAN


@configclass
class PartCfg:
    size: float = 1.0
    _ranges: ClassVar[Ranges] = {"size": POSITIVE}


@configclass
class WholeCfg(PartCfg):
    count: int | None = None
    part: PartCfg = PartCfg()
    params: dict = {"std": 1.0}
    _ranges: ClassVar[Ranges] = {"count": COUNT}


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("size", -1.0, "whole.size is -1; it must be finite and above 0"),
        ("size", None, "whole.size is null; it must be finite and above 0"),
        ("count", 0, "whole.count is 0; it must be at least 1, or null"),
        ("part.size", math.nan, "whole.part.size is nan; it must be finite and above 0"),
        ("params.std", math.nan, "whole.params.std is nan; it must be a number"),
    ],
)
def test_validate_names_the_path_and_the_range(path, value, message):
    cfg = WholeCfg()
    assert cfg.validate("whole") == []
    cfg.from_dict({path.split(".")[0]: value} if "." not in path else {})
    if path.startswith("part."):
        cfg.part.size = value
    elif path.startswith("params."):
        cfg.params["std"] = value
    with pytest.raises(ConfigError) as caught:
        cfg.validate("whole")
    assert str(caught.value) == message


def test_which_fields_may_be_none():
    assert not may_be_none(SimulationCfg, "dt")
    assert not may_be_none(SimulationCfg, "mujoco")
    assert may_be_none(SimulationCfg, "num_threads")
    assert may_be_none(WholeCfg, "part")  # an asset or a term of a task
    assert not may_be_none(RewardTermCfg, "weight")


def test_ranges_are_no_field_of_the_configuration():
    assert "_ranges" not in WholeCfg().to_dict()
    assert WholeCfg().copy().to_dict() == WholeCfg().to_dict()

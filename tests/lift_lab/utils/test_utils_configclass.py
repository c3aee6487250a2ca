"""The ``@configclass`` decorator: which names are fields, what inherits, what is checked and written."""

from __future__ import annotations

import abc
import dataclasses
import functools
from collections.abc import Callable
from dataclasses import MISSING, field
from typing import ClassVar, Literal

import pytest
import torch
from example_configs import EnvCfg, ViewerCfg

from lift_lab.utils import configclass
from lift_lab.utils.errors import LiftLabError


def reward(env) -> float:
    return 1.0


def other_reward(env) -> float:
    return 2.0


class Actuator:
    pass


def names(cls) -> list[str]:
    return [f.name for f in dataclasses.fields(cls)]


def test_annotated_and_unannotated_fields_keep_the_order_of_the_class_body():
    @configclass
    class Cfg:
        zeta = 1
        alpha: int = 2
        mid = [3]
        beta: float = MISSING
        omega = "x"

    assert names(Cfg) == ["zeta", "alpha", "mid", "beta", "omega"]
    assert list(vars(Cfg())) == names(Cfg)
    assert list(Cfg().to_dict()) == names(Cfg)


def test_an_overridden_field_keeps_the_place_of_its_base_and_new_ones_follow():
    @configclass
    class Base:
        a = 1
        b: int = 2
        c = 3

    @configclass
    class Child(Base):
        d = 4
        b = 20

    assert names(Child) == ["a", "b", "c", "d"]
    assert Child().b == 20
    assert Base().b == 2


def test_an_unannotated_field_is_typed_from_its_value():
    @configclass
    class Cfg:
        number = 1
        values = (1.0, 2.0)
        func = reward
        class_type = Actuator

    types = {f.name: f.type for f in dataclasses.fields(Cfg)}
    assert types["number"] is int
    assert types["values"] is tuple
    assert types["func"] is type(reward)
    assert types["class_type"] == type[Actuator]


def test_an_unannotated_override_keeps_the_declared_type():
    @configclass
    class Base:
        weight: float = MISSING

    @configclass
    class Child(Base):
        weight = 5

    cfg = Child()
    cfg.from_dict({"weight": 0.5})
    assert cfg.weight == 0.5


def test_functions_from_elsewhere_are_fields_and_functions_of_the_body_are_methods():
    @configclass
    class Cfg:
        func = reward
        scale = lambda x: 2 * x  # noqa: E731
        annotated: Callable = other_reward

        def method(self):
            return self.func

        @staticmethod
        def static():
            return 1

        @classmethod
        def make(cls):
            return cls()

        @property
        def twice(self):
            return self.scale(2)

        @functools.cached_property
        def once(self):
            return 3

    assert names(Cfg) == ["func", "scale", "annotated"]
    cfg = Cfg.make()
    assert cfg.func(None) == 1.0
    assert cfg.scale(4) == 8
    assert cfg.method() is reward
    assert (cfg.static(), cfg.twice, cfg.once) == (1, 4, 3)


def test_nested_classes_are_not_fields_but_an_assigned_class_is():
    @configclass
    class Cfg:
        @configclass
        class InitialStateCfg:
            pos: tuple[float, float, float] = (0.0, 0.0, 0.0)

        class_type = Actuator
        other: type = Actuator
        init_state: InitialStateCfg = InitialStateCfg()

    assert names(Cfg) == ["class_type", "other", "init_state"]
    assert Cfg().class_type is Actuator
    assert Cfg.InitialStateCfg().pos == (0.0, 0.0, 0.0)


def test_class_variables_are_not_fields():
    @configclass
    class Cfg:
        registry: ClassVar[dict] = {}
        value = 1

    assert names(Cfg) == ["value"]
    assert Cfg.registry is Cfg().registry


def test_a_dataclass_field_default_works_annotated_or_not():
    @configclass
    class Cfg:
        a: list = field(default_factory=lambda: [1])
        b = field(default_factory=dict)
        c: int = field(default=3)
        d: list = field(default_factory=list, repr=False)

    assert (Cfg().a, Cfg().b, Cfg().c) == ([1], {}, 3)
    assert Cfg().a is not Cfg().a
    assert "d=" not in repr(Cfg())


def test_post_init_may_always_be_called_through_super():
    calls = []

    class Mixin:
        def __post_init__(self):
            calls.append("mixin")

    @configclass
    class Base:
        a = 1

    @configclass
    class Child(Base, Mixin):
        def __post_init__(self):
            super().__post_init__()
            calls.append("child")

    Child()
    assert calls == ["mixin", "child"]


def test_fields_of_undecorated_bases_are_fields():
    class Plain:
        extra = [1]

    @configclass
    class Cfg(EnvCfg, Plain, abc.ABC):
        mine = 2

    assert names(Cfg) == ["num_envs", "decimation", "viewer", "params", "extra", "mine"]
    Cfg().extra.append(2)
    assert Cfg().extra == [1]


def test_in_a_diamond_the_first_base_that_declares_a_field_gives_its_default():
    @configclass
    class Base:
        a: int = 1
        b = [1]

    @configclass
    class Left(Base):
        c = 3

    @configclass
    class Right(Base):
        a = 2
        b = [2]

    @configclass
    class Both(Left, Right):
        pass

    assert (Both().a, Both().b, Both().c) == (2, [2], 3)


def test_a_narrowed_annotation_keeps_the_inherited_default():
    @configclass
    class Child(EnvCfg):
        viewer: ViewerCfg | None
        num_envs: int | None

    assert Child().viewer == ViewerCfg()
    assert Child().num_envs is MISSING


def test_missing_without_annotation_is_a_type_error():
    with pytest.raises(TypeError, match=r"value is MISSING and has no annotation"):

        @configclass
        class Cfg:
            value = MISSING


def test_an_annotation_without_default_is_a_value_error():
    with pytest.raises(ValueError, match=r"value has an annotation but no default; write 'value: \.\.\. = MISSING'"):

        @configclass
        class Cfg:
            value: int


def test_a_field_named_as_a_config_method_is_refused():
    with pytest.raises(ValueError, match=r"'copy' cannot be a field"):

        @configclass
        class Cfg:
            copy: int = 1


def test_init_takes_fields_by_position_and_name_and_names_the_nearest_to_a_wrong_one():
    assert EnvCfg(4, decimation=3).decimation == 3
    with pytest.raises(TypeError, match=r"EnvCfg has no field 'decimaton'; did you mean 'decimation'\?"):
        EnvCfg(decimaton=3)


def test_any_attribute_may_be_set_on_an_instance_and_to_any_type():
    cfg = EnvCfg()
    cfg.viewer = None
    cfg.num_envs = "many"
    cfg.not_a_field = 1
    assert cfg.copy().not_a_field == 1
    assert cfg.to_dict()["not_a_field"] == 1


def test_equality_and_repr_are_those_of_a_dataclass():
    assert EnvCfg(2) == EnvCfg(2)
    assert EnvCfg(2) != EnvCfg(3)
    assert repr(ViewerCfg()) == "ViewerCfg(eye=[7.5, 7.5, 7.5], resolution=(640, 480))"


def test_validate_lists_every_missing_path():
    @configclass
    class Inner:
        value: int = MISSING
        ok = 1

    @configclass
    class Outer:
        first: int = MISSING
        inner: Inner = Inner()
        table = {"a": {"b": MISSING, 3: MISSING}, "c": Inner()}
        pair: tuple = (1, MISSING)
        entries: list = [Inner(), 2]
        func = reward
        class_type = Actuator

    with pytest.raises(TypeError) as error:
        Outer().validate()
    lines = str(error.value).splitlines()
    assert lines[0] == "Outer has no value for:"
    assert [line.strip("- ") for line in lines[1:]] == [
        "first",
        "inner.value",
        "table.a.b",
        "table.a.3",
        "table.c.value",
        "pair[1]",
        "entries[0].value",
    ]
    assert isinstance(error.value, LiftLabError)
    assert ViewerCfg().validate() == []


def test_to_dict_names_callables_and_keeps_values():
    @configclass
    class Cfg:
        func = reward
        class_type = Actuator
        in_dict = {"f": reward, "values": (1, 2)}
        scale = lambda x: x + 1  # noqa: E731
        tensor = torch.ones(2)
        part = slice(None)
        unset: int = MISSING
        viewer = ViewerCfg()
        viewers = [ViewerCfg()]

    data = Cfg().to_dict()
    assert data["func"] == f"{__name__}:reward"
    assert data["class_type"] == f"{__name__}:Actuator"
    assert data["in_dict"] == {"f": f"{__name__}:reward", "values": (1, 2)}
    assert data["scale"] == "lambda x: x + 1"
    assert torch.equal(data["tensor"], torch.ones(2))
    assert data["part"] == slice(None)
    assert data["unset"] == "???"
    assert data["viewer"] == {"eye": [7.5, 7.5, 7.5], "resolution": (640, 480)}
    assert data["viewers"] == [data["viewer"]]


def test_from_dict_undoes_to_dict():
    @configclass
    class Cfg:
        func: Callable = reward
        unset: int = MISSING
        viewer: ViewerCfg = ViewerCfg()
        optional: ViewerCfg | None = None
        mode: Literal["a", "b"] = "a"

    changed = Cfg(func=other_reward, mode="b", optional=ViewerCfg(eye=[1.0]))
    changed.viewer.resolution = (1, 2)
    cfg = Cfg()
    cfg.from_dict(changed.to_dict())
    assert cfg.func is other_reward
    assert cfg.unset is MISSING
    assert cfg.viewer.resolution == (1, 2)
    assert cfg.mode == "b"


def test_a_class_may_define_its_own_validate():
    @configclass
    class Cfg:
        value: int = MISSING

        def validate(self, prefix=""):
            return []

    @configclass
    class Child(Cfg):
        pass

    assert Child().validate() == []

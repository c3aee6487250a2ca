"""Whatever an object of a task holds is saved and restored as it was, or named as what cannot be saved."""

import enum
import functools
import itertools
import random
from collections import Counter, OrderedDict, defaultdict, deque
from types import SimpleNamespace

import numpy as np
import pytest
import torch

from lift_lab.utils import configclass
from lift_lab.utils.errors import StateMismatchError
from lift_lab.utils.saved_state import Stateful, Stateless
from lift_lab.utils.state_reader import StateReader
from lift_lab.utils.state_writer import StateWriter
from lift_lab_rl.files import load_torch, save_torch


class Thing:
    """Something with attributes."""

    def __init__(self, **attributes):
        vars(self).update(attributes)


def saved(root, tmp_path=None):
    """The state of a root, by way of a file if there is a folder for it."""
    writer = StateWriter()
    node = writer.node(root, "")
    assert writer.unsaved == []
    if tmp_path is None:
        return node
    save_torch(tmp_path / "state.pt", {"node": node})
    return load_torch(tmp_path / "state.pt")["node"]


def restore(root, node):
    reader = StateReader()
    reader.plan(root, node, "")
    reader.apply()
    return root


def moved(make, change, tmp_path):
    """An object that was changed, saved, and restored into a new one; and one restored into itself after more."""
    source = make()
    change(source)
    node = saved(source, tmp_path)
    fresh = restore(make(), node)
    change(source)
    return fresh, restore(source, node)


class Phase(enum.Enum):
    REACH = 1
    LIFT = 2


@pytest.mark.parametrize(
    ("first", "then"),
    [
        (1, 2),
        (0.0, -0.0),
        (1.0, float("nan")),
        (True, None),
        (None, 2.5),
        ("reach", "lift"),
        (b"a", b"\xff\0"),
        (1 + 2j, 3j),
        (1 << 90, 3),
        (Phase.REACH, Phase.LIFT),
        (np.float64(1.5), np.float64(2.5)),
        (None, [1, {"a": (2, "b")}]),
        ([1, 2, 3], []),
        ([], [1, [2.0, None], "x"]),
        ({"a": 1}, {"b": 2, (1, "c"): {3}}),
        ({}, {}),
        ({1, 2}, {2, 3, "x", (4, 5)}),
        (frozenset({1}), frozenset({2})),
        ((1, 2), (1, 2, 3)),
        (slice(1), slice(1)),
    ],
)
def test_values_of_all_kinds_come_back(tmp_path, first, then):
    node = saved(Thing(value=then), tmp_path)
    for before in (first, then):
        found = restore(Thing(value=before), node).value
        assert type(found) is type(then)
        assert found == then if isinstance(then, (set, frozenset)) else repr(found) == repr(then)


def test_containers_keep_their_identity_kind_and_order(tmp_path):
    def make():
        return Thing(
            a=deque([0, 0, 0], maxlen=3),
            b=OrderedDict(x=1, y=2),
            c=Counter("aab"),
            d=defaultdict(list, {"k": [1]}),
            e={"x": torch.zeros(2), "y": torch.zeros(2)},
        )

    def change(thing):
        thing.a.append(len(thing.a) + sum(thing.a))
        thing.b.move_to_end("x")
        thing.c.update("cc")
        thing.d["new"].append(2)
        thing.e["z"] = thing.e.pop("x") + 1.0

    fresh = make()
    holders = dict(vars(fresh))
    source = make()
    change(source)
    restore(fresh, saved(source, tmp_path))
    assert all(vars(fresh)[name] is value for name, value in holders.items())
    assert fresh.a == deque([0, 0, 3])
    assert fresh.a.maxlen == 3
    assert list(fresh.b) == ["y", "x"]
    assert fresh.c == Counter("aabcc")
    assert fresh.d == {"k": [1], "new": [2]}
    assert fresh.d["missing"] == []
    assert list(fresh.e) == ["y", "z"]
    assert fresh.e["z"].tolist() == [1.0, 1.0]


@pytest.mark.parametrize(
    "array",
    [
        np.arange(6, dtype=np.int16).reshape(2, 3),
        np.array(["a", "long"]),
        np.zeros((0, 3)),
        np.array(2.5),
        np.array([(1, 2.0)], dtype=[("a", "i4"), ("b", "f8")]),
        np.array(["2026-01-01"], dtype="datetime64[D]"),
        np.asfortranarray(np.arange(6.0).reshape(2, 3)),
    ],
)
def test_arrays_come_back(tmp_path, array):
    node = saved(Thing(array=array), tmp_path)
    blank = np.zeros_like(array)
    for before in (blank, None, np.zeros(7)):
        found = restore(Thing(array=before), node).array
        assert found.dtype == array.dtype
        assert found.shape == array.shape
        assert (found == array).all()
    assert blank.tolist() == array.tolist()  # in place


@pytest.mark.parametrize(
    "make",
    [
        lambda: np.random.default_rng(3),
        lambda: np.random.Generator(np.random.MT19937(3)),
        lambda: np.random.RandomState(3),
        lambda: random.Random(3),
        lambda: torch.Generator().manual_seed(3),
    ],
)
def test_random_numbers_go_on(tmp_path, make):
    def draw(generator):
        if isinstance(generator, torch.Generator):
            return torch.rand(2, generator=generator).tolist()
        return [generator.random() for _ in range(2)]

    source = Thing(generator=make())
    draw(source.generator)
    node = saved(source, tmp_path)
    expected = draw(source.generator)
    assert draw(restore(source, node).generator) == expected
    assert draw(restore(Thing(generator=make()), node).generator) == expected
    assert draw(restore(Thing(generator=None), node).generator) == expected


def test_tensors_that_share_memory_go_on_sharing_it(tmp_path):
    def make():
        rows = torch.zeros(3, 4)
        return Thing(rows=rows, first=rows[0], column=rows[:, 1], last=torch.zeros(4), again=None)

    source = make()
    source.rows.copy_(torch.arange(12.0).view(3, 4))
    source.last = source.rows[2]  # was a tensor of its own, is a view now
    source.first = source.first.clone()  # was a view, is a tensor of its own now
    source.again = source.column  # one tensor in two places
    node = saved(source, tmp_path)
    for thing in (restore(make(), node), restore(source, node)):
        assert thing.rows.tolist() == [[0, 1, 2, 3], [4, 5, 6, 7], [8, 9, 10, 11]]
        assert thing.again is thing.column
        thing.rows += 100.0
        assert thing.first.tolist() == [0, 1, 2, 3]
        assert thing.column.tolist() == [101, 105, 109]
        assert thing.last.tolist() == [108, 109, 110, 111]


def test_tensors_are_written_in_place_where_others_may_hold_them(tmp_path):
    with torch.inference_mode():
        made_inside = torch.zeros(2)
    expanded = torch.zeros(1).expand(5)
    thing = Thing(
        plain=torch.zeros(3), inside=made_inside, expanded=expanded, scalar=torch.tensor(0), empty=torch.zeros(0)
    )
    other = Thing(
        plain=torch.tensor([1.0, float("nan"), -0.0]),
        inside=torch.ones(2),
        expanded=torch.ones(1).expand(5),
        scalar=torch.tensor(7),
        empty=torch.zeros(0),
    )
    before = dict(vars(thing))
    restore(thing, saved(other, tmp_path))
    assert all(vars(thing)[name] is value for name, value in before.items())
    assert str(thing.plain.tolist()) == "[1.0, nan, -0.0]"
    assert made_inside.tolist() == [1.0, 1.0]
    assert expanded.tolist() == [1.0] * 5
    assert thing.scalar.item() == 7


def test_a_tensor_that_is_right_already_is_not_written(tmp_path):
    thing = Thing(a=torch.ones(3))
    version = thing.a._version
    restore(thing, saved(thing, tmp_path))
    assert thing.a._version == version


@pytest.mark.parametrize("value", [torch.zeros(5), torch.zeros(3, dtype=torch.long), torch.zeros(2, 3).t(), None, 1.5])
def test_a_tensor_that_lies_otherwise_is_replaced(tmp_path, value):
    other = Thing(a=torch.arange(6.0).view(2, 3).t())
    found = restore(Thing(a=value), saved(other, tmp_path)).a
    assert found.tolist() == [[0, 3], [1, 4], [2, 5]]
    assert found.stride() == (1, 3)


def test_attributes_that_come_into_being_late_are_there_after_loading(tmp_path):
    late = Thing(a=1)
    late.buffer = torch.ones(2)
    late.history = deque([torch.ones(1)], maxlen=2)
    fresh = restore(Thing(a=0), saved(late, tmp_path))
    assert fresh.buffer.tolist() == [1.0, 1.0]
    assert fresh.history.maxlen == 2
    with pytest.raises(StateMismatchError, match="'more' is not in it"):
        restore(Thing(a=0, more=1), saved(Thing(a=1)))


def test_a_tensor_on_another_device_than_most_comes_back_to_it():
    node = StateWriter("meta").node(Thing(here=torch.ones(2)), "")
    assert node[3]["here"][:2] == ("on", "cpu")
    reader, fresh = StateReader("meta"), Thing(here=None)
    reader.plan(fresh, node, "")
    reader.apply()
    assert fresh.here.tolist() == [1.0, 1.0]


class Slots:
    __slots__ = ("__private", "value")

    def __init__(self, value):
        self.value = self.__private = value

    def both(self):
        return self.value, self.__private


def test_objects_of_all_kinds_are_looked_into(tmp_path):
    def make(number):
        torch.manual_seed(0)
        net = torch.nn.Sequential(torch.nn.Linear(2, 2), torch.nn.BatchNorm1d(2))
        with torch.no_grad():
            net[0].weight.fill_(number)
        net[1].running_mean.fill_(number)
        return Thing(
            slots=Slots(number),
            space=SimpleNamespace(a=number),
            net=net,
            normal=torch.distributions.Normal(torch.full((2,), float(number)), 1.0),
            parts=[Thing(value=number), Thing(value=number)],
        )

    found = restore(make(1), saved(make(2), tmp_path))
    assert found.slots.both() == (2, 2)
    assert found.space.a == 2
    assert found.net[0].weight.tolist() == [[2.0, 2.0], [2.0, 2.0]]
    assert isinstance(found.net[0].weight, torch.nn.Parameter)
    assert found.net[1].running_mean.tolist() == [2.0, 2.0]
    assert found.normal.loc.tolist() == [2.0, 2.0]
    assert [part.value for part in found.parts] == [2, 2]


def test_an_object_that_saves_itself_does(tmp_path):
    def make():
        torch.manual_seed(0)
        net = torch.nn.Linear(2, 1)
        return Thing(net=net, optimizer=torch.optim.Adam(net.parameters(), lr=0.1))

    def train(thing, steps):
        for _ in range(steps):
            thing.optimizer.zero_grad()
            thing.net(torch.ones(1, 2)).sum().backward()
            thing.optimizer.step()

    source = make()
    train(source, 3)
    node = saved(source, tmp_path)
    train(source, 2)
    fresh = restore(make(), node)
    train(fresh, 2)
    assert torch.equal(fresh.net.weight, source.net.weight)


def test_which_object_is_in_use_comes_back(tmp_path):
    def make():
        parts = [Thing(name="a"), Thing(name="b")]
        return Thing(parts=parts, active=parts[0], table={"x": parts[0]})

    source = make()
    source.active, source.table["x"] = source.parts[1], source.parts[1]
    found = restore(make(), saved(source, tmp_path))
    assert found.active is found.parts[1] is found.table["x"]


class Declares(Thing, Stateful):
    """Says what is no part of its state."""

    unsaved_attributes = frozenset({"cache"})

    def on_state_loaded(self):
        self.cache.clear()


class DeclaresMore(Declares):
    unsaved_attributes = frozenset({"window"})


def test_classes_say_what_is_no_part_of_their_state(tmp_path):
    node = saved(DeclaresMore(a=1, cache={"x": 2}, window=itertools.count(), _cache=torch.ones(1)), tmp_path)
    assert set(node[3]) == {"a", "_cache"}
    found = restore(DeclaresMore(a=0, cache={"y": 3}, window=7, _cache=torch.zeros(1)), node)
    assert (found.a, found.cache, found.window, found._cache.item()) == (1, {}, 7, 1.0)


def test_what_cannot_be_saved_is_named(tmp_path):
    with open(tmp_path / "file", "w") as file:
        thing = Thing(
            count=itertools.count(),
            generator=(k for k in range(3)),
            file=file,
            objects={Thing()},
            array=np.array([object()]),
            sparse=torch.zeros(2, 2).to_sparse(),
            buffer=bytearray(b"x"),
            # these never change:
            dtype=torch.float32,
            path=tmp_path,
            function=len,
            partial=functools.partial(max, 1),
            kind=Thing,
        )
        writer = StateWriter()
        writer.node(thing, "")
    names = [text.split(" ")[0] for text in writer.unsaved]
    assert names == ["count", "generator", "file", "objects", "array", "sparse", "buffer"]
    assert writer.unsaved[0] == "count (itertools.count)"


class Window(Stateless):
    """Something of the process."""


@configclass
class TermCfg:
    """A configuration."""

    a: int = 1


def test_configurations_functions_and_what_is_no_state_are_left_alone(tmp_path):
    def make(number):
        return Thing(a=number, cfg=TermCfg(a=number), window=Window(), func=max, items=[TermCfg(a=number), number])

    fresh = make(1)
    holders = dict(vars(fresh))
    node = saved(make(2), tmp_path)
    assert set(node[3]) == {"a", "items"}
    restore(fresh, node)
    assert all(vars(fresh)[name] is value for name, value in holders.items() if name != "a")
    assert (fresh.a, fresh.cfg.a, fresh.items) == (2, 1, [TermCfg(a=1), 2])
    # a window that the one had and the other has not
    assert vars(restore(Thing(a=0, window=None), saved(Thing(a=1, window=Window())))) == {"a": 1, "window": None}
    opened = Thing(a=0, window=Window())
    assert isinstance(restore(opened, saved(Thing(a=1, window=None))).window, Window)


class Old(Stateful):
    """As an older version of this project had it."""

    def __init__(self, count):
        self._sum, self._times = torch.full((2,), float(count)), count


class New(Stateful):
    """The same, with another name and one attribute more."""

    state_version = 2

    def __init__(self):
        self._total, self._times, self._mean = torch.zeros(2), 0, 0.0

    @classmethod
    def upgrade_state(cls, attributes, version):
        assert version == 1
        attributes["_total"] = attributes.pop("_sum")
        attributes["_mean"] = 0.5
        return attributes


New.__qualname__ = Old.__qualname__  # one class, as two versions of this project have it


def test_a_renamed_attribute_is_read_from_the_state_of_an_older_version(tmp_path):
    new = New()
    restore(new, saved(Old(3), tmp_path))
    assert (new._total.tolist(), new._times, new._mean) == ([3.0, 3.0], 3, 0.5)
    assert not hasattr(new, "_sum")
    with pytest.raises(StateMismatchError, match="'' has the form of version 2, this is version 1"):
        restore(Old(0), saved(new))


def test_an_object_gives_its_state_and_takes_it_back():
    old, other = Old(3), Old(1)
    state = old.state_dict()
    old._sum += 1.0
    assert state["_sum"].tolist() == [3.0, 3.0]
    other.load_state_dict(state)
    assert (other._sum.tolist(), other._times) == ([3.0, 3.0], 3)
    with pytest.raises(StateMismatchError, match="'_times' is not in it"):
        other.load_state_dict({"_sum": torch.zeros(2)})


@pytest.mark.parametrize(
    ("other", "message"),
    [
        (Thing(a=torch.ones(2), z=SimpleNamespace()), "'z' is Thing, it was SimpleNamespace"),
        (Thing(a=torch.ones(2)), "'z' is not in it"),
        (Thing(a=torch.ones(2), z=Thing(), more=Thing()), "'more' is not there, it was Thing"),
        (Thing(a=torch.ones(2), z=[Thing()]), "'z' is of type Thing, it was a sequence"),
        (Thing(a="text", z=Thing()), "'a' is of type Tensor, it was text"),
        (Thing(a=[1.0], z=Thing()), "'a' is of type Tensor, it was a sequence"),
    ],
)
def test_a_state_of_something_else_is_refused_before_anything_is_written(other, message):
    thing = Thing(a=torch.zeros(2), z=Thing())
    with pytest.raises(StateMismatchError, match=message):
        restore(thing, saved(other))
    assert thing.a.tolist() == [0.0, 0.0]


@pytest.mark.parametrize(
    "node", [("unknown",), ("object",), ("list", 3), ("dict", "dict", [1]), ("same", "x"), (), ({},)]
)
def test_a_node_that_is_none_is_refused(node):
    with pytest.raises(StateMismatchError, match="the saved state is"):
        restore(Thing(a=1), ("object", "Thing", {"a": node}))

"""A wrong attribute is one line that names what there is."""

import copy
import pickle

import pytest

from lift_lab.utils.attributes import SuggestsAttributes
from lift_lab.utils.errors import LiftLabError


class Thing(SuggestsAttributes):
    def __init__(self):
        self.height_m = 1.0
        self._hidden = 2.0

    @property
    def broken(self):
        return self.height_m.nothing_of_that_name


def test_a_public_name_is_answered_with_the_nearest():
    with pytest.raises(LiftLabError, match=r"^Thing has no 'heigth_m'; did you mean 'height_m'\?$"):
        _ = Thing().heigth_m
    with pytest.raises(AttributeError, match=r"^Thing has no 'zzz'; choose one of: 'broken', 'height_m'$"):
        _ = Thing().zzz


def test_it_is_still_an_attribute_error_for_those_who_ask():
    thing = Thing()
    assert not hasattr(thing, "width_m")
    assert getattr(thing, "width_m", 3.0) == 3.0
    assert (copy.deepcopy(thing).height_m, pickle.loads(pickle.dumps(thing))._hidden) == (1.0, 2.0)


def test_an_error_within_a_property_stays_its_own():
    with pytest.raises(AttributeError, match="'float' object has no attribute 'nothing_of_that_name'"):
        _ = Thing().broken
    with pytest.raises(AttributeError, match="'Thing' object has no attribute '_private'"):
        _ = Thing()._private

"""Contact filters, checked by asking MuJoCo which geoms touch when everything overlaps."""

from __future__ import annotations

from itertools import combinations

import mujoco
import pytest
from pxr import UsdPhysics

from lift_lab.usd import UsdImportError


def _touching(model) -> set[frozenset[str]]:
    """Pairs of geom names in contact in the initial state."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return {frozenset((model.geom(int(c.geom1)).name, model.geom(int(c.geom2)).name)) for c in data.contact}


def _pairs(*pairs: str) -> set[frozenset[str]]:
    return {frozenset(pair) for pair in pairs}


@pytest.fixture
def heap(author):
    """Free bodies a, b, c, d, each with an overlapping sphere of the same name in upper case."""

    def make(names="abcd"):
        a = author()
        for i, name in enumerate(names):
            a.body(f"/Robot/{name}", pos=(0.02 * i, 0, 1))
            a.gprim(f"/Robot/{name}/{name.upper()}", "Sphere", radius=0.1)
        return a

    return make


def _filter(a, prim, *targets):
    UsdPhysics.FilteredPairsAPI.Apply(a.stage.GetPrimAtPath(prim)).CreateFilteredPairsRel().SetTargets(list(targets))


def _group(a, path, members, filtered=(), invert=False, merge=None):
    group = UsdPhysics.CollisionGroup.Define(a.stage, path)
    group.GetCollidersCollectionAPI().CreateIncludesRel().SetTargets(list(members))
    if filtered:
        group.CreateFilteredGroupsRel().SetTargets(list(filtered))
    if invert:
        group.CreateInvertFilteredGroupsAttr(True)
    if merge:
        group.CreateMergeGroupNameAttr(merge)


def test_without_rules_everything_touches(heap):
    assert _touching(heap().load()[0]) == {frozenset(p) for p in combinations("ABCD", 2)}


def test_a_filtered_pair_of_bodies_needs_one_direction_only(heap):
    a = heap("abc")
    _filter(a, "/Robot/b", "/Robot/a")
    model, _ = a.load()
    assert _touching(model) == _pairs("AC", "BC")
    assert model.nexclude == 1


def test_a_filtered_pair_of_single_colliders_spares_their_bodies_other_colliders(heap):
    a = heap("ab")
    a.gprim("/Robot/a/X", "Sphere", radius=0.1)
    _filter(a, "/Robot/a/A", "/Robot/b/B")
    assert _touching(a.load()[0]) == _pairs("XB")


def test_a_collider_filtered_against_a_body_avoids_all_its_colliders(heap):
    a = heap("ab")
    a.gprim("/Robot/a/X", "Sphere", radius=0.1)
    a.gprim("/Robot/b/Y", "Sphere", radius=0.1)
    _filter(a, "/Robot/a/A", "/Robot/b")
    assert _touching(a.load()[0]) == _pairs("XB", "XY")


def test_a_static_collider_can_be_filtered_by_itself(heap):
    a = heap("a")
    a.gprim("/Robot/S", "Sphere", pos=(0, 0, 1.05), radius=0.1)
    a.gprim("/Robot/T", "Sphere", pos=(0, 0.05, 1), radius=0.1)
    _filter(a, "/Robot/a", "/Robot/S")
    assert _touching(a.load()[0]) == _pairs("AT")


def test_a_filter_to_nowhere_is_an_error(heap):
    a = heap("a")
    _filter(a, "/Robot/a", "/Robot/none")
    with pytest.raises(UsdImportError, match=r"</Robot/a>\.physics:filteredPairs"):
        a.load()


def test_an_articulation_filtered_against_a_body_avoids_it_with_every_link(heap):
    a = heap("abc")
    a.joint("/Robot/j", "RevoluteJoint", "/Robot/a", "/Robot/b", "Z", pos0=(0.02, 0, 0))
    UsdPhysics.ArticulationRootAPI.Apply(a.stage.GetPrimAtPath("/Robot/a"))
    _filter(a, "/Robot/c", "/Robot/a", "/Robot/b")
    assert _touching(a.load()[0]) == set()


def test_a_filter_on_an_articulation_root_above_its_links_covers_them_all(author):
    a = author()
    for i, name in enumerate("ab"):
        a.body(f"/Robot/arm/{name}", pos=(0.02 * i, 0, 1))
        a.gprim(f"/Robot/arm/{name}/{name.upper()}", "Sphere", radius=0.1)
    a.joint("/Robot/arm/j", "RevoluteJoint", "/Robot/arm/a", "/Robot/arm/b", "Z", pos0=(0.02, 0, 0))
    UsdPhysics.ArticulationRootAPI.Apply(a.stage.DefinePrim("/Robot/arm"))
    a.body("/Robot/c", pos=(0, 0, 1))
    a.gprim("/Robot/c/C", "Sphere", radius=0.1)
    _filter(a, "/Robot/arm", "/Robot/c")
    assert _touching(a.load()[0]) == set()


@pytest.mark.parametrize(
    ("attribute", "schema"),
    [
        ("physxArticulation:enabledSelfCollisions", "PhysxArticulationAPI"),
        ("newton:selfCollisionEnabled", "NewtonArticulationRootAPI"),
    ],
)
@pytest.mark.parametrize("enabled", [True, False])
def test_the_self_collision_switch_covers_all_pairs_of_links(heap, attribute, schema, enabled):
    """The chain a-b-c; d is no part of it. Neighbours never touch, whatever the switch says."""
    a = heap()
    a.joint("/Robot/j1", "RevoluteJoint", "/Robot/a", "/Robot/b", "Z", pos0=(0.02, 0, 0))
    a.joint("/Robot/j2", "RevoluteJoint", "/Robot/b", "/Robot/c", "Z", pos0=(0.02, 0, 0))
    root = a.stage.GetPrimAtPath("/Robot/a")
    UsdPhysics.ArticulationRootAPI.Apply(root)
    a.attrs(root, {attribute: enabled}, schema)
    model, _ = a.load()
    assert _touching(model) == _pairs("AD", "BD", "CD") | (_pairs("AC") if enabled else set())
    assert model.nexclude == (2 if enabled else 3)


def test_a_joint_filters_its_bodies_even_where_mujocos_parent_filter_does_not(heap):
    """MuJoCo lets a body touch a parent that is welded to the world."""
    a = heap("ab")
    a.joint("/Robot/w", "FixedJoint", None, "/Robot/a", pos0=(0, 0, 1))
    a.joint("/Robot/j", "RevoluteJoint", "/Robot/a", "/Robot/b", "Z", pos0=(0.02, 0, 0))
    assert _touching(a.load()[0]) == set()


def test_a_joint_may_leave_its_bodies_touching(heap):
    a = heap("ab")
    a.joint("/Robot/w", "FixedJoint", None, "/Robot/a", pos0=(0, 0, 1))
    joint = a.joint("/Robot/j", "RevoluteJoint", "/Robot/a", "/Robot/b", "Z", pos0=(0.02, 0, 0))
    a.attrs(joint, {"physics:collisionEnabled": True})
    assert _touching(a.load()[0]) == _pairs("AB")


@pytest.mark.parametrize("base", ["/Robot/post", "/Robot/stand", "/Robot"])
def test_a_joint_to_a_static_prim_keeps_the_body_from_that_prim_only(heap, base):
    """All static colliders share one MuJoCo body. A joint to the prim that holds everything is one to the world."""
    a = heap("a")
    a.gprim("/Robot/floor", "Sphere", pos=(0, 0, 0.95), radius=0.1)
    if base == "/Robot/stand":
        a.place(a.stage.DefinePrim("/Robot/stand", "Xform"))
    post = "/Robot/stand/post" if base == "/Robot/stand" else "/Robot/post"
    a.gprim(post, "Sphere", pos=(0, 0, 1.05), radius=0.1)
    a.joint("/Robot/slide", "PrismaticJoint", base, "/Robot/a", "Z", pos0=(0, 0, -0.05 if base == post else 1))
    model, _ = a.load()
    assert _touching(model) == _pairs(("A", "floor")) | (_pairs(("A", "post")) if base == "/Robot" else set())


def test_authored_bits_hold_beside_rules(heap, notes):
    """A and B by a rule, C never, D only with A by its bits."""
    a = heap()
    for name, contype, conaffinity in (("a", 3, 1), ("c", 0, 0), ("d", 0, 2)):
        prim = f"/Robot/{name}/{name.upper()}"
        a.attrs(prim, {"mjc:contype": contype, "mjc:conaffinity": conaffinity}, "MjcCollisionAPI")
    assert _touching(a.load()[0]) == _pairs("AB", "AD")
    a.gprim("/Robot/a/X", "Sphere", radius=0.1)
    _filter(a, "/Robot/a/A", "/Robot/b/B")
    model, report = a.load()
    assert _touching(model) == _pairs("AD", "XB")
    assert model.geom("C").contype == model.geom("C").conaffinity == 0
    assert notes(report, "/Robot/d/D")[1]


def test_a_filter_outlasts_the_self_collision_switch(heap):
    """Of b and d one pair is forbidden; switching self-collision on takes away only what the switch forbade."""
    from lift_lab.sim.schemas import ArticulationRootPropertiesCfg, apply_schemas
    from lift_lab.sim.spawners import UsdFileCfg
    from lift_lab.usd import load

    a = heap("bcd")
    a.gprim("/Robot/b/X", "Sphere", radius=0.1)
    a.joint("/Robot/j1", "RevoluteJoint", "/Robot/b", "/Robot/c", "Z", pos0=(0.02, 0, 0))
    a.joint("/Robot/j2", "RevoluteJoint", "/Robot/c", "/Robot/d", "Z", pos0=(0.02, 0, 0))
    root = a.stage.GetPrimAtPath("/Robot/b")
    UsdPhysics.ArticulationRootAPI.Apply(root)
    a.attrs(root, {"physxArticulation:enabledSelfCollisions": False}, "PhysxArticulationAPI")
    _filter(a, "/Robot/b/B", "/Robot/d/D")
    spec, _ = load(a.stage)
    assert _touching(spec.copy().compile()) == set()
    props = ArticulationRootPropertiesCfg(enabled_self_collisions=True)
    apply_schemas(spec, UsdFileCfg(usd_path="", articulation_props=props), "robot")
    assert _touching(spec.compile()) == _pairs("XD")


@pytest.mark.filterwarnings("ignore:Attach conflict")
def test_rules_of_one_asset_do_not_hold_for_another(heap):
    import mujoco

    from lift_lab.usd import load
    from lift_lab.usd.filters import separate_classes

    scene = mujoco.MjSpec()
    for prefix in ("1", "2", "3"):
        a = heap("ab")
        a.gprim("/Robot/a/X", "Sphere", radius=0.1)
        _filter(a, "/Robot/a/A", "/Robot/b/B")
        spec, report = load(a.stage)
        separate_classes(spec, report.contact_classes, scene)
        scene.attach(spec, prefix=prefix, frame=scene.worldbody.add_frame())
    names = [prefix + name for prefix in "123" for name in "ABX"]
    expected = {frozenset(pair) for pair in combinations(names, 2)}
    for prefix in "123":  # by the rule, and within one body
        expected -= {frozenset((f"{prefix}A", f"{prefix}B")), frozenset((f"{prefix}A", f"{prefix}X"))}
    assert _touching(scene.compile()) == expected


def test_bodies_that_mujoco_itself_keeps_apart_are_reported(heap, notes):
    """b is welded to a, and c hinged to a: MuJoCo takes a and b for one body, whose child c never touches it."""
    a = heap("abc")
    a.joint("/Robot/w", "FixedJoint", "/Robot/a", "/Robot/b", pos0=(0.02, 0, 0))
    a.joint("/Robot/j", "RevoluteJoint", "/Robot/a", "/Robot/c", "Z", pos0=(0.04, 0, 0))
    model, report = a.load()
    assert _touching(model) == set()
    assert any("/Robot/b" in reason for reason in notes(report, "/Robot/c")[1])


def test_collision_groups_filter_each_other_and_nothing_else(heap):
    a = heap()
    _group(a, "/Robot/g1", ["/Robot/a", "/Robot/b"], filtered=["/Robot/g2"])
    _group(a, "/Robot/g2", ["/Robot/c"])
    assert _touching(a.load()[0]) == _pairs("AB", "AD", "BD", "CD")


def test_a_collision_group_can_filter_itself(heap):
    a = heap()
    _group(a, "/Robot/g1", ["/Robot/a", "/Robot/b", "/Robot/c"], filtered=["/Robot/g1"])
    assert _touching(a.load()[0]) == _pairs("AD", "BD", "CD")


def test_an_inverted_group_touches_only_what_it_lists(heap):
    a = heap()
    _group(a, "/Robot/g1", ["/Robot/a"], filtered=["/Robot/g2"], invert=True)
    _group(a, "/Robot/g2", ["/Robot/b"])
    _group(a, "/Robot/g3", ["/Robot/c"])
    assert _pairs("AB", "BC") <= _touching(a.load()[0])
    assert not _pairs("AC") & _touching(a.load()[0])


def test_merged_groups_share_their_filters(heap):
    a = heap()
    _group(a, "/Robot/g1", ["/Robot/a"], filtered=["/Robot/g3"], merge="m")
    _group(a, "/Robot/g2", ["/Robot/b"], merge="m")
    _group(a, "/Robot/g3", ["/Robot/c"])
    assert _touching(a.load()[0]) == _pairs("AB", "AD", "BD", "CD")


def test_grouped_colliders_still_touch_geoms_of_other_models(heap):
    """Attached beside a plain MJCF sphere with contype = conaffinity = 1."""
    from lift_lab.usd import load

    a = heap("ab")
    a.gprim("/Robot/a/X", "Sphere", radius=0.1)
    _group(a, "/Robot/g1", ["/Robot/a/A"], filtered=["/Robot/g2"])
    _group(a, "/Robot/g2", ["/Robot/b"])
    spec, _ = load(a.stage)
    body = spec.worldbody.add_body(name="other", pos=(0, 0, 1))
    body.add_freejoint()
    body.add_geom(name="O", size=[0.1, 0, 0])
    assert _touching(spec.compile()) == _pairs("OA", "OB", "OX", "BX")


def test_more_classes_than_bits_are_reported(author, notes):
    """40 pairs of colliders, each forbidding only its partner, on two shared bodies."""
    a = author()
    for name in ("p", "q"):
        a.body(f"/Robot/{name}", pos=(0, 0, 1))
        for i in range(20):
            a.gprim(f"/Robot/{name}/{name}{i}", "Sphere", radius=0.1)
    for i in range(20):
        _filter(a, f"/Robot/p/p{i}", f"/Robot/q/q{i}")
    _, report = a.load()
    assert any("bits" in note.reason for note in report.ignored)

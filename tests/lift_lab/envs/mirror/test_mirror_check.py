"""A right declaration of a walking robot passes the check, a wrong one is named, and the environment is as before."""

import pytest
import torch
from walker import HEIGHTS, author_walker, make_walker

from lift_lab.envs.mirror import TaskMirror, check_mirror
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.mirror import MirrorTermCfg, mirrors_as

PHYSICS = ["native", pytest.param("warp", marks=pytest.mark.slow)]


@pytest.fixture(scope="module")
def walker_file(tmp_path_factory):
    return author_walker(tmp_path_factory.mktemp("usd") / "walker.usda")


@pytest.fixture(scope="module")
def walker(walker_file):
    env = make_walker(walker_file)
    yield env
    env.close()


@pytest.fixture
def mirror_of(walker):
    """The walker with another declaration."""
    right = walker.cfg.mirror.copy()

    def declare(**fields):
        walker.cfg.mirror = right.replace(**fields)
        return walker

    yield declare
    walker.cfg.mirror = right


def flat(value, path=""):
    """Every number of a state, by path."""
    if isinstance(value, torch.Tensor):
        return {path: value.cpu().numpy().tobytes()}
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list | tuple) else None
    if items is None:
        return {path: value}
    return {key: entry for name, one in items for key, entry in flat(one, f"{path}/{name}").items()}


def complaint(env) -> str:
    with pytest.raises(ConfigError) as caught:
        check_mirror(env, ["policy"])
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("physics", PHYSICS)
def test_the_right_declaration_passes_and_changes_nothing(walker_file, physics):
    env = make_walker(walker_file, physics)
    for _ in range(3):
        env.step(torch.ones(3, 8))
    torch.manual_seed(4)
    stream, before = torch.get_rng_state(), env.state_dict()
    check_mirror(env, ["policy"])
    assert torch.equal(torch.get_rng_state(), stream)  # no term draws any
    assert flat(env.state_dict()) == flat(before)
    env.close()


def test_the_map_is_that_of_a_walking_robot(walker):
    """Joints are in the order of the robot's file; the numbers are from its geometry."""
    mirror = TaskMirror(walker)
    names = walker.scene["robot"].joint_names
    other_side = {"FL": "FR", "FR": "FL", "RL": "RR", "RR": "RL"}
    image = mirror.actions()
    for i, name in enumerate(names):
        leg, _, joint = name.partition("_")
        assert names[image.index[i]] == f"{other_side[leg]}_{joint}"
        # the front hips are at 0.1, the rear ones at -0.1: -(0.1 + 0.25 a) = 0.1 + 0.25 a', so a' = -a - 0.8
        is_hip = "hip" in joint
        assert image.factor[i] == (-1.0 if is_hip else 1.0)
        expected = {"F": -0.8, "R": 0.8}[leg[0]] if is_hip else 0.0
        assert image.offset[i].item() == pytest.approx(expected, abs=1e-6)
    assert mirror.observation("policy", "lin_vel").factor.tolist() == [1.0, -1.0, 1.0]
    assert mirror.observation("policy", "command").factor.tolist() == [1.0, -1.0, -1.0]
    # scales differ by axis: the image of a pseudo-vector keeps its axes
    assert mirror.observation("policy", "ang_vel").factor.tolist() == pytest.approx([-1.0, 1.0, -1.0])
    assert len(mirror.group("policy")) == walker.observation_manager.group_obs_dim["policy"][0]
    assert mirror.group("policy").is_own_inverse()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"signs": {".*": 1}}, "the bodies' positions: number"),
        ({"signs": {".*_hip_joint": 1, ".*_thigh_joint": -1}}, "env.scene.robot: the bodies' positions"),
        ({"swaps": {}}, "the bodies' positions: number 3 (x of"),
        ({"swaps": {"FL_": "RL_", "FR_": "RR_"}}, "the bodies' positions"),
        ({"offsets": {".*_hip_joint": 0.1}}, "the bodies' positions"),
        ({"signs": {".*_hip_joint": -1}}, "env.mirror.assets.robot.signs names no sign of 'FL_thigh_joint'"),
        ({"signs": {".*_hip_joint": -0.5, ".*_thigh_joint": 1}}, "a sign is 1 or -1"),
        ({"signs": {".*_knee": -1, ".*": 1}}, "env.mirror.assets.robot.signs: "),
        ({"offsets": {".*_thigh_joint": 0.1}}, "the image of the image is not the robot"),
        ({"swaps": {"FL_": "FR_", "left": "right"}}, "no joint or body has 'left' or 'right'"),
        ({"swaps": {"FL_": "XX_"}}, "'FL_hip_joint' changes places with 'XX_hip_joint', which is not among"),
    ],
    ids=lambda value: str(value)[:40],
)
def test_a_wrong_declaration_of_the_joints_is_named(mirror_of, change, message):
    env = mirror_of()
    env.cfg.mirror.assets["robot"] = env.cfg.mirror.assets["robot"].replace(**change)
    assert message in complaint(env)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"observations": {"heights": "same"}}, "env.observations.policy.heights: number 0 does not mirror"),
        ({"observations": {"heights": HEIGHTS, "lin_vel": "pseudo_vector"}}, "env.observations.policy.lin_vel: number"),
        ({"observations": {"policy/heights": HEIGHTS, "policy/gravity": "pseudo_vector"}}, "policy.gravity: number 0"),
        ({"observations": {}}, "policy.heights: 'left_feet_first' is not a known term; declare its mirror image"),
        ({"observations": {"height": HEIGHTS}}, "env.mirror.observations: the environment has no 'height'"),
        ({"observations": {"heights": "vektor"}}, "there is no kind of mirror image 'vektor'; did you mean 'vector'"),
        ({"observations": {"heights": "vector"}}, "policy.heights: it has 4 numbers, a 'vector' has 3"),
        ({"observations": {"heights": MirrorTermCfg(signs=[1, -1])}}, "it has 4 numbers, signs has 2"),
        ({"observations": {"heights": MirrorTermCfg(order=[1, 2, 3, 3])}}, "order names each of 0 to 3 once"),
        ({"observations": {"heights": MirrorTermCfg(order=[1, 2, 3, 0])}}, "the image of the image is not the value"),
        ({"actions": {"legs": "same"}}, "env.scene.robot: the joints' position targets: number"),
        ({"actions": {"legs": "negated"}}, "env.scene.robot: the joints' position targets: number"),
        ({"actions": {"arm": "same"}}, "env.mirror.actions: the environment has no 'arm'"),
        ({"commands": {"velocity": "planar_pose"}}, "env.commands.velocity: it has 3 numbers, a 'planar_pose' has 4"),
        ({"assets": {}}, "env.mirror.assets does not say how the joints of 'robot' mirror"),
        ({"assets": {"robbot": None}}, "env.mirror.assets: the environment has no 'robbot'; did you mean 'robot'"),
    ],
    ids=lambda value: str(value)[:60],
)
def test_a_wrong_declaration_of_a_term_is_named(mirror_of, fields, message):
    if "actions" in fields or "commands" in fields:
        fields = {"observations": {"heights": HEIGHTS}, **fields}
    assert message in complaint(mirror_of(**fields))


def test_a_task_without_a_declaration_says_what_to_declare(mirror_of):
    env = mirror_of()
    env.cfg.mirror = None
    assert "set env.mirror to a MirrorCfg" in complaint(env)


def test_bodies_at_different_places_are_left_out(mirror_of):
    """A wrong sign that only the thighs show passes where they are not looked at and nothing else depends on it."""
    env = mirror_of()
    robot = env.cfg.mirror.assets["robot"].replace(offsets={".*_hip_joint": 0.1}, checked_bodies=["base"])
    env.cfg.mirror.assets["robot"] = robot
    assert "env.observations.policy.thighs" in complaint(env)


def test_a_term_may_declare_its_kind_beside_its_function(mirror_of):
    env = mirror_of(observations={})
    cfg = next(
        cfg
        for name, cfg in zip(
            env.observation_manager.active_terms["policy"],
            env.observation_manager.group_obs_term_cfgs["policy"],
            strict=True,
        )
        if name == "heights"
    )
    before = cfg.func

    @mirrors_as("same")
    def mean_height(env):
        return before(env).mean(1, keepdim=True).expand(-1, 4)

    cfg.func = mean_height
    try:
        check_mirror(env, ["policy"])
    finally:
        cfg.func = before
    with pytest.raises(ConfigError, match="no kind of mirror image 'up'"):
        mirrors_as("up")

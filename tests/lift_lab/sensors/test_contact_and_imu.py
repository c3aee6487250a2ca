"""Contact sensors and IMUs measure what the laws of motion say, on both engines."""

import math
from types import SimpleNamespace

import pytest
import torch

import lift_lab.sim as sim_utils
from lift_lab.assets import AssetBaseCfg, RigidObjectCfg
from lift_lab.envs import mdp
from lift_lab.managers import SceneEntityCfg
from lift_lab.scene import InteractiveScene, InteractiveSceneCfg
from lift_lab.sensors import ContactSensorCfg, FrameTransformerCfg, ImuCfg
from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError, PhysicsError, UnknownAttributeError
from lift_lab.utils.math import matrix_from_quat

NUM_ENVS = 2
G = 9.81
DT = 0.005
SIZE = 0.2
LOWER, UPPER = 2.0, 0.5
"""Masses in kg."""


def _box(name: str, height: float, mass: float, **state) -> RigidObjectCfg:
    return RigidObjectCfg(
        prim_path=f"{{ENV_REGEX_NS}}/{name}",
        init_state=RigidObjectCfg.InitialStateCfg(pos=(0.3, -0.2, height), **state),
        spawn=sim_utils.CuboidCfg(
            size=(SIZE, SIZE, SIZE),
            rigid_props=sim_utils.RigidBodyPropertiesCfg(),
            mass_props=sim_utils.MassPropertiesCfg(mass=mass),
            collision_props=sim_utils.CollisionPropertiesCfg(),
            physics_material=sim_utils.RigidBodyMaterialCfg(static_friction=1.0, dynamic_friction=1.0),
        ),
    )


@configclass
class _SceneCfg(InteractiveSceneCfg):
    ground: AssetBaseCfg | None = AssetBaseCfg(prim_path="/World/ground", spawn=sim_utils.GroundPlaneCfg())
    lower: RigidObjectCfg | None = None
    upper: RigidObjectCfg | None = None
    contact: ContactSensorCfg | None = None
    imu: ImuCfg | None = None
    frames: FrameTransformerCfg | None = None


class _World:
    """A scene and its steps."""

    def __init__(self, engine: str, gravity: tuple[float, float, float] = (0.0, 0.0, -G), **entities):
        cfg = sim_utils.SimulationCfg(dt=DT, device="cpu", physics=engine, gravity=gravity, num_threads=1)
        self.sim = sim_utils.SimulationContext(cfg)
        self.scene = InteractiveScene(_SceneCfg(num_envs=NUM_ENVS, env_spacing=3.0, **entities))
        self.sim.reset()
        self.scene.update(0.0)

    def step(self, steps: int) -> None:
        for _ in range(steps):
            self.sim.step()
            self.scene.update(DT)


@pytest.fixture(params=["native", "warp"])
def world(request):
    """Makes a world on each engine and closes it."""
    made = []

    def make(**options) -> _World:
        made.append(_World(request.param, **options))
        return made[-1]

    yield make
    for one in made:
        one.sim.close()


def _contact(prim: str = "Lower", **options) -> ContactSensorCfg:
    return ContactSensorCfg(prim_path=f"{{ENV_REGEX_NS}}/{prim}", **options)


def _everywhere(*vector: float) -> torch.Tensor:
    return torch.tensor(vector).expand(NUM_ENVS, 3)


def _close(actual: torch.Tensor, expected: torch.Tensor, atol: float = 0.02) -> None:
    torch.testing.assert_close(actual, expected, atol=atol, rtol=0.0)


def test_stacked_boxes_carry_their_weights(world):
    ours = world(
        lower=_box("Lower", 0.5 * SIZE, LOWER),
        upper=_box("Upper", 1.5 * SIZE, UPPER),
        contact=_contact(filter_prim_paths_expr=["{ENV_REGEX_NS}/Upper", "/World/ground"]),
    )
    ours.step(200)
    data = ours.scene["contact"].data
    assert data.net_forces_w.shape == (NUM_ENVS, 1, 3)
    assert data.force_matrix_w.shape == (NUM_ENVS, 1, 2, 3)
    # the ground holds both, the upper box presses with its own weight, and the lower box's weight is the sum
    _close(data.force_matrix_w[:, 0, 0], _everywhere(0.0, 0.0, -UPPER * G))
    _close(data.force_matrix_w[:, 0, 1], _everywhere(0.0, 0.0, (LOWER + UPPER) * G))
    _close(data.net_forces_w[:, 0], _everywhere(0.0, 0.0, LOWER * G))
    assert ours.scene["contact"].body_names == ["Lower"]


def test_on_a_slope_the_net_force_is_normal_and_friction_is_tangential(world):
    slope = math.radians(20.0)
    ours = world(
        gravity=(G * math.sin(slope), 0.0, -G * math.cos(slope)),
        lower=_box("Lower", 0.5 * SIZE, LOWER),
        contact=_contact(
            filter_prim_paths_expr=["/World/ground"],
            track_friction_forces=True,
            track_contact_points=True,
            track_pose=True,
        ),
    )
    ours.step(200)
    data = ours.scene["contact"].data
    normal = _everywhere(0.0, 0.0, LOWER * G * math.cos(slope))
    _close(data.net_forces_w[:, 0], normal, atol=0.05)
    _close(data.force_matrix_w[:, 0, 0], normal, atol=0.05)
    _close(data.friction_forces_w[:, 0, 0], _everywhere(-LOWER * G * math.sin(slope), 0.0, 0.0), atol=0.05)
    # the mean of the corners' positions lies under the box's centre, in the world's frame
    _close(data.contact_pos_w[:, 0, 0, :2], data.pos_w[:, 0, :2], atol=1e-3)
    _close(data.pos_w[:, 0], ours.scene["lower"].data.root_pos_w, atol=1e-6)
    assert data.contact_pos_w[0, 0, 0, :2].ne(data.contact_pos_w[1, 0, 0, :2]).any()


def test_a_falling_box_counts_its_time_in_the_air_and_then_in_contact(world):
    height = 0.05
    ours = world(
        lower=_box("Lower", 0.5 * SIZE + height, LOWER),
        contact=_contact(
            track_air_time=True,
            history_length=3,
            filter_prim_paths_expr=["/World/ground"],
            track_contact_points=True,
        ),
    )
    sensor = ours.scene["contact"]
    assert ours.scene.substep_entities == ["contact"]
    fall = math.sqrt(2.0 * height / G)
    steps = int(fall / DT) - 1
    ours.step(steps)
    _close(sensor.data.current_air_time, torch.full((NUM_ENVS, 1), steps * DT), atol=1e-5)
    assert sensor.data.contact_pos_w.isnan().all()
    assert not sensor.data.net_forces_w.any()
    landings = 0
    past = []
    for step in range(steps + 1, steps + 61):
        ours.step(1)
        if sensor.compute_first_contact(DT)[0, 0]:
            landings += 1
            _close(sensor.data.last_air_time, torch.full((NUM_ENVS, 1), step * DT), atol=1e-5)
        past = [sensor.data.net_forces_w.clone(), *past[:2]]
        torch.testing.assert_close(sensor.data.net_forces_w_history[:, : len(past)], torch.stack(past, dim=1))
    assert landings == 1
    assert not sensor.compute_first_air(DT).any()
    assert sensor.data.last_air_time[0, 0].item() == pytest.approx(fall, abs=3 * DT)
    total = sensor.data.last_air_time + sensor.data.current_contact_time
    _close(total, torch.full((NUM_ENVS, 1), (steps + 60 + 1) * DT), atol=1.01 * DT)
    assert not sensor.data.current_air_time.any()
    in_contact = sensor.data.current_contact_time.clone()
    ours.scene["lower"].write_root_velocity_to_sim(torch.tensor([[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]]).repeat(NUM_ENVS, 1))
    ours.step(1)
    assert sensor.compute_first_air(DT).all()
    _close(sensor.data.last_contact_time, in_contact + DT, atol=1e-5)
    assert not sensor.data.current_contact_time.any()


def test_less_than_the_threshold_is_no_contact():
    ours = _World(
        "native",
        lower=_box("Lower", 0.5 * SIZE, LOWER),
        contact=_contact(track_air_time=True, force_threshold=3.0 * LOWER * G),
    )
    ours.step(20)
    data = ours.scene["contact"].data
    assert data.net_forces_w[..., 2].min() > 0.5 * LOWER * G
    assert not data.current_contact_time.any()
    _close(data.current_air_time, torch.full((NUM_ENVS, 1), 20 * DT), atol=1e-5)
    ours.sim.close()


def test_a_reset_clears_the_readings_of_its_environments_only(world):
    ours = world(
        lower=_box("Lower", 0.5 * SIZE, LOWER),
        contact=_contact(track_air_time=True, history_length=2, filter_prim_paths_expr=["/World/ground"]),
    )
    ours.step(100)
    ours.scene.reset(torch.tensor([0]))
    ours.sim.forward()
    ours.scene.update(0.0)
    data = ours.scene["contact"].data
    for value in (data.net_forces_w, data.net_forces_w_history, data.force_matrix_w, data.current_contact_time):
        assert not value[0].any()
        assert value[1].any()
    so_far = data.current_contact_time[1].item()
    ours.step(1)
    _close(ours.scene["contact"].data.net_forces_w[:, 0], _everywhere(0.0, 0.0, LOWER * G))
    _close(data.current_contact_time[:, 0], torch.tensor([DT, so_far + DT]), atol=1e-5)


def test_an_update_period_thins_out_the_history():
    ours = _World(
        "native",
        lower=_box("Lower", 0.5 * SIZE + 0.3, LOWER),
        contact=_contact(update_period=4 * DT, history_length=2, track_air_time=True),
    )
    ours.step(7)
    _close(ours.scene["contact"].data.current_air_time, torch.full((NUM_ENVS, 1), 4 * DT), atol=1e-6)
    ours.step(1)
    _close(ours.scene["contact"].data.current_air_time, torch.full((NUM_ENVS, 1), 8 * DT), atol=1e-6)
    ours.step(2)
    ours.scene.reset(torch.tensor([0]))  # whose period begins anew
    ours.step(2)
    _close(ours.scene["contact"].data.current_air_time, torch.tensor([[0.0], [12 * DT]]), atol=1e-6)
    ours.sim.close()


def test_an_imu_at_rest_feels_its_support(world):
    turn = math.sqrt(0.5)  # a quarter turn about x: the sensor's y axis points up
    ours = world(
        lower=_box("Lower", 0.5 * SIZE, LOWER),
        imu=ImuCfg(prim_path="{ENV_REGEX_NS}/Lower", offset=ImuCfg.OffsetCfg(pos=(0, 0, 0.1), rot=(turn, turn, 0, 0))),
    )
    _close(ours.scene["imu"].data.lin_acc_b, _everywhere(0.0, G, 0.0), atol=1e-3)  # also before the first step
    ours.step(200)
    data = ours.scene["imu"].data
    _close(data.lin_acc_b, _everywhere(0.0, G, 0.0), atol=0.02)
    _close(data.projected_gravity_b, _everywhere(0.0, -1.0, 0.0), atol=1e-4)
    _close(data.ang_acc_b, _everywhere(0.0, 0.0, 0.0), atol=0.05)
    _close(data.pos_w, ours.scene["lower"].data.root_pos_w + torch.tensor([0.0, 0.0, 0.1]), atol=1e-4)


def test_an_imu_in_free_fall_feels_nothing_but_its_spin(world):
    spin, arm = 3.0, 0.08
    ours = world(
        ground=None,
        lower=_box("Lower", 2.0, LOWER, lin_vel=(0.4, 0.0, 0.0), ang_vel=(0.0, 0.0, spin)),
        imu=ImuCfg(prim_path="{ENV_REGEX_NS}/Lower", offset=ImuCfg.OffsetCfg(pos=(arm, 0.0, 0.0))),
    )
    ours.step(20)
    data = ours.scene["imu"].data
    time = 20 * DT
    # the centripetal acceleration; a cube spins on about any axis
    _close(data.lin_acc_b, _everywhere(-(spin**2) * arm, 0.0, 0.0), atol=1e-3)
    _close(data.ang_vel_b, _everywhere(0.0, 0.0, spin), atol=1e-4)
    _close(data.ang_acc_b, _everywhere(0.0, 0.0, 0.0), atol=1e-3)
    angle = spin * time
    expected = _everywhere(0.4 * math.cos(angle), spin * arm - 0.4 * math.sin(angle), -G * time)
    _close(data.lin_vel_b, expected, atol=2e-3)


def test_without_bias_an_imu_gives_the_acceleration_itself(world):
    ours = world(
        ground=None,
        lower=_box("Lower", 2.0, LOWER),
        imu=ImuCfg(prim_path="{ENV_REGEX_NS}/Lower", gravity_bias=(0.0, 0.0, 0.0)),
    )
    ours.step(3)
    _close(ours.scene["imu"].data.lin_acc_b, _everywhere(0.0, 0.0, -G), atol=1e-3)
    ours.scene["imu"].reset(torch.tensor([1]))
    _close(ours.scene["imu"].data.lin_acc_b[1], torch.zeros(3), atol=1e-6)
    _close(ours.scene["imu"].data.lin_acc_b[0], torch.tensor([0.0, 0.0, -G]), atol=1e-3)


def test_an_imu_on_a_turning_body_reads_what_acted_at_the_start_of_the_last_step(world):
    """Gravity, a bias, a spin of 20 rad/s and a torque: a tenth of a radian between the start of a step and its end."""
    bias, arm = torch.tensor([1.0, -2.0, 4.0]), torch.tensor([0.08, 0.0, 0.05])
    ours = world(
        ground=None,
        lower=_box("Lower", 2.0, LOWER, ang_vel=(3.0, 20.0, 1.0)),
        imu=ImuCfg(
            prim_path="{ENV_REGEX_NS}/Lower",
            gravity_bias=tuple(bias.tolist()),
            offset=ImuCfg.OffsetCfg(pos=tuple(arm.tolist())),
        ),
    )
    box = ours.scene["lower"]
    torque = torch.tensor([0.2, 0.0, 0.4])
    box.set_external_force_and_torque(torch.zeros(NUM_ENVS, 1, 3), torque.expand(NUM_ENVS, 1, 3), is_global=True)
    ours.scene.write_data_to_sim()
    ours.step(2)
    turned = matrix_from_quat(box.data.root_quat_w)  # from the body into the world
    spin, lever = box.data.root_ang_vel_w, (turned @ arm[:, None]).squeeze(-1)
    ours.step(1)
    faster = (torque / (LOWER * SIZE**2 / 6)).expand(NUM_ENVS, 3)  # a cube's inertia is the same about any axis
    acceleration = torch.tensor([0.0, 0.0, -G]) + torch.linalg.cross(faster, lever)
    acceleration = acceleration + torch.linalg.cross(spin, torch.linalg.cross(spin, lever))
    data = ours.scene["imu"].data
    _close(data.lin_acc_b, ((acceleration + bias)[:, None] @ turned).squeeze(1), atol=5e-3)
    _close(data.ang_acc_b, (faster[:, None] @ turned).squeeze(1), atol=5e-3)


@pytest.mark.parametrize(
    ("sensor", "message"),
    [
        (_contact("Lowr"), r"scene.contact.prim_path: no asset has the prim path '.*/Lowr'; did you mean"),
        (_contact("Lower/foot"), "'lower' has no body 'foot'"),
        (ContactSensorCfg(prim_path="/World/ground"), "'ground' is static, it has no body"),
        (_contact(filter_prim_paths_expr=["/World/sky"]), r"filter_prim_paths_expr\[0\]: no asset"),
        (_contact(track_friction_forces=True), "need filter_prim_paths_expr"),
    ],
)
def test_a_contact_sensor_says_what_it_cannot_find(sensor, message):
    with pytest.raises(ConfigError, match=message):
        _World("native", lower=_box("Lower", 0.5 * SIZE, LOWER), contact=sensor)


def test_a_reading_that_a_sensor_has_not_is_answered_with_its_name_and_the_nearest():
    tip = FrameTransformerCfg.FrameCfg(prim_path="{ENV_REGEX_NS}/Lower", name="tip")
    ours = _World(
        "native",
        lower=_box("Lower", 0.5 * SIZE, LOWER),
        contact=_contact(),
        imu=ImuCfg(prim_path="{ENV_REGEX_NS}/Lower"),
        frames=FrameTransformerCfg(prim_path="{ENV_REGEX_NS}/Lower", target_frames=[tip]),
    )
    for name, kind, wrong, right in (
        ("contact", "ContactSensor", "net_force_w", "net_forces_w"),
        ("imu", "Imu", "lin_accel_b", "lin_acc_b"),
        ("frames", "FrameTransformer", "target_poses_w", "target_pos_w"),
    ):
        message = rf"^the data of '{name}' \({kind}\) have no '{wrong}'; did you mean .*'{right}'"
        with pytest.raises(UnknownAttributeError, match=message):
            getattr(ours.scene[name].data, wrong)
        with pytest.raises(UnknownAttributeError, match=rf"^'{name}' \({kind}\) has no 'dat'; did you mean 'data'"):
            _ = ours.scene[name].dat
    ours.sim.close()


def test_times_must_be_asked_for():
    ours = _World("native", lower=_box("Lower", 0.5 * SIZE, LOWER), contact=_contact())
    with pytest.raises(PhysicsError, match="set track_air_time"):
        ours.scene["contact"].compute_first_contact(DT)
    ours.sim.close()


def test_terms_read_the_sensors_of_a_scene():
    ours = _World(
        "native",
        lower=_box("Lower", 0.5 * SIZE, LOWER),
        contact=_contact(history_length=2),
        imu=ImuCfg(prim_path="{ENV_REGEX_NS}/Lower"),
    )
    ours.step(200)
    env = SimpleNamespace(scene=ours.scene, num_envs=NUM_ENVS, device="cpu")
    chosen = SceneEntityCfg("contact", body_names="Lower")
    chosen.resolve(ours.scene)
    weight = LOWER * G
    assert mdp.undesired_contacts(env, 0.9 * weight, chosen).tolist() == [1] * NUM_ENVS
    assert not mdp.illegal_contact(env, 1.1 * weight, chosen).any()
    _close(mdp.contact_forces(env, 0.5 * weight, chosen), torch.full((NUM_ENVS,), 0.5 * weight))
    _close(mdp.imu_lin_acc(env), _everywhere(0.0, 0.0, G))
    _close(mdp.imu_projected_gravity(env), _everywhere(0.0, 0.0, -1.0))
    _close(mdp.imu_orientation(env), ours.scene["lower"].data.root_quat_w, atol=1e-5)
    _close(mdp.imu_ang_vel(env), _everywhere(0.0, 0.0, 0.0))
    ours.sim.close()

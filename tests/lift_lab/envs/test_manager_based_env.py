"""The environment without rewards, and what frames it asks for."""

import math

import numpy as np
import pytest
import torch

import lift_lab.envs.mdp as mdp
from lift_lab.envs import ManagerBasedEnv, ManagerBasedEnvCfg, ManagerBasedRLEnv
from lift_lab.managers import EventTermCfg, ManagerTermBase, SceneEntityCfg
from lift_lab.utils.errors import ConfigError


@pytest.fixture
def base_cfg(make_cfg):
    """A config of the base class with the world of :func:`make_cfg`."""

    def make(**fields) -> ManagerBasedEnvCfg:
        source = make_cfg()
        cfg = ManagerBasedEnvCfg(
            scene=source.scene,
            sim=source.sim,
            observations=source.observations,
            actions=source.actions,
            decimation=4,
            seed=1,
        )
        for name, value in fields.items():
            setattr(cfg, name, value)
        return cfg

    return make


def test_a_step_returns_observations_and_extras(make_env, base_cfg):
    env = make_env(ManagerBasedEnv, base_cfg())
    first, _ = env.reset()
    obs, extras = env.step(torch.ones(3, 2))
    assert obs["policy"].shape == (3, 25)
    assert (obs["policy"][:, :2] - first["policy"][:, :2]).abs().min() > 1e-3
    assert extras["log"] == {}


def test_the_default_events_reset_the_scene(make_env, base_cfg):
    env = make_env(ManagerBasedEnv, base_cfg())
    env.reset()
    for _ in range(3):
        env.step(torch.ones(3, 2))
    obs, _ = env.reset()
    torch.testing.assert_close(obs["policy"][:, :2], env.scene["robot"].data.default_joint_pos)


def test_startup_events_act_once_after_the_simulation_starts(make_env, base_cfg):
    calls = []

    def heavier(env, env_ids):
        calls.append(env_ids)
        env.scene["ball"].write_body_mass_to_sim(torch.full((3, 1), 2.0))

    env = make_env(ManagerBasedEnv, base_cfg(events={"heavier": EventTermCfg(func=heavier, mode="startup")}))
    env.reset()
    env.step(torch.zeros(3, 2))
    assert calls == [None]
    torch.testing.assert_close(env.scene["ball"].get_masses(), torch.full((3, 1), 2.0))


def test_prestartup_events_act_before_the_model_is_compiled(make_env, base_cfg):
    def rename(env, env_ids):
        assert not env.sim.is_started
        env.scene.spec.modelname = "touched"

    env = make_env(ManagerBasedEnv, base_cfg(events={"rename": EventTermCfg(func=rename, mode="prestartup")}))
    assert env.sim.is_started
    assert env.scene.spec.modelname == "touched"


def test_a_class_term_of_any_mode_may_change_the_model_before_it_is_compiled(make_env, base_cfg):
    class Heavier(ManagerTermBase):
        @classmethod
        def prepare_model(cls, env, factor):
            for body in env.scene.spec.bodies:
                body.mass *= factor

        def __call__(self, env, env_ids, factor):
            """Do nothing more."""

    before = make_env(ManagerBasedEnv, base_cfg(events={})).sim.model.body_mass.copy()
    term = EventTermCfg(func=Heavier, mode="reset", params={"factor": 2.0})
    after = make_env(ManagerBasedEnv, base_cfg(events={"heavier": term})).sim.model.body_mass
    np.testing.assert_allclose(after, 2.0 * before)
    assert before.max() > 0.0


def test_prestartup_events_that_need_the_simulation_are_told_so(make_env, base_cfg):
    def heavier(env, env_ids):
        env.scene["ball"].set_masses(env.scene["ball"].data.default_mass)

    with pytest.raises(ConfigError, match=r"'heavier': its function needs the simulation.*use mode 'startup'"):
        make_env(ManagerBasedEnv, base_cfg(events={"heavier": EventTermCfg(func=heavier, mode="prestartup")}))


def test_numbers_of_numpy_count_as_pythons_own(make_env, base_cfg):
    cfg = base_cfg()
    cfg.sim.dt, cfg.decimation = np.float32(0.01), np.int64(2)
    env = make_env(ManagerBasedEnv, cfg)
    env.reset()
    env.step(torch.zeros(3, 2))
    assert type(env.step_dt) is float
    assert env.step_dt == pytest.approx(0.02)


def test_an_interval_event_fires_every_so_many_steps(make_env, base_cfg):
    counter = []

    def count(env, env_ids):
        counter.append(env_ids.tolist())

    event = EventTermCfg(func=count, mode="interval", interval_range_s=(0.06, 0.06))
    env = make_env(ManagerBasedEnv, base_cfg(events={"count": event}))
    env.reset()
    for _ in range(7):
        env.step(torch.zeros(3, 2))
    assert counter == [[0, 1, 2], [0, 1, 2]]


# -- frames


class _Frames:
    """Stands in for the renderer and keeps the view that it was asked to draw."""

    def __init__(self):
        self.view = None

    def __call__(self, view):
        self.view = view
        return np.zeros((view.height, view.width, 3), dtype=np.uint8)


def _camera_position(view) -> list[float]:
    """MuJoCo's free camera stands ``distance`` behind ``lookat``, seen along azimuth and elevation."""
    azimuth, elevation = math.radians(view.azimuth_deg), math.radians(view.elevation_deg)
    forward = (
        math.cos(elevation) * math.cos(azimuth),
        math.cos(elevation) * math.sin(azimuth),
        math.sin(elevation),
    )
    return [p - view.distance * f for p, f in zip(view.lookat, forward, strict=True)]


def _render(make_env, make_cfg, **viewer):
    cfg = make_cfg()
    cfg.viewer.eye, cfg.viewer.lookat, cfg.viewer.resolution = (1.0, -2.0, 1.5), (0.2, 0.1, 0.4), (64, 48)
    for name, value in viewer.items():
        setattr(cfg.viewer, name, value)
    env = make_env(lambda c: ManagerBasedRLEnv(c, render_mode="rgb_array"), cfg)
    env.reset()
    env.sim.render = _Frames()
    return env, env.render()


def test_the_camera_stands_at_the_viewers_eye(make_env, make_cfg):
    env, frame = _render(make_env, make_cfg, env_index=2)
    view = env.sim.render.view
    assert frame.shape == (48, 64, 3)
    assert view.env_ids == (2,)
    assert view.lookat == pytest.approx((0.2, 0.1, 0.4))
    assert _camera_position(view) == pytest.approx([1.0, -2.0, 1.5])


@pytest.mark.parametrize(
    ("viewer", "origin"),
    [
        ({"origin_type": "asset_root", "asset_name": "ball"}, (2.0, 0.0, 1.0)),
        (
            {"origin_type": "asset_body", "asset_name": "robot", "body_name": "lower"},
            (0.4 * math.cos(0.3), 0.0, 0.5 - 0.4 * math.sin(0.3)),
        ),
    ],
)
def test_the_camera_follows_what_the_viewer_names(make_env, make_cfg, viewer, origin):
    env, _ = _render(make_env, make_cfg, **viewer)
    expected = [o + e for o, e in zip(origin, (1.0, -2.0, 1.5), strict=True)]
    assert _camera_position(env.sim.render.view) == pytest.approx(expected, abs=1e-5)


def test_goals_of_visible_commands_are_marked(make_env, make_cfg):
    cfg = make_cfg()
    cfg.commands = {
        "goal": mdp.UniformPoseCommandCfg(
            asset_name="robot",
            body_name="lower",
            resampling_time_range=(9.0, 9.0),
            debug_vis=True,
            ranges=mdp.UniformPoseCommandCfg.Ranges(
                pos_x=(0.1, 0.1), pos_y=(0.2, 0.2), pos_z=(0.3, 0.3), roll=(0, 0), pitch=(0, 0), yaw=(0, 0)
            ),
        )
    }
    env = make_env(lambda c: ManagerBasedRLEnv(c, render_mode="rgb_array"), cfg)
    env.reset()
    env.sim.render = _Frames()
    env.render()
    goal, body = env.sim.render.view.markers
    # the base of the arm stands at 0.5 m
    assert goal.positions[0] == pytest.approx([0.1, 0.2, 0.8], abs=1e-6)
    assert len(goal.positions) == len(body.positions) == 1


@pytest.mark.parametrize(
    ("viewer", "message"),
    [
        ({"env_index": 3}, "env_index 3"),
        ({"origin_type": "asset_root", "asset_name": "bal"}, "'ball'"),
        ({"origin_type": "asset_body", "asset_name": "robot", "body_name": "lowr"}, "'lower'"),
        ({"origin_type": "asset"}, "asset_root"),
        ({"eye": (0.2, 0.1, 0.4)}, "same point"),
    ],
)
def test_a_view_of_nothing_is_an_error(make_env, make_cfg, viewer, message):
    with pytest.raises(ConfigError, match=message):
        _render(make_env, make_cfg, **viewer)


def test_recorders_see_actions_before_and_states_after_each_step(make_env, base_cfg, tmp_path):
    recorders = mdp.ActionStateRecorderManagerCfg(dataset_export_dir_path=str(tmp_path))
    recorders.record_pre_step_flat_policy_observations = None
    env = make_env(ManagerBasedEnv, base_cfg(recorders=recorders))
    env.reset()
    for step in range(2):
        env.step(torch.full((3, 2), float(step)))
    joints = env.scene["robot"].data.joint_pos[1]
    episode = env.recorder_manager.get_episode(1).data
    torch.testing.assert_close(torch.stack(list(episode["actions"])), torch.tensor([[0.0, 0.0], [1.0, 1.0]]))
    recorded = episode["states"]["articulation"]["robot"]["joint_position"]
    torch.testing.assert_close(recorded[-1], joints)
    initial = episode["initial_state"]["articulation"]["robot"]["joint_position"]
    torch.testing.assert_close(initial[0], env.scene["robot"].data.default_joint_pos[1])
    processed = torch.stack(list(episode["processed_actions"]))
    torch.testing.assert_close(processed[1], 0.5 + env.scene["robot"].data.default_joint_pos[1])


def test_the_default_selection_of_a_term_is_the_robot(make_env, base_cfg):
    env = make_env(ManagerBasedEnv, base_cfg())
    assert mdp.joint_pos(env).shape == (3, 2)
    assert mdp.root_pos_w(env, asset_cfg=SceneEntityCfg("ball")).tolist() == [[2.0, 0.0, 1.0]] * 3

"""What the settings of a reinforcement learning environment make, and which of them are refused or noted."""

import gymnasium as gym
import numpy as np
import pytest
import torch
from env_parts import group_of

import lift_lab.envs.mdp as mdp
from lift_lab.envs import ManagerBasedRLEnv
from lift_lab.envs.frame_capture import update_markers
from lift_lab.managers import EventTermCfg, ObservationTermCfg, RewardTermCfg, SceneEntityCfg
from lift_lab.markers import VisualizationMarkers
from lift_lab.sim.ignored import pending_ignored
from lift_lab.utils.errors import ConfigError


def test_spaces_follow_the_groups_and_their_terms(make_env):
    observations = group_of(
        joints=ObservationTermCfg(func=mdp.joint_pos, clip=(-2.0, 3.0)),
        actions=ObservationTermCfg(func=mdp.last_action),
    )
    observations["critic"] = observations["policy"].copy()
    observations["policy"].concatenate_terms = False
    env = make_env(observations=observations)
    policy, critic = env.single_observation_space["policy"], env.single_observation_space["critic"]
    assert policy["joints"] == gym.spaces.Box(-2.0, 3.0, (2,))
    assert policy["actions"] == gym.spaces.Box(-np.inf, np.inf, (2,))
    assert critic.shape == (4,)
    assert env.single_action_space.shape == (2,)
    assert env.observation_space["critic"].shape == (3, 4)
    assert env.action_space.shape == (3, 2)
    obs, _ = env.reset()
    assert obs["policy"]["joints"].shape == (3, 2)


def test_gymnasium_makes_the_environment_from_an_entry_point(make_cfg):
    name = "Test-Arm-v0"
    gym.register(id=name, entry_point="lift_lab.envs:ManagerBasedRLEnv", disable_env_checker=True)
    try:
        env = gym.make(name, cfg=make_cfg())
        assert isinstance(env.unwrapped, ManagerBasedRLEnv)
        assert env.unwrapped.metadata["render_fps"] == pytest.approx(50.0)
        env.reset(seed=1)
        obs, reward, terminated, truncated, _ = env.step(torch.zeros(3, 2))
        assert obs["policy"].shape[0] == reward.shape[0] == terminated.shape[0] == truncated.shape[0] == 3
        assert env.render() is None
        env.close()
    finally:
        gym.registry.pop(name)


def test_missing_values_are_listed_by_path(make_cfg):
    cfg = make_cfg()
    cfg.decimation = type(cfg)().__class__.__dataclass_fields__["decimation"].default
    cfg.scene.env_spacing = cfg.decimation
    with pytest.raises(TypeError, match=r"(?s)decimation.*scene\.env_spacing"):
        ManagerBasedRLEnv(cfg)


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("decimation", 0, "env.decimation is 0; it must be at least 1"),
        ("episode_length_s", 0.0, "env.episode_length_s is 0; it must be finite and above 0"),
        ("actions", {}, "env.actions has no term"),
        ("observations", {}, "env.observations has no group"),
        ("observations", group_of(), "env.observations.policy has no term"),
    ],
)
def test_a_setting_that_cannot_work_is_an_error(make_cfg, field, value, message):
    with pytest.raises(ConfigError, match=message):
        ManagerBasedRLEnv(make_cfg(**{field: value}))


@pytest.mark.parametrize("cfg", [5, "Cartpole", {"decimation": 2}])
def test_what_is_no_config_is_an_error(cfg):
    with pytest.raises(TypeError, match=f"cfg has to be a ManagerBasedEnvCfg, not a {type(cfg).__name__}"):
        ManagerBasedRLEnv(cfg)


def test_a_task_may_check_itself(make_cfg):
    cfg = make_cfg()

    class Checked(type(cfg)):
        def validate(self):
            raise ConfigError("too slow")

    cfg.__class__ = Checked
    with pytest.raises(ConfigError, match="too slow"):
        ManagerBasedRLEnv(cfg)


def push(env, env_ids):
    pass


@pytest.mark.parametrize(("mode", "message"), [("rest", "did you mean 'reset'"), ("crash", "choose one of")])
def test_a_mode_of_events_that_nothing_applies_is_an_error(make_cfg, mode, message):
    cfg = make_cfg(events={"push": EventTermCfg(func=push, mode=mode)})
    with pytest.raises(ConfigError, match=f"env.events.push.mode is '{mode}', which nothing applies; {message}"):
        ManagerBasedRLEnv(cfg)


@pytest.mark.parametrize("modes", [("reset", "crash"), None])
def test_an_environment_class_names_modes_of_its_own(make_cfg, modes):
    class Own(ManagerBasedRLEnv):
        event_modes = modes

    env = Own(make_cfg(events={"push": EventTermCfg(func=push, mode="crash")}))
    env.close()


def test_more_environments_than_memory_are_refused_before_they_are_made(make_cfg):
    cfg = make_cfg()
    cfg.scene.num_envs = 10**13
    with pytest.raises(ConfigError, match=r"scene.num_envs is 10000000000000: that needs at least .* fit"):
        ManagerBasedRLEnv(cfg)


def test_an_unknown_render_mode_is_an_error(make_cfg):
    with pytest.raises(ConfigError, match="rgb_array"):
        ManagerBasedRLEnv(make_cfg(), render_mode="rgb")


@pytest.mark.parametrize(
    ("fields", "feature"),
    [
        ({"observations": group_of(image=ObservationTermCfg(func=mdp.image))}, "mdp.image needs images"),
        (
            {"rewards": {}, "events": {"e": EventTermCfg(func=mdp.randomize_rigid_body_scale, mode="prestartup")}},
            "one model",
        ),
        (
            {
                "events": {
                    "e": EventTermCfg(func=mdp.reset_root_state_from_terrain, mode="reset", params={"pose_range": {}})
                }
            },
            "terrain",
        ),
    ],
)
def test_a_term_of_a_missing_feature_names_the_feature(make_cfg, fields, feature):
    cfg = make_cfg(**fields)

    def run():
        ManagerBasedRLEnv(cfg).reset()

    with pytest.raises(ConfigError, match=feature):
        run()


def test_settings_without_effect_are_noted(make_env, monkeypatch):
    from lift_lab.sim import ignored

    monkeypatch.setattr(ignored, "_reported", set())
    noted = {}
    monkeypatch.setattr("lift_lab.envs.manager_based_env.report_ignored", lambda: noted.update(pending_ignored()))
    make_env(num_rerenders_on_reset=2, wait_for_textures=False)
    assert {"num_rerenders_on_reset", "wait_for_textures"} <= set(noted)
    assert "xr" not in noted


def test_closing_twice_is_closing_once(make_cfg):
    env = ManagerBasedRLEnv(make_cfg())
    env.reset()
    env.close()
    env.close()


def test_a_failed_construction_leaves_no_simulation_behind(make_cfg):
    from lift_lab.sim import SimulationContext

    bad = RewardTermCfg(func=mdp.joint_vel_l2, weight=1.0, params={"asset_cfg": SceneEntityCfg("robto")})
    with pytest.raises(ConfigError, match="robot"):
        ManagerBasedRLEnv(make_cfg(rewards={"bad": bad}))
    assert SimulationContext.instance() is None


def test_printing_shows_every_manager(make_env):
    text = str(make_env())
    for manager in ("Event", "Recorder", "Action", "Observation", "Command", "Termination", "Reward", "Curriculum"):
        assert f"{manager}Manager" in text


def test_each_of_two_environments_has_its_own_markers(make_env):
    cfgs = {"goal": mdp.UniformPoseCommandCfg(asset_name="robot", body_name="lower", resampling_time_range=(1.0, 1.0),
            debug_vis=True, ranges=mdp.UniformPoseCommandCfg.Ranges(pos_x=(0, 1), pos_y=(0, 1), pos_z=(0, 1),
            roll=(0, 0), pitch=(0, 0), yaw=(0, 0)))}  # fmt: skip
    first, second = make_env(commands=cfgs), make_env(commands=cfgs)
    for env in (first, second):
        env.reset()
    update_markers(first)
    assert len(VisualizationMarkers.of(first.sim)) == 2
    assert VisualizationMarkers.of(second.sim) == []
    second.close()
    update_markers(first)

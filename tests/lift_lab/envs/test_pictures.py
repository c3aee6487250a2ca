"""Pictures of a user's own task: bright, with the robot in the middle and of a good size."""

import gymnasium as gym
import mujoco
import numpy as np
import pytest
import torch
from pxr import Usd

import lift_lab.envs.mdp as mdp
import lift_lab.sim as sim_utils
from lift_lab.assets import ArticulationCfg, AssetBaseCfg
from lift_lab.drawing.opengl import DrawError, open_context
from lift_lab.envs import ManagerBasedRLEnv
from lift_lab.envs.frame_capture import FrameCapture, render_view
from lift_lab.scene import InteractiveSceneCfg
from lift_lab.utils import MISSING, configclass
from lift_lab_assets import CARTPOLE_CFG, FRANKA_PANDA_CFG

MEAN, SHARE = 100.0, 0.4
"""Least mean brightness of a frame of 255, and least share of its height that the robot takes up."""


@pytest.fixture(scope="module", autouse=True)
def opengl():
    """An OpenGL library."""
    try:
        open_context(8, 8).free()
    except DrawError as error:
        pytest.skip(str(error))


@configclass
class OwnSceneCfg(InteractiveSceneCfg):
    robot: ArticulationCfg = MISSING


def own_task(
    make_cfg, robot=FRANKA_PANDA_CFG, joints=("panda_joint.*",), ground=100.0, physics="native", light=None, **viewer
):
    """A robot, on a ground of some size or None, without a light; the viewer at its defaults unless told."""
    cfg = make_cfg(physics=physics, num_envs=4)
    cfg.scene = OwnSceneCfg(num_envs=4, env_spacing=2.5, robot=robot.replace(prim_path="{ENV_REGEX_NS}/Robot"))
    cfg.observations.policy.elbow = None
    cfg.actions.joints = mdp.JointPositionActionCfg(asset_name="robot", joint_names=list(joints))
    if ground is not None:
        spawn = sim_utils.GroundPlaneCfg(size=(ground, ground))
        cfg.scene.ground = AssetBaseCfg(prim_path="/World/ground", spawn=spawn)
    if light is not None:
        cfg.scene.light = AssetBaseCfg(prim_path="/World/light", spawn=light)
    cfg.viewer.resolution = (320, 180)
    for name, value in viewer.items():
        setattr(cfg.viewer, name, value)
    return cfg


@pytest.fixture
def shown(make_env, make_cfg):
    """A started environment, its frame, and which pixels show a robot."""

    def show(**settings):
        cfg = own_task(make_cfg, **settings)
        env = make_env(lambda c: ManagerBasedRLEnv(c, render_mode="rgb_array"), cfg)
        env.reset()
        frame = env.render()
        model = env.sim.model
        robot = model.geom_type != int(mujoco.mjtGeom.mjGEOM_PLANE)
        model.geom_matid[robot], model.geom_rgba[robot, :3] = -1, (1.0, 0.0, 0.0)
        painted = env.render().astype(int)
        return env, frame, painted[..., 0] > 1.5 * painted[..., 1:].max(axis=2)

    return show


@pytest.mark.parametrize("ground", [100.0, None])
def test_a_task_without_a_light_is_bright_and_its_robot_fills_the_frame(shown, ground):
    _, frame, robot = shown(ground=ground)
    assert frame.shape == (180, 320, 3)
    assert frame.mean() > MEAN
    rows, columns = np.nonzero(robot)
    assert np.ptp(rows) + 1 > SHARE * 180
    assert rows.min() > 5
    assert rows.max() < 174
    assert abs((columns.min() + columns.max()) / 2 - 160) < 40


@pytest.mark.parametrize("physics", ["native", "warp"])
def test_a_wide_robot_fills_the_width_of_the_frame(shown, physics):
    _, frame, robot = shown(physics=physics, robot=CARTPOLE_CFG, joints=["slider_to_cart"])
    assert frame.mean() > MEAN
    columns = np.nonzero(robot)[1]
    assert np.ptp(columns) + 1 > SHARE * 320
    assert 5 < columns.min() < columns.max() < 315


def test_the_size_of_the_ground_does_not_move_the_camera(shown):
    small, large = (np.nonzero(shown(ground=size)[2])[0] for size in (4.0, 1000.0))
    assert (small.min(), small.max()) == (large.min(), large.max())


def test_several_environments_are_all_in_the_frame(shown):
    _, frame, robots = shown(num_envs=4)
    assert frame.mean() > MEAN
    columns = np.nonzero(robots)[1]
    assert np.ptp(columns) + 1 > 0.5 * 320
    for edge in (robots[0], robots[-1], robots[:, 0], robots[:, -1]):
        assert not edge.any()


def test_a_camera_that_the_user_set_is_kept(make_env, make_cfg):
    for viewer in ({"eye": (3.0, 1.0, 2.0)}, {"lookat": (0.0, 0.0, 0.5)}):
        env = make_env(ManagerBasedRLEnv, own_task(make_cfg, **viewer))
        env.reset()
        eye, lookat = env.cfg.viewer.eye, env.cfg.viewer.lookat
        view = render_view(env, FrameCapture(env))
        assert view.lookat == pytest.approx(tuple(lookat))
        assert view.distance == pytest.approx(float(np.linalg.norm(np.subtract(eye, lookat))))
        env.close()


def test_the_camera_stays_where_it_is_while_a_fixed_robot_moves(make_env, make_cfg):
    env = make_env(ManagerBasedRLEnv, own_task(make_cfg))
    env.reset()
    capture = FrameCapture(env)
    before = render_view(env, capture)
    for _ in range(5):
        env.step(torch.ones(4, 7))
    after = render_view(env, capture)
    assert (after.lookat, after.distance) == (before.lookat, before.distance)


def test_the_camera_goes_along_with_a_robot_whose_base_is_free(make_env, make_cfg, arm_file, tmp_path):
    stage = Usd.Stage.Open(str(arm_file))
    stage.RemovePrim("/Arm/root_joint")
    stage.Export(str(tmp_path / "free.usda"))
    cfg = make_cfg()
    cfg.scene.robot.spawn = sim_utils.UsdFileCfg(usd_path=str(tmp_path / "free.usda"))
    env = make_env(ManagerBasedRLEnv, cfg)
    env.reset()
    capture = FrameCapture(env)
    before = render_view(env, capture)
    pose = env.scene["robot"].data.root_state_w[:, :7].clone()
    env.scene["robot"].write_root_pose_to_sim(pose + torch.tensor([2.0, -1.0, 0.5, 0.0, 0.0, 0.0, 0.0]))
    after = render_view(env, capture)
    assert np.subtract(after.lookat, before.lookat) == pytest.approx([2.0, -1.0, 0.5], abs=1e-4)
    assert after.distance == before.distance


def test_a_dome_light_is_the_only_light_of_its_scene(shown):
    env, frame, _ = shown(light=sim_utils.DomeLightCfg(color=(0.8, 0.8, 0.8)))
    assert env.sim.model.nlight == 1
    assert frame.mean() > MEAN


def test_gymnasiums_video_wrapper_films_a_task(make_env, make_cfg, tmp_path):
    pytest.importorskip("moviepy")
    env = make_env(lambda c: ManagerBasedRLEnv(c, render_mode="rgb_array"), own_task(make_cfg))
    filmed = gym.wrappers.RecordVideo(env, str(tmp_path), step_trigger=lambda step: step == 0, video_length=3)
    filmed.reset()
    for _ in range(4):
        filmed.step(torch.zeros(4, 7))
    filmed.close()
    assert [path.suffix for path in tmp_path.iterdir()] == [".mp4"]

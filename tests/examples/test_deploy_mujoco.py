"""The deployment example: plain MuJoCo, driven by the exported files alone, does what the environment does."""

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
import torch

import lift_lab_tasks  # noqa: F401
from lift_lab_assets.files import PRETRAINED_DIR
from lift_lab_rl.rsl_rl import LiftLabRunner, RslRlVecEnvWrapper, export_policy_as_onnx, to_rsl_rl
from lift_lab_tasks.settings import Settings

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "deploy_mujoco.py"
TASK, EPISODES = "Lift-Cube-Franka-CL", 20
WITHOUT_US = """
import runpy, sys
for name in ("torch", "lift_lab", "lift_lab_rl", "lift_lab_tasks", "lift_lab_assets", "onnx"):
    sys.modules[name] = None  # to import it is an ImportError
sys.argv = sys.argv[1:]
runpy.run_path(sys.argv[0], run_name="__main__")
"""


@pytest.fixture(scope="module")
def lift():
    """The environment and a runner with the policy that ships."""
    settings = Settings(TASK, "rsl_rl_cfg_entry_point", ["env.sim.device=cpu", "env.seed=11"])
    settings.resolve(num_envs=4)
    made = gym.make(TASK, cfg=settings.env)
    env = RslRlVecEnvWrapper(made)
    runner = LiftLabRunner(env, to_rsl_rl(settings.agent, env.get_observations().keys()), device="cpu")
    runner.load_policy(str(PRETRAINED_DIR / TASK / "policy.pt"))
    yield env, runner
    made.close()


@pytest.fixture(scope="module")
def exported(lift, tmp_path_factory):
    """Folder with the policy and the scene, as play writes them."""
    env, runner = lift
    folder = tmp_path_factory.mktemp("exported")
    metadata = runner.policy_metadata(PRETRAINED_DIR / TASK / "policy.pt")
    export_policy_as_onnx(runner.alg.get_policy(), folder, metadata=metadata)
    env.unwrapped.sim.export_mjcf(folder / "scene.xml")
    return folder


@pytest.fixture(scope="module")
def example():
    pytest.importorskip("onnxruntime")
    spec = importlib.util.spec_from_file_location("deploy_mujoco", EXAMPLE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_it_succeeds_as_often_as_in_the_environment_without_torch_and_lift_lab(exported, example):
    card = json.loads((PRETRAINED_DIR / TASK / "card.json").read_text())
    own = card["evaluation"]["success_rate"]["1000"]
    environ = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    command = [sys.executable, "-c", WITHOUT_US, str(EXAMPLE), str(exported), "--episodes", str(EPISODES)]
    done = subprocess.run(command, env=environ, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    first = done.stdout.splitlines()[0]
    successes, episodes = (int(word) for word in first.removeprefix("success: ").split(" of "))
    assert episodes == EPISODES
    assert successes >= 19
    assert successes >= own * EPISODES - 1


def test_it_observes_and_moves_as_the_environment_does(lift, exported, example):
    env, runner = lift
    policy = example.Policy(exported / "policy.onnx")
    robot = example.Robot(exported / "scene.xml", policy)
    network = runner.get_inference_policy(device="cpu")
    obs, _ = env.reset()
    inner = env.unwrapped
    command = inner.command_manager.get_command("object_pose")[0].numpy().astype(float)
    robot.reset({"object_pose": command})
    cube = robot.data.joint(robot.model.body(policy.meta["assets"]["object"]["root_body"]).jntadr[0])
    cube.qpos[:3] = inner.scene["object"].data.root_pos_w[0] - inner.scene.env_origins[0]
    with torch.inference_mode():
        for _ in range(30):  # until the cube is grasped: contacts let the smallest differences grow
            seen = robot.observe()
            np.testing.assert_allclose(seen, obs["policy"][0].numpy(), atol=1e-4)
            actions = network(obs)
            np.testing.assert_allclose(policy(obs["policy"][0].numpy()), actions[0].numpy(), atol=1e-4)
            obs, *_ = env.step(actions)
            robot.step(actions[0].numpy().astype(float))


def test_the_page_shows_the_script():
    page = (EXAMPLE.parents[1] / "docs" / "deploy.md").read_text()
    assert f"```python\n{EXAMPLE.read_text()}```\n" in page


def test_it_names_what_it_does_not_know(exported, example):
    policy = example.Policy(exported / "policy.onnx")
    robot = example.Robot(exported / "scene.xml", policy)
    robot.reset({"object_pose": np.zeros(7)})
    robot.meta = json.loads(json.dumps(robot.meta))
    robot.meta["observations"][0]["function"] = "joint_effort"
    with pytest.raises(SystemExit, match="add the observation 'joint_effort'"):
        robot.observe()
    robot.meta["actions"][0]["class"] = "joint_velocity_action"
    with pytest.raises(SystemExit, match="add the action 'joint_velocity_action'"):
        robot.step(np.zeros(8))


def test_it_ends_with_one_line_where_files_are_missing_or_damaged(exported, example, tmp_path, monkeypatch):
    network, scene = tmp_path / "policy.onnx", tmp_path / "scene.xml"
    monkeypatch.setattr(sys, "argv", ["deploy_mujoco.py", str(tmp_path), "--episodes", "1"])
    with pytest.raises(SystemExit, match=r"policy\.onnx cannot be read: .*No such file"):
        example.main()
    network.write_bytes((exported / "policy.onnx").read_bytes()[:20000])
    with pytest.raises(SystemExit, match=r"policy\.onnx cannot be read: "):
        example.main()
    network.write_bytes((exported / "policy.onnx").read_bytes())
    with pytest.raises(SystemExit, match=r"scene\.xml cannot be read: "):
        example.main()
    scene.write_text("<mujoco")
    with pytest.raises(SystemExit, match=r"scene\.xml cannot be read: "):
        example.main()


@pytest.mark.parametrize("changes", [{"commands": "[]"}, {"assets": '{"robot": {}}'}], ids=["command", "object"])
def test_it_ends_with_one_line_for_other_tasks(exported, example, tmp_path, monkeypatch, changes):
    onnx = pytest.importorskip("onnx")
    model = onnx.load(exported / "policy.onnx")
    for entry in model.metadata_props:
        entry.value = {**changes, "task": "My-Task"}.get(entry.key, entry.value)
    onnx.save(model, tmp_path / "policy.onnx")
    monkeypatch.setattr(sys, "argv", ["deploy_mujoco.py", str(tmp_path)])
    with pytest.raises(SystemExit, match="'My-Task' is no lift task"):
        example.main()


@pytest.mark.parametrize("episodes", ["0", "-2"])
def test_it_refuses_less_than_one_episode(example, tmp_path, monkeypatch, capsys, episodes):
    monkeypatch.setattr(sys, "argv", ["deploy_mujoco.py", str(tmp_path), "--episodes", episodes])
    with pytest.raises(SystemExit):
        example.main()
    assert f"--episodes must be at least 1, got {episodes}" in capsys.readouterr().err

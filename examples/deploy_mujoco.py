"""Run an exported lift policy in plain MuJoCo. Needs numpy, mujoco and onnxruntime; neither torch nor lift_lab.

    python deploy_mujoco.py FOLDER [--episodes 20] [--seed 0]

FOLDER holds policy.onnx and scene.xml, as `play` writes them. Everything about observations and actions is read from
the metadata of policy.onnx.
"""

import argparse
import json
from pathlib import Path

import mujoco
import numpy as np
import onnxruntime

SUCCESS_M = 0.02  # the task's own measure: the cube came this near to its goal
CUBE_RANGE_M = ((-0.1, 0.1), (-0.25, 0.25))  # where the task puts the cube, about its initial position


def bounds(pairs):
    """Lower and upper bounds of pairs, in which None is no bound."""
    low, high = zip(*pairs, strict=True)
    return [-np.inf if x is None else x for x in low], [np.inf if x is None else x for x in high]


class Policy:
    """A network and what its file says about it."""

    def __init__(self, path):
        try:
            self.session = onnxruntime.InferenceSession(path.read_bytes(), providers=["CPUExecutionProvider"])
        except Exception as error:  # the classes of onnxruntime's errors have no common base of their own
            raise SystemExit(f"{path} cannot be read: {error}") from None
        texts = self.session.get_modelmeta().custom_metadata_map
        if texts.get("format") != "1":
            raise SystemExit(f"{path}: no metadata of format 1; export the policy with this version of lift_lab")
        self.meta = {key: json.loads(texts[key]) for key in ("observations", "actions", "commands", "assets")}
        self.meta |= {key: float(texts[key]) for key in ("step_dt", "physics_dt", "episode_length_s")}
        self.task, self.decimation = texts["task"], int(texts["decimation"])
        limit = json.loads(texts["clip_actions"])
        self.limit = np.inf if limit is None else limit
        self.reset()

    def reset(self):
        """Forget: the inputs besides `obs` are what a recurrent policy remembers."""
        self.memory = {i.name: np.zeros(i.shape, np.float32) for i in self.session.get_inputs() if i.name != "obs"}

    def __call__(self, obs):
        """The action, shape (action size,), of an observation, shape (observation size,)."""
        action, *memory = self.session.run(None, {"obs": obs[None].astype(np.float32), **self.memory})
        self.memory = dict(zip(self.memory, memory, strict=True))
        return np.clip(action[0], -self.limit, self.limit)


class Robot:
    """The scene in MuJoCo, read and driven as the metadata says. On a real robot this class talks to the hardware."""

    def __init__(self, path, policy):
        try:
            self.model = mujoco.MjModel.from_xml_path(str(path))
        except ValueError as error:
            raise SystemExit(f"{path} cannot be read: {error}") from None
        self.data = mujoco.MjData(self.model)
        self.meta, self.decimation = policy.meta, policy.decimation
        self.histories = {}
        if not np.isclose(self.model.opt.timestep, self.meta["physics_dt"]):
            raise SystemExit(f"{path} is of another task: its time step is {self.model.opt.timestep}")
        drives = [group for asset in self.meta["assets"].values() for group in asset.get("actuators", {}).values()]
        if not all(group["is_implicit"] for group in drives):
            raise SystemExit("the actuators follow laws of their own: compute their efforts before each mj_step")

        if any(term.get("min_close_time_s") for term in self.meta["actions"]):
            raise SystemExit("the gripper stays closed for a while: add that to step()")

    def reset(self, command):
        """The initial state, and what the policy is asked for."""
        mujoco.mj_resetDataKeyframe(self.model, self.data, self.model.key("initial").id)
        self.action = np.zeros(sum(term["size"] for term in self.meta["actions"]))
        self.command = command
        self.histories = {}

    # -- what the policy reads

    def body_pose(self, asset):
        """Position in m and rotation matrix of an asset's root."""
        body = self.data.body(self.meta["assets"][asset]["root_body"])
        return body.xpos.copy(), body.xmat.reshape(3, 3)

    def joint(self, term):
        """Positions and velocities of a term's joints, less their defaults."""
        name = term["params"]["asset_cfg"]["name"]
        defaults = self.meta["assets"][name]
        joints = [self.data.joint(f"{name}/{joint}") for joint in term["joint_names"]]
        ids = [defaults["joint_names"].index(joint) for joint in term["joint_names"]]
        position = np.array([joint.qpos[0] for joint in joints]) - np.take(defaults["default_joint_pos"], ids)
        velocity = np.array([joint.qvel[0] for joint in joints]) - np.take(defaults["default_joint_vel"], ids)
        return position, velocity

    def object_in_robot(self, term):
        """Position of the object in the robot's root frame in m."""
        (robot, axes), (cube, _) = (self.body_pose(term["params"][key]["name"]) for key in ("robot_cfg", "object_cfg"))
        return axes.T @ (cube - robot)

    TERMS = {
        "joint_pos_rel": lambda self, term: self.joint(term)[0],
        "joint_vel_rel": lambda self, term: self.joint(term)[1],
        "object_position_in_robot_root_frame": object_in_robot,
        "generated_commands": lambda self, term: self.command[term["params"]["command_name"]],
        "last_action": lambda self, term: self.action,
    }

    def observe(self):
        """The policy's input: each term clipped, scaled, and with its history, in the order of the metadata."""
        mujoco.mj_kinematics(self.model, self.data)
        values = []
        for term in self.meta["observations"]:
            if term["function"] not in self.TERMS or term["modifiers"]:
                raise SystemExit(f"add the observation '{term['function']}' to TERMS, with its modifiers")
            value = np.asarray(self.TERMS[term["function"]](self, term), dtype=float)
            if term["clip"] is not None:
                value = np.clip(value, *bounds([term["clip"]]))
            value = value * (1.0 if term["scale"] is None else np.array(term["scale"]))
            if term["history_length"] > 0:  # oldest first; at the start filled with the first value
                past = self.histories.get(term["name"], [value] * term["history_length"])
                self.histories[term["name"]] = past = [*past[1:], value]
                value = np.concatenate(past)
            values.append(value)
        return np.concatenate(values)

    # -- what the policy drives

    def step(self, action):
        """Apply an action for one control step."""
        self.action = action
        for term in self.meta["actions"]:
            raw = action[term["start"] : term["start"] + term["size"]]
            if term["class"] == "joint_position_action":
                target = raw * np.array(term["scale"]) + np.array(term["offset"])
                if term["clip"] is not None:
                    target = np.clip(target, *bounds(term["clip"]))
            elif term["class"] == "binary_joint_position_action":
                target = term["close_command"] if raw[0] < 0 else term["open_command"]
            else:
                raise SystemExit(f"add the action '{term['class']}'")
            for joint, value in zip(term["joint_names"], target, strict=True):
                self.data.actuator(f"{term['asset']}/{joint}").ctrl = value
        mujoco.mj_step(self.model, self.data, self.decimation)


def run_episode(policy, robot, rng):
    """Bring the cube to a random goal. Returns the smallest and the last distance to it in m."""
    (command,) = policy.meta["commands"]
    ranges = command["ranges"]
    goal = np.array([rng.uniform(*ranges[axis]) for axis in ("pos_x", "pos_y", "pos_z")])
    robot.reset({command["name"]: np.array([*goal, 1.0, 0.0, 0.0, 0.0])})  # a position and a quaternion (w, x, y, z)
    cube = robot.data.joint(robot.model.body(policy.meta["assets"]["object"]["root_body"]).jntadr[0])
    cube.qpos[:2] += [rng.uniform(*limits) for limits in CUBE_RANGE_M]
    policy.reset()
    distances = []
    for _ in range(round(policy.meta["episode_length_s"] / policy.meta["step_dt"])):
        robot.step(policy(robot.observe()))
        mujoco.mj_kinematics(robot.model, robot.data)
        (root, axes), (position, _) = (robot.body_pose(name) for name in (command["asset_name"], "object"))
        distances.append(np.linalg.norm(position - (root + axes @ goal)))
    return min(distances), distances[-1]


def main():
    parser = argparse.ArgumentParser(description="Run an exported lift policy in plain MuJoCo.")
    parser.add_argument("folder", type=Path, help="folder with policy.onnx and scene.xml")
    parser.add_argument("--episodes", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    if args.episodes < 1:
        parser.error(f"--episodes must be at least 1, got {args.episodes}")
    policy = Policy(args.folder / "policy.onnx")
    if "object" not in policy.meta["assets"] or len(policy.meta["commands"]) != 1:
        raise SystemExit(f"'{policy.task}' is no lift task: write run_episode for it")
    robot = Robot(args.folder / "scene.xml", policy)
    rng = np.random.default_rng(args.seed)
    results = [run_episode(policy, robot, rng) for _ in range(args.episodes)]
    successes = sum(nearest < SUCCESS_M for nearest, _ in results)
    print(f"success: {successes} of {args.episodes}")
    print(f"mean distance at the end: {np.mean([last for _, last in results]):.4f} m")


if __name__ == "__main__":
    main()

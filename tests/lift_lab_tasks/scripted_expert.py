"""A scripted expert for the lift task: differential inverse kinematics and four phases.

It sees the same scene as the policy and acts through the same joint-position and gripper actions. What it cannot do,
contacts and gains make impossible; so it is the check of the physics before any learning.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import torch

from lift_lab.controllers import DifferentialIKController, DifferentialIKControllerCfg

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv

ABOVE, DOWN, CLOSE, CARRY = range(4)
"""Phases: go above the cube, go down, close the gripper, carry the cube to the goal."""


class ScriptedExpert:
    """Picks up the cube and brings it to the goal, in every environment on its own clock."""

    hover_height_m = 0.14
    """Height of the tool above the table in the first phase."""
    grasp_height_m = 0.02
    """Height of the tool above the table when it closes."""
    close_steps = 16
    """Control steps given to the gripper to close."""
    gain = 4.0
    """Joint target ahead of the joint position per unit of IK step: the drive's time constant is 0.4 s."""
    posture_gain = 0.3
    """Pull towards the default posture within the null space of the task: it keeps the elbow out of singularities."""
    max_step_m = 0.10
    """Largest position error handed to the IK."""

    def __init__(self, env: ManagerBasedRLEnv, hand: str = "panda_hand", arm: str = "panda_joint.*"):
        """Find the hand, the arm's joints and the arm's action scale in the environment."""
        self.env = env
        self.robot = env.scene["robot"]
        self.hand = self.robot.find_bodies(hand)[0][0]
        self.arm = self.robot.find_joints(arm)[0]
        self.scale = env.action_manager.get_term("arm_action").cfg.scale
        cfg = DifferentialIKControllerCfg(
            command_type="pose", use_relative_mode=False, ik_method="dls", ik_params={"lambda_val": 0.02}
        )
        self.ik = DifferentialIKController(cfg, env.num_envs, env.device)
        self.down_w = torch.tensor([0.0, 1.0, 0.0, 0.0], device=env.device).repeat(env.num_envs, 1)
        self.phase = torch.zeros(env.num_envs, dtype=torch.long, device=env.device)
        self.since = torch.zeros_like(self.phase)

    def reset(self, env_ids: torch.Tensor) -> None:
        """Start over in some environments."""
        self.phase[env_ids] = ABOVE
        self.since[env_ids] = 0

    def act(self) -> torch.Tensor:
        """Actions for the current state, shape (num_envs, 8)."""
        env, robot = self.env, self.robot
        root_w = robot.data.root_pos_w
        tool = env.scene["ee_frame"].data.target_pos_w[:, 0] - root_w
        tool_quat = env.scene["ee_frame"].data.target_quat_w[:, 0]
        cube = env.scene["object"].data.root_pos_w - root_w
        goal = env.command_manager.get_command("object_pose")[:, :3]

        way = cube.clone()
        way[:, 2] = torch.where(self.phase == ABOVE, self.hover_height_m, self.grasp_height_m)
        way = torch.where((self.phase == CARRY)[:, None], tool + goal - cube, way)
        error = way - tool
        distance = error.norm(dim=1)
        self._advance(distance)

        step = error * (self.max_step_m / distance.clamp(min=self.max_step_m))[:, None]
        self.ik.set_command(torch.cat((tool + step, self.down_w), dim=1))
        joint_pos = robot.data.joint_pos[:, self.arm]
        jacobian = self._jacobian(tool)
        task_step = self.ik.compute(tool, tool_quat, jacobian, joint_pos) - joint_pos
        home = robot.data.default_joint_pos[:, self.arm] - joint_pos
        posture_step = self.posture_gain * _null_space(jacobian, home)
        target = joint_pos + self.gain * (task_step + posture_step).clamp(-0.3, 0.3)
        arm = (target - robot.data.default_joint_pos[:, self.arm]) / self.scale
        gripper = torch.where(self.phase >= CLOSE, -1.0, 1.0)
        return torch.cat((arm, gripper[:, None]), dim=1)

    def _advance(self, distance: torch.Tensor) -> None:
        self.since += 1
        done = (
            ((self.phase == ABOVE) & (distance < 0.03))
            | ((self.phase == DOWN) & (distance < 0.012))
            | ((self.phase == CLOSE) & (self.since > self.close_steps))
        )
        self.phase += done.long()
        self.since[done] = 0

    def _jacobian(self, tool: torch.Tensor) -> torch.Tensor:
        """Jacobian of the tool's frame: the hand's, moved to the tool centre. Shape (num_envs, 6, 7)."""
        jacobian = self.robot.get_jacobians(self.hand)[:, :, self.arm].clone()
        hand = self.robot.data.body_pos_w[:, self.hand] - self.robot.data.root_pos_w
        arm_w = (tool - hand)[:, :, None].expand(-1, -1, jacobian.shape[2])
        jacobian[:, :3] += torch.linalg.cross(jacobian[:, 3:], arm_w, dim=1)
        return jacobian


def _null_space(jacobian: torch.Tensor, step: torch.Tensor) -> torch.Tensor:
    """The part of a joint step, shape (num_envs, 7), that does not move the tool."""
    inverse = torch.linalg.pinv(jacobian)
    return step - (inverse @ (jacobian @ step[:, :, None]))[:, :, 0]

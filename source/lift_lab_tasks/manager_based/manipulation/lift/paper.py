"""The numbers of the paper that the lift tasks reproduce: its text, its Table 1, its figures and its claims.

Rewards are Isaac Lab's log values: sums of an episode divided by its 5 s. All numbers are as printed in sections 4.2 to
4.7; those that the text calls approximate are marked.
"""

from __future__ import annotations

from lift_lab_rl.scalar_names import SUCCESS_RATE
from lift_lab_rl.study.paper import Claim, Figure, Paper, Trials

_FIGURES = (
    Figure(4, "Maximum Episode Length", ("Train/max_episode_length",), "steps", 250.0, 250.0),
    Figure(5, "Mean Episode Length", ("Train/mean_episode_length",), "steps", 249.4554, 249.9277),
    Figure(6, "Minimum Episode Length", ("Train/min_episode_length",), "steps", 48.37, 65.05),
    Figure(7, "Action Rate Penalty", ("Episode_Reward/action_rate",), "", -0.0005, -0.0624),
    Figure(8, "Joint-Velocity Penalty", ("Episode_Reward/joint_vel",), "", -0.0016, -0.7295),
    Figure(9, "Lifting Object Reward", ("Episode_Reward/lifting_object",), "of 15", 12.80, 13.27),
    Figure(10, "Object-Goal Tracking Reward", ("Episode_Reward/object_goal_tracking",), "of 16", 11.60, 12.62),
    Figure(
        11, "Fine-Grained Tracking Reward", ("Episode_Reward/object_goal_tracking_fine_grained",), "of 5", 1.85, 2.69
    ),
    Figure(12, "Reaching Reward", ("Episode_Reward/reaching_object",), "of 1", 0.75, 0.77),
    Figure(13, "Learning Rate", ("Loss/learning_rate",), ""),
    Figure(14, "Entropy Loss", ("Loss/entropy_loss",), "", -0.0003, None),
    Figure(15, "Surrogate Policy Loss", ("Loss/surrogate",), "", -0.0007, -0.0012),
    Figure(16, "Value Function Loss", ("Loss/value",), "", 0.3278, 0.4121),
    Figure(17, "Instantaneous Reward: Maximum", ("Train/max_step_reward",), "", 0.73, 0.73),
    Figure(18, "Instantaneous Reward: Mean", ("Train/mean_step_reward",), "", 0.5410, 0.5720),
    Figure(19, "Instantaneous Reward: Minimum", ("Train/min_step_reward",), "", 0.0, -0.4809),
    Figure(20, "Total Reward: Maximum", ("Train/max_reward",), "", 153.0, 153.0),
    Figure(21, "Total Reward: Mean", ("Train/mean_reward",), "", 134.98, 142.87),
    Figure(22, "Total Reward: Minimum", ("Train/min_reward",), "", 0.83, -10.17),
)
"""Figures 4 to 22. The paper gives 17, 19 (baseline) and 20 as approximate."""

_OBJECT = "Metrics/object_pose"

_FURTHER = (
    Figure(0, "Success Rate", (SUCCESS_RATE,), "of training episodes"),
    Figure(0, "Time to Success", (f"{_OBJECT}/time_to_success_s",), "s", needs_success=True),
    Figure(0, "Squared Action Change", (f"{_OBJECT}/squared_action_change",), "per step", 5.0, 0.624),
    Figure(0, "Mean Squared Joint Acceleration", (f"{_OBJECT}/squared_joint_acceleration",), "(rad/s²)²"),
    Figure(0, "First Pick Dropped", (f"{_OBJECT}/first_pick_drop",), "of training episodes"),
    Figure(0, "Object's Distance at the End", (f"{_OBJECT}/object_position_error",), "m"),
)
"""What the paper measures without a figure, or describes in words.

Its action change follows from Figure 7: the penalty divided by its weight of -1e-4 (baseline) and -1e-1 (curriculum).
"""

_CLAIMS = (
    Claim("higher mean total reward", "Train/mean_reward", 1, "142.87 vs 134.98"),
    Claim("higher lifting reward", "Episode_Reward/lifting_object", 1, "13.27 vs 12.80"),
    Claim("better goal tracking", "Episode_Reward/object_goal_tracking", 1, "12.62 vs 11.60"),
    Claim("better fine tracking", "Episode_Reward/object_goal_tracking_fine_grained", 1, "2.69 vs 1.85"),
    Claim("higher reaching reward", "Episode_Reward/reaching_object", 1, "0.77 vs 0.75"),
    Claim("higher mean instantaneous reward", "Train/mean_step_reward", 1, "0.5720 vs 0.5410"),
    Claim("lower minimum instantaneous reward", "Train/min_step_reward", -1, "-0.4809 vs about 0"),
    Claim("longer shortest episodes", "Train/min_episode_length", 1, "65.05 vs 48.37"),
    Claim("lower minimum total reward", "Train/min_reward", -1, "-10.17 vs 0.83"),
    Claim("higher entropy at the end", "Loss/entropy", 1, "sustained vs declining"),
    Claim("higher value loss", "Loss/value", 1, "0.4121 vs 0.3278"),
    Claim("higher success rate", "evaluation:success_rate", 1, "99 vs 96 of 100"),
    Claim(
        "smoother actions", f"evaluation:{_OBJECT}/squared_action_change", -1, "jitter in 70 to 80 % of trials vs none"
    ),
    Claim("smaller joint accelerations", f"evaluation:{_OBJECT}/squared_joint_acceleration", -1, "stable control"),
    Claim("fewer first-pick drops", f"evaluation:{_OBJECT}/first_pick_drop", -1, "1 in 100 vs occasional"),
)
"""What sections 4.2 to 4.7 claim."""

PAPER = Paper(
    citation="Adaptive Robotic Arm Control: Leveraging Curriculum Learning and Deep Reinforcement Learning for "
    "Efficient Pick-and-Lift Operations Through Simulation (our copy names no authors, year or DOI)",
    baseline_task="Lift-Cube-Franka",
    curriculum_task="Lift-Cube-Franka-CL",
    total_steps=100_000 * 4_096,
    figures=_FIGURES,
    further=_FURTHER,
    table_title="Table 1: success within 0.02 m",
    table=(Trials(10, 10, 10), Trials(50, 48, 50), Trials(100, 96, 99)),
    claims=_CLAIMS,
    success_tags=_FURTHER[0].tags,
)
"""Numbers of the paper that reports compare with ours."""

"""Curricula of the lift task to choose from, e.g. ``env/curriculum=linear``; the step is in joint_pos_env_cfg."""

from __future__ import annotations

from lift_lab.managers import CurriculumTermCfg as CurrTerm
from lift_lab.utils import configclass
from lift_lab_tasks.manager_based.manipulation.lift import mdp

from .joint_pos_env_cfg import ExplorationCfg


@configclass
class LinearCurriculumCfg(ExplorationCfg):
    """The paper's Eq. (1): penalties of motion grow linearly to the step's end value within 10,000 steps.

    The ramp begins at step 5,000, about when the cube is first lifted: penalties that grow before that make dropping
    the cube the cheapest policy.
    """

    action_rate = CurrTerm(
        func=mdp.anneal_reward_weight,
        params={
            "term_name": "action_rate",
            "initial_weight": -1e-4,
            "final_weight": -1e-1,
            "num_steps": 10000,
            "start_step": 5000,
        },
    )
    joint_vel = CurrTerm(
        func=mdp.anneal_reward_weight,
        params={
            "term_name": "joint_vel",
            "initial_weight": -1e-4,
            "final_weight": -1e-1,
            "num_steps": 10000,
            "start_step": 5000,
        },
    )


@configclass
class SuccessCurriculumCfg(ExplorationCfg):
    """Penalties of motion that grow to the step's end value only while most episodes succeed."""

    action_rate = CurrTerm(
        func=mdp.anneal_reward_weight_on_success,
        params={
            "term_name": "action_rate",
            "initial_weight": -1e-4,
            "final_weight": -1e-1,
            "num_steps": 5000,
        },
    )
    joint_vel = CurrTerm(
        func=mdp.anneal_reward_weight_on_success,
        params={
            "term_name": "joint_vel",
            "initial_weight": -1e-4,
            "final_weight": -1e-1,
            "num_steps": 5000,
        },
    )

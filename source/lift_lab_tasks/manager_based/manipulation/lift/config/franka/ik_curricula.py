"""Curricula of the lift tasks in task space: those of the joint-position task, and a reach that is felt from afar."""

from __future__ import annotations

from lift_lab.managers import CurriculumTermCfg as CurrTerm
from lift_lab.utils import configclass
from lift_lab_tasks.manager_based.manipulation.lift import mdp

from . import curricula, joint_pos_env_cfg


def _from_afar() -> CurrTerm:
    return CurrTerm(func=mdp.reach_from_afar, params={"std": 0.3, "num_steps": 3000}, training_only=True)


@configclass
class ExplorationCfg(joint_pos_env_cfg.ExplorationCfg):
    """Exploration aids for actions that move the tool."""

    reach_from_afar = _from_afar()


@configclass
class StepCurriculumCfg(joint_pos_env_cfg.CurriculumCfg):
    """Penalties of motion that jump."""

    reach_from_afar = _from_afar()


@configclass
class LinearCurriculumCfg(curricula.LinearCurriculumCfg):
    """Penalties of motion that grow linearly."""

    reach_from_afar = _from_afar()


@configclass
class SuccessCurriculumCfg(curricula.SuccessCurriculumCfg):
    """Penalties of motion that grow while most episodes succeed."""

    reach_from_afar = _from_afar()

"""Configs of the recorder terms, with Isaac Lab's names."""

from __future__ import annotations

from lift_lab.managers import RecorderManagerBaseCfg, RecorderTermCfg
from lift_lab.utils import configclass

from . import recorders

__all__ = [
    "ActionStateRecorderManagerCfg",
    "InitialStateRecorderCfg",
    "PostStepProcessedActionsRecorderCfg",
    "PostStepStatesRecorderCfg",
    "PreStepActionsRecorderCfg",
    "PreStepFlatPolicyObservationsRecorderCfg",
]


@configclass
class InitialStateRecorderCfg(RecorderTermCfg):
    """Config of :class:`InitialStateRecorder`."""

    class_type: type = recorders.InitialStateRecorder


@configclass
class PostStepStatesRecorderCfg(RecorderTermCfg):
    """Config of :class:`PostStepStatesRecorder`."""

    class_type: type = recorders.PostStepStatesRecorder


@configclass
class PreStepActionsRecorderCfg(RecorderTermCfg):
    """Config of :class:`PreStepActionsRecorder`."""

    class_type: type = recorders.PreStepActionsRecorder


@configclass
class PreStepFlatPolicyObservationsRecorderCfg(RecorderTermCfg):
    """Config of :class:`PreStepFlatPolicyObservationsRecorder`."""

    class_type: type = recorders.PreStepFlatPolicyObservationsRecorder


@configclass
class PostStepProcessedActionsRecorderCfg(RecorderTermCfg):
    """Config of :class:`PostStepProcessedActionsRecorder`."""

    class_type: type = recorders.PostStepProcessedActionsRecorder


@configclass
class ActionStateRecorderManagerCfg(RecorderManagerBaseCfg):
    """Recorders for playing episodes again: initial states, states, actions and observations."""

    record_initial_state = InitialStateRecorderCfg()
    record_post_step_states = PostStepStatesRecorderCfg()
    record_pre_step_actions = PreStepActionsRecorderCfg()
    record_pre_step_flat_policy_observations = PreStepFlatPolicyObservationsRecorderCfg()
    record_post_step_processed_actions = PostStepProcessedActionsRecorderCfg()

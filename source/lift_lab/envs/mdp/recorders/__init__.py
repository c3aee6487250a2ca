"""Recorder terms: states, actions and observations of episodes."""

from .recorders import (
    InitialStateRecorder,
    PostStepProcessedActionsRecorder,
    PostStepStatesRecorder,
    PreStepActionsRecorder,
    PreStepFlatPolicyObservationsRecorder,
)
from .recorders_cfg import (
    ActionStateRecorderManagerCfg,
    InitialStateRecorderCfg,
    PostStepProcessedActionsRecorderCfg,
    PostStepStatesRecorderCfg,
    PreStepActionsRecorderCfg,
    PreStepFlatPolicyObservationsRecorderCfg,
)

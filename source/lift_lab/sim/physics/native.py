"""Physics on the CPU: `mujoco.batch.Batch`, one MuJoCo simulation per environment on a thread pool.

The state is float64 and is kept in the batch's rows. Bound fields are copied to float32 after every call. The result is
the same bit for bit at any number of threads. The warnings that MuJoCo counts are not printed:
:meth:`NativePhysics.health` reports them instead. What MuJoCo prints without counting is throttled, see
:mod:`.engine_warnings`.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
import torch
from mujoco.batch import Batch, SimulationError

from lift_lab.sim.ignored import note_ignored
from lift_lab.utils.errors import ConfigError, PhysicsError

from .base import Health, silence
from .data_fields import (
    FRAME_FIELDS,
    FRAME_MODEL_FIELDS,
    MAX_VALUE,
    MOTION_FIELDS,
    MOTION_MODEL_FIELDS,
    STATE_FIELDS,
    Stage,
    sensor_stages,
)
from .memory import check_fits, native_bytes
from .native_arrays import Frames, Mirror, lossy
from .rows import broadcast_rows, ids_tensor
from .saved_physics import SavedPhysics

if TYPE_CHECKING:
    from lift_lab.sim.simulation_cfg import SimulationCfg

_LOG = logging.getLogger(__name__)

_WARN = mujoco.mjtWarning
_NONFINITE_WARNINGS = [
    int(w)
    for w in (
        _WARN.mjWARN_BADQPOS,
        _WARN.mjWARN_BADQVEL,
        _WARN.mjWARN_BADQACC,
        _WARN.mjWARN_BADCTRL,
        _WARN.mjWARN_INERTIA,
    )
]
_OVERFLOW_WARNINGS = [int(_WARN.mjWARN_CONTACTFULL), int(_WARN.mjWARN_CNSTRFULL)]

_ADVANCED_FIELDS = frozenset({"time", "qpos", "qvel", "act"})
"""State fields that the engine changes; the others change only when written or reset."""

_CLEARLY_HEALTHY = 0.99 * MAX_VALUE
"""Values below this in float32 are below `MAX_VALUE` in float64."""

_ALL = slice(None)


class NativePhysics(SavedPhysics):
    """MuJoCo on a thread pool; see :class:`Physics` for the interface.

    After step(), position-dependent fields and sensors belong to the new state. So do velocity-dependent ones once any
    is bound. Force-dependent ones belong to the last substep until forward(), as after `mj_step`.

    MuJoCo's position stage also finds contacts, which the next step does again. So a second batch without constraints
    computes frames (`xpos`, `site_xmat`, ...) and their motion (`cvel`, `cdof`, ...) while nothing else is bound. The
    bits are the same.

    Args:
        model: the compiled model; copied.
        num_envs: number of environments.
        device: the CPU.
        num_threads: threads, including the caller's; None for every CPU this process may use.
        auto_reset_failed: see :class:`Physics`.

    Raises:
        ConfigError: the device is not the CPU, num_threads is below 1, or the environments do not fit into memory.
    """

    name = "native"

    @classmethod
    def options_of(cls, cfg: SimulationCfg) -> dict[str, Any]:
        for name in ("nconmax", "njmax"):
            if getattr(cfg.mujoco, name) is not None:
                note_ignored(f"sim.mujoco.{name}", "the native engine makes room for contacts as they come")
        return {"num_threads": cfg.num_threads}

    def __init__(
        self,
        model: mujoco.MjModel,
        num_envs: int,
        device: str | torch.device = "cpu",
        num_threads: int | None = None,
        auto_reset_failed: bool = False,
    ):
        device = torch.device(device)
        if device.type != "cpu":
            raise ConfigError(f"native physics runs on device 'cpu', not '{device}'; choose physics 'warp' there")
        if num_threads is None:
            num_threads = _available_cpus()
        if num_threads < 1:
            raise ConfigError(f"num_threads must be at least 1, got {num_threads}")
        check_fits("scene.num_envs", num_envs, native_bytes(model), device)
        super().__init__(model, num_envs, device, auto_reset_failed)
        self._batch = Batch(self.model, num_envs, num_threads)
        self._columns = {name: self._state_columns(name) for name in STATE_FIELDS}
        self._state = {name: self._batch.state[:, columns] for name, columns in self._columns.items()}
        self._dynamic = slice(self._columns["qpos"].start, self._state_columns("qacc_warmstart").stop)
        self._mirrors: dict[str, Mirror] = {}
        self._advanced: list[Mirror] = []  # what a step changes
        self._stage = Stage.NONE  # what a step computes at the new state
        self._frames: Frames | None = Frames(self._batch)  # while the stage is NONE
        self._inertias_differ = False  # between environments
        self._logged_engine_error = False
        # With soft bodies an inertia warning tells of a solve that ended a hair above its tolerance: no failure.
        self._failing = [w for w in _NONFINITE_WARNINGS if not self.model.nflex or w != int(_WARN.mjWARN_INERTIA)]
        self._looked = True  # whether health() was asked since the last step
        self._nonfinite = np.zeros(num_envs, bool)
        self._overflow = np.zeros(num_envs, bool)
        self._failures = False  # whether one of the two holds a True
        self._raised = np.zeros(num_envs, bool)  # where MuJoCo raised since the last look
        self._forces_unchecked = False  # whether accelerations were computed outside of step(), which checks them
        self._unharmed = Health(*(torch.zeros(num_envs, dtype=torch.bool) for _ in range(2)), none_failed=True)
        self._model_of_env: mujoco.MjModel | None = None
        self._model_fields: dict[str, torch.Tensor] = {}
        self._warnings = self._batch.warning[:, :, 1]  # how often each was given
        self._last_ids: tuple[torch.Tensor | None, np.ndarray] = (None, np.zeros(0, int))
        self._silence_warnings(slice(None))

    @property
    def num_threads(self) -> int:
        """Threads that step the environments."""
        return self._batch.nthread

    # -- fields

    def field(self, name: str) -> torch.Tensor:
        mirror = self._mirrors.get(name)
        return mirror.tensor if mirror is not None else self._bind(name).tensor

    @property
    def bound_fields(self) -> tuple[str, ...]:
        return tuple(self._mirrors)

    def _bind(self, name: str) -> Mirror:
        stage = self._field_stage(name)
        column_stages = sensor_stages(self.model) if name == "sensordata" else None
        frames = self._frames
        if name not in FRAME_FIELDS and (name not in MOTION_FIELDS or self._inertias_differ):
            frames = None
        if stage in (Stage.POS, Stage.VEL) and frames is None:
            self._leave_frames_to_the_batch()
            self._stage = max(self._stage, stage)
        if stage == Stage.NONE:
            source = self._state[name]
        else:
            source = self._batch.bind(name) if frames is None else frames.bind(name, stage)
            source = source.reshape(self.num_envs, -1)
        mirror = Mirror(source, self._shape(name), stage, column_stages)
        self._mirrors[name] = mirror
        if stage != Stage.NONE or name in _ADVANCED_FIELDS:
            self._advanced.append(mirror)
        if stage != Stage.NONE:
            self._compute(None, max(column_stages, default=stage) if column_stages is not None else stage)
        with lossy():
            mirror.sync(Stage.ACC)
        return mirror

    def write(
        self,
        name: str,
        values: torch.Tensor | float,
        env_ids: torch.Tensor | Sequence[int] | None = None,
        cols: slice | torch.Tensor | Sequence[int] | None = None,
    ) -> None:
        if name not in self._state:
            self._check_state_field(name)
        target = self._state[name]
        rows = _ALL if env_ids is None else self._numpy_env_ids(env_ids)
        columns = cols if isinstance(cols, slice) else _ALL if cols is None else _numpy_ids(cols)
        shape = _length(rows, target.shape[0]), _length(columns, target.shape[1])
        if not isinstance(rows, slice) and not isinstance(columns, slice):
            rows = rows[:, None]
        if not isinstance(values, torch.Tensor):
            values = torch.as_tensor(values, dtype=torch.float64)
        if values.shape != shape:
            values = broadcast_rows(name, values, *shape)
        source = values.numpy(force=values.requires_grad or not values.is_cpu)
        target[rows, columns] = source
        mirror = self._mirrors.get(name)
        if mirror is not None:
            mirror.write(rows, columns, source)
        self._moved(name, env_ids)
        if name == "qvel" and self._acceleration is not None:
            self._acceleration.numpy()[rows, columns] = 0.0

    # -- dynamics

    def step(self, num_substeps: int = 1) -> None:
        if num_substeps < 1:
            raise ConfigError(f"num_substeps must be at least 1, got {num_substeps}")
        self._looked = False
        self._follow_model()
        if self._acceleration is None:
            self._call(lambda: self._batch.step(nstep=num_substeps, stage=int(self._stage)))
        else:
            self._step_and_compare(num_substeps, self._acceleration.numpy())
        if self._frames is not None:
            self._call(self._frames.follow)
        with lossy():
            for mirror in self._advanced:
                mirror.copy_all()
        self._caught_up(None)
        if self.auto_reset_failed:
            self._reset_failed()

    def _reset_failed(self) -> None:
        """Put the environments that failed in this step into the default state."""
        failed = self._collect_failures()
        self._looked = True
        if failed is not None and failed.any():
            ids = torch.from_numpy(np.flatnonzero(failed))
            self.reset(ids)
            self.refresh(ids)

    def _step_and_compare(self, num_substeps: int, acceleration: np.ndarray) -> None:
        """Step, and see what the last time step did to the velocities."""
        if num_substeps > 1:
            self._call(lambda: self._batch.step(nstep=num_substeps - 1, stage=int(Stage.NONE)))
        before = self._state["qvel"].copy()
        self._call(lambda: self._batch.step(nstep=1, stage=int(self._stage)))
        with lossy(), np.errstate(invalid="ignore"):
            acceleration[:] = (self._state["qvel"] - before) / self.model.opt.timestep

    def refresh(self, env_ids: torch.Tensor | Sequence[int] | None = None) -> None:
        self._forward(env_ids, max(self._stage, Stage.POS) if self._frames is None else self._frames.stage)

    def forward(self, env_ids: torch.Tensor | Sequence[int] | None = None) -> None:
        self._forward(env_ids, Stage.ACC)

    def _forward(self, env_ids: torch.Tensor | Sequence[int] | None, stage: Stage) -> None:
        ids = self._sorted_ids(env_ids)
        if ids is not None and not len(ids):
            return
        if stage == Stage.ACC:
            self._forces_unchecked = True
        self._compute(ids, stage)
        with lossy():
            for mirror in self._mirrors.values():
                if mirror.stage != Stage.NONE:
                    mirror.sync(stage, ids)
        self._caught_up(env_ids)

    def _compute(self, ids: np.ndarray | None, stage: Stage) -> None:
        """Run the stages up to `stage` at the current state."""
        self._follow_model()
        frames = self._frames
        if frames is not None:
            self._call(lambda: frames.follow(ids))
        if frames is None or stage > frames.stage:
            self._call(lambda: self._batch.forward(ids, stage=int(stage)))

    def _leave_frames_to_the_batch(self) -> None:
        """From now on the batch computes them itself: it has to run its position stage, or its frames differ."""
        frames, self._frames = self._frames, None
        self._stage = max(self._stage, Stage.POS if frames is None else frames.stage)
        if frames is None:
            return
        for name in self._mirrors.keys() & {*FRAME_FIELDS, *MOTION_FIELDS}:
            self._mirrors[name].source = self._batch.bind(name).reshape(self.num_envs, -1)

    def reset(self, env_ids: torch.Tensor | Sequence[int] | None = None) -> None:
        ids = self._sorted_ids(env_ids)
        if ids is not None and not len(ids):
            return
        if not self._looked:
            self._collect_failures()
        self._call(lambda: self._batch.reset(ids, stage=int(Stage.NONE)))
        self._silence_warnings(slice(None) if ids is None else ids)
        with lossy():
            for mirror in self._mirrors.values():
                if mirror.stage == Stage.NONE:
                    mirror.sync(Stage.NONE, ids)
                else:
                    mirror.clear_forces(ids)
        self._moved("qpos", env_ids)
        if self._acceleration is not None:
            self._acceleration[_ALL if ids is None else torch.from_numpy(ids)] = 0.0

    # -- model

    def randomizable(self, name: str) -> torch.Tensor:
        self._check_randomizable(name)
        self._inertias_differ |= name in MOTION_MODEL_FIELDS
        moving = name in MOTION_MODEL_FIELDS and not self._mirrors.keys().isdisjoint(MOTION_FIELDS)
        if name in FRAME_MODEL_FIELDS or moving:
            self._leave_frames_to_the_batch()
        if name not in self._model_fields:
            with torch.inference_mode(False):  # so that torch counts what is written into it
                self._model_fields[name] = torch.from_numpy(self._batch.expand(name))
        return self._hand_out(name, self._model_fields[name])

    def _set_constants(self) -> None:
        try:
            self._batch.set_const()
        except SimulationError as error:
            raise PhysicsError(f"cannot recompute the constants of the randomised model: {error}") from error

    # -- saved state

    def _live_state(self) -> dict[str, torch.Tensor]:
        arrays = {
            "state": self._batch.state,
            "warnings": self._batch.warning,
            "raised": self._raised,
            "nonfinite": self._nonfinite,
            "overflow": self._overflow,
        }
        return {name: torch.from_numpy(array) for name, array in arrays.items()}

    def _model_rows(self) -> dict[str, torch.Tensor]:
        return dict(self._model_fields)

    def _restore_constants(self) -> None:
        self._set_constants()

    def _on_state_loaded(self) -> None:
        self._failures = bool(self._nonfinite.any() or self._overflow.any())
        self._looked, self._forces_unchecked = False, True

    # -- health and inspection

    def health(self) -> Health:
        if not self.auto_reset_failed:  # else each step has looked
            self._collect_failures()
        self._looked = True
        if not self._failures:
            return self._unharmed
        report = Health(torch.from_numpy(self._nonfinite.copy()), torch.from_numpy(self._overflow.copy()))
        self._nonfinite[:] = False
        self._overflow[:] = False
        self._failures = False
        return report

    def get_data(self, env_id: int, data: mujoco.MjData | None = None) -> mujoco.MjData:
        self._follow_model()
        data = self._batch.get_data(env_id, data)
        self._model_of_env = self._batch.get_model(env_id, self._model_of_env)
        silence(data)
        mujoco.mj_forward(self._model_of_env, data)
        return data

    # -- private

    def _state_columns(self, name: str) -> slice:
        """Where a state field lies in a row of the batch's state."""
        view, state = self._batch.bind(name), self._batch.state
        size = int(np.prod(view.shape[1:], dtype=int))
        start = (view.ctypes.data - state.ctypes.data) // state.itemsize if size else 0
        return slice(start, start + size)

    def _sorted_ids(self, env_ids: torch.Tensor | Sequence[int] | None) -> np.ndarray | None:
        """Ascending and unique, as the batch asks; None for all."""
        if env_ids is None:
            return None
        ids = self._numpy_env_ids(env_ids)
        return ids if len(ids) < 2 or (ids[1:] > ids[:-1]).all() else np.unique(ids)

    def _numpy_env_ids(self, env_ids: torch.Tensor | Sequence[int]) -> np.ndarray:
        """A reset asks many times with one tensor, so the last answer is kept: an array in the tensor's memory."""
        last, ids = self._last_ids
        if last is None or env_ids is not last:
            ids = _numpy_ids(env_ids)
            if isinstance(env_ids, torch.Tensor) and env_ids.is_cpu and env_ids.dtype == torch.long:
                self._last_ids = env_ids, ids
        return ids

    def _call(self, function: Callable[[], None]) -> None:
        """Run a batch call; environments in which MuJoCo raised keep their state and are marked as failed."""
        try:
            function()
        except SimulationError as error:
            if not self._logged_engine_error:
                _LOG.warning("%s", str(error).splitlines()[0])
                self._logged_engine_error = True
            self._raised[error.ids] = True

    def _silence_warnings(self, rows: slice | np.ndarray) -> None:
        """Start every warning counter at one: MuJoCo prints and logs to a file only when it leaves zero."""
        self._warnings[rows] = 1

    def _collect_failures(self) -> np.ndarray | None:
        """Add to the failure flags what MuJoCo raised and warned of since the last look and what the state shows.

        Returns:
            Which environments that is, (num_envs,); None where it is none for sure.
        """
        warned_of = self._warnings.max() > 1
        raised = self._raised.any()
        if not (warned_of or raised or self._forces_unchecked) and self._moves_within_bounds():
            return None
        self._forces_unchecked = False
        # one comparison finds NaN, infinity and huge values alike
        nonfinite = ~(np.abs(self._batch.state[:, self._dynamic]) <= MAX_VALUE).all(1)
        overflow = self._raised.copy()
        if warned_of:
            warned = self._warnings > 1
            nonfinite |= warned[:, self._failing].any(1)
            overflow |= warned[:, _OVERFLOW_WARNINGS].any(1)
            self._silence_warnings(_ALL)
        self._raised[:] = False
        self._nonfinite |= nonfinite
        self._overflow |= overflow
        self._failures = bool(self._nonfinite.any() or self._overflow.any())
        return nonfinite | overflow

    def _moves_within_bounds(self) -> bool:
        """Whether positions, velocities and activations of all environments are surely healthy, at little cost.

        What step() did to accelerations MuJoCo has checked itself, and would have warned of.
        """
        for name in ("qpos", "qvel", "act"):
            values = self._state[name]
            if values.size:
                values = self._mirrors[name].array if name in self._mirrors else values
                if not (values.max() < _CLEARLY_HEALTHY and values.min() > -_CLEARLY_HEALTHY):  # NaN: neither
                    return False
        return True


def _numpy_ids(ids: torch.Tensor | Sequence[int]) -> np.ndarray:
    if isinstance(ids, torch.Tensor) and ids.dtype == torch.long and ids.device.type == "cpu":
        return ids.numpy()
    return ids_tensor(ids, torch.device("cpu")).numpy()


def _length(index: slice | np.ndarray, size: int) -> int:
    return len(range(*index.indices(size))) if isinstance(index, slice) else len(index)


def _available_cpus() -> int:
    """CPUs that this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1

"""Physics on CUDA (or, slowly, on the CPU): `mujoco_warp`, all environments in one set of float32 arrays.

Beside :mod:`.warp_kernels` the only module that imports warp. Tensors are the engine's own arrays, shared without a
copy. Each kind of call is one graph, on CUDA launched on torch's current stream. A graph is captured again when an
array that it refers to was replaced. Only :meth:`WarpPhysics.get_data` and, once for each field,
:meth:`WarpPhysics.randomizable` read values back to the host.
"""

from __future__ import annotations

import gc
import logging
import time
from collections.abc import Callable, Hashable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import mujoco
import mujoco_warp as mjw
import numpy as np
import torch
import warp as wp

from lift_lab.sim.ignored import note_ignored
from lift_lab.utils.errors import ConfigError, NotFoundError, PhysicsError

from .base import Health, silence
from .data_fields import MAX_VALUE, STATE_FIELDS, Stage, sensor_stages
from .memory import check_fits, warp_bytes
from .model_fields import RANDOMIZABLE_FIELDS, fixed_geoms, words
from .refresh_plan import RefreshPlan
from .rows import broadcast_rows, ids_tensor
from .saved_physics import SavedPhysics
from .sizing import estimate_sizes
from .warp_kernels import find_failures, keep_columns, place_fixed_geoms, say_when_compiling, zero_rows

if TYPE_CHECKING:
    from lift_lab.sim.simulation_cfg import SimulationCfg

_LOG = logging.getLogger(__name__)

LEAST_TOLERANCE = 1e-6
"""mujoco_warp 4.0 raises a smaller solver tolerance to this: it computes in float32."""

_SOLVERS = ("CG", "Newton")

_OVERFLOWS = int(
    mjw.OverflowType.NEFC
    | mjw.OverflowType.NJMAX_NNZ
    | mjw.OverflowType.BROADPHASE
    | mjw.OverflowType.NARROWPHASE
    | mjw.OverflowType.CCD
    | mjw.OverflowType.HFIELD
    | mjw.OverflowType.CONTACT_MATCH
    | mjw.OverflowType.NVMAX
    | mjw.OverflowType.TACTILE
)
"""Bits that mean something was dropped; reaching an iteration limit is no failure."""

_UNSUPPORTED_FLAGS = int(mujoco.mjtDisableBit.mjDSBL_AUTORESET | mujoco.mjtDisableBit.mjDSBL_MIDPHASE)
"""Flags that the engine does not know and does not need: it never resets itself and has no midphase."""

_DERIVED_CONSTANTS = words(
    "body_subtreemass body_invweight0 dof_invweight0 tendon_invweight0 tendon_length0 actuator_acc0 eq_data",
    "cam_pos0 cam_poscom0 cam_mat0 light_pos0 light_poscom0 light_dir0",
)
"""Model fields that recompute_constants() writes."""

_DERIVED_FROM_SIZE = ("geom_aabb", "geom_rbound")
"""Model fields that recompute_constants() writes too where `geom_size` differs between environments."""


class WarpPhysics(SavedPhysics):
    """MuJoCo-Warp; see :class:`Physics` for the interface.

    After step() fields belong to the same states as on the native engine: positions to the new state, velocities too
    once any is bound, forces to the last substep. refresh() and forward() always compute all environments. This changes
    nothing where nothing was written.

    Contacts of all environments share one buffer. When it overflows, every environment is reported, since any may have
    lost a contact. Constraint rows are per environment.

    Args:
        model: the compiled model; copied.
        num_envs: number of environments.
        device: "cpu" or "cuda:N".
        nconmax: contacts per environment, None for an estimate from the model.
        njmax: constraint rows per environment, None for an estimate from the model.
        auto_reset_failed: see :class:`Physics`.

    Raises:
        ConfigError: the device is neither, a size is below 1, the environments do not fit into memory, or the model
            has soft bodies.
        PhysicsError: the model uses a feature that the engine does not have.
    """

    name = "warp"
    is_asynchronous = True

    @classmethod
    def options_of(cls, cfg: SimulationCfg) -> dict[str, Any]:
        mj = cfg.mujoco
        if mj.tolerance is not None and mj.tolerance < LEAST_TOLERANCE:
            raise ConfigError(
                f"sim.mujoco.tolerance: the warp engine computes in float32 and would raise {mj.tolerance:g} to"
                f" {LEAST_TOLERANCE:g}; set {LEAST_TOLERANCE:g} or more, None, or sim.physics 'native'"
            )
        if mj.solver not in _SOLVERS:
            raise ConfigError(
                f"sim.mujoco.solver: the warp engine has no '{mj.solver}'; choose one of"
                f" {', '.join(_SOLVERS)}, or sim.physics 'native'"
            )
        if cfg.num_threads is not None:
            note_ignored("sim.num_threads", "the warp engine has no threads")
        return {"nconmax": mj.nconmax, "njmax": mj.njmax}

    def __init__(
        self,
        model: mujoco.MjModel,
        num_envs: int,
        device: str | torch.device = "cuda:0",
        nconmax: int | None = None,
        njmax: int | None = None,
        auto_reset_failed: bool = False,
    ):
        device = torch.device(device)
        if model.nflex:
            raise ConfigError("soft bodies are simulated by the native engine only; choose sim.device='cpu'")
        if device.type not in ("cpu", "cuda"):
            raise ConfigError(f"warp physics runs on devices 'cpu' and 'cuda:N', not '{device}'")
        for name, size in (("nconmax", nconmax), ("njmax", njmax)):
            if size is not None and size < 1:
                raise ConfigError(f"{name} must be at least 1, got {size}")
        super().__init__(model, num_envs, device, auto_reset_failed)
        wp.config.log_level = max(wp.config.log_level, wp.LOG_WARNING)  # no banner, no line per loaded module
        wp.init()
        self._wp_device = wp.device_from_torch(device)
        estimate = estimate_sizes(self.model)
        self.nconmax, self.njmax = nconmax or estimate[0], njmax or estimate[1]
        check_fits("scene.num_envs", num_envs, warp_bytes(self.model, self.nconmax, self.njmax), device)
        with wp.ScopedDevice(self._wp_device):
            self._m, self._d = self._put(self.model)
            self._reset_mask = wp.zeros(num_envs, dtype=bool)
            self._failed = wp.zeros(num_envs, dtype=bool)
            latched = [wp.zeros(num_envs, dtype=bool) for _ in range(2)]
            self._sensor_saved = wp.empty_like(self._d.sensordata)
            self._qvel_before = wp.empty_like(self._d.qvel)
            stages = sensor_stages(self.model)
            self._force_sensors = wp.array([s == Stage.ACC for s in stages], dtype=bool)
            self._fixed_geoms = wp.array(fixed_geoms(self.model), dtype=int)
        self._reset_mask_torch = wp.to_torch(self._reset_mask)
        self._latched = latched
        self._nonfinite, self._overflow = (wp.to_torch(flags) for flags in latched)
        self._overflow_bits = wp.to_torch(self._d.overflow)  # what the engine has counted since the last look
        self._fields: dict[str, torch.Tensor] = {}
        self._stages: dict[str, Stage] = {}
        self._plan = RefreshPlan()
        self._randomized: dict[str, torch.Tensor] = {}
        self._graphs: dict[Hashable, wp.Graph] = {}
        # without a memory pool the engine's own scratch arrays cannot be captured
        self._use_graphs = self._wp_device.is_cpu or wp.is_mempool_enabled(self._wp_device)
        self._model_of_env: mujoco.MjModel | None = None
        self._looked = True  # whether health() was asked since the last step
        self._checked = False  # whether the latched failures tell of the present state
        self._constants_compiled = False
        self._force_rows: dict[str, wp.array] = {}  # bound fields that a reset clears, one row per environment
        self._warm_up()

    # -- fields

    def field(self, name: str) -> torch.Tensor:
        if name not in self._fields:
            stage = self._field_stage(name)
            self._fields[name] = self._state_tensor(name)
            self._stages[name] = stage
            self._plan = RefreshPlan.of(self._stages, self.model)
            if stage == Stage.ACC and self._fields[name].numel():
                self._force_rows[name] = wp.from_torch(self._fields[name].view(self.num_envs, -1))
            if stage == Stage.ACC or (name == "sensordata" and Stage.ACC in sensor_stages(self.model)):
                self.forward()
            elif stage != Stage.NONE:
                self.refresh()
        return self._fields[name]

    @property
    def bound_fields(self) -> tuple[str, ...]:
        return tuple(self._fields)

    def write(
        self,
        name: str,
        values: torch.Tensor | float,
        env_ids: torch.Tensor | Sequence[int] | None = None,
        cols: slice | torch.Tensor | Sequence[int] | None = None,
    ) -> None:
        self._check_state_field(name)
        self._checked = False
        target = self.field(name).view(self.num_envs, -1)
        rows = slice(None) if env_ids is None else ids_tensor(env_ids, self.device)
        columns = cols if isinstance(cols, slice) else slice(None) if cols is None else ids_tensor(cols, self.device)
        num_rows = self.num_envs if isinstance(rows, slice) else len(rows)
        width = target.shape[1]
        num_cols = len(range(*columns.indices(width))) if isinstance(columns, slice) else len(columns)
        if not isinstance(rows, slice) and not isinstance(columns, slice):
            rows = rows[:, None]
        source = torch.as_tensor(values, dtype=torch.float32, device=self.device).detach()
        target[rows, columns] = broadcast_rows(name, source, num_rows, num_cols)
        self._moved(name, env_ids)
        if name == "qvel" and self._acceleration is not None:
            self._acceleration[rows, columns] = 0.0

    # -- dynamics

    def step(self, num_substeps: int = 1) -> None:
        if num_substeps < 1:
            raise ConfigError(f"num_substeps must be at least 1, got {num_substeps}")
        self._follow_model()

        def substeps() -> None:
            for i in range(num_substeps):
                if compares and i == num_substeps - 1:
                    wp.copy(self._qvel_before, self._d.qvel)
                mjw.step(self._m, self._d)
            self._failure_kernels()
            if resets:
                self._reset_kernels(self._failed)
            self._refresh_kernels()

        resets, compares = self.auto_reset_failed, self._acceleration is not None
        cleared = tuple(self._force_rows) if resets else ()
        self._run(("step", num_substeps, self._plan, cleared, compares), substeps)
        self._looked, self._checked = False, True
        self._caught_up(None)
        if self._acceleration is not None:
            torch.sub(self._state_tensor("qvel"), wp.to_torch(self._qvel_before), out=self._acceleration)
            self._acceleration /= self.model.opt.timestep
            if resets:
                self._acceleration.masked_fill_(wp.to_torch(self._failed)[:, None], 0.0)

    def refresh(self, env_ids: torch.Tensor | Sequence[int] | None = None) -> None:
        self._follow_model()
        self._run(("refresh", self._plan), self._refresh_kernels)
        self._caught_up(None)
        self._checked = self._checked and not self._plan.collision

    def forward(self, env_ids: torch.Tensor | Sequence[int] | None = None) -> None:
        self._follow_model()
        self._run("forward", lambda: mjw.forward(self._m, self._d))
        self._caught_up(None)
        self._checked = False

    def reset(self, env_ids: torch.Tensor | Sequence[int] | None = None) -> None:
        if not self._looked:
            self._check()
        if env_ids is None:
            self._reset_mask_torch.fill_(True)
        else:
            self._reset_mask_torch.fill_(False)
            self._reset_mask_torch[ids_tensor(env_ids, self.device)] = True
        self._run(("reset", tuple(self._force_rows)), lambda: self._reset_kernels(self._reset_mask))
        self._checked = False
        self._moved("qpos", env_ids)
        if self._acceleration is not None:
            self._acceleration.masked_fill_(self._reset_mask_torch[:, None], 0.0)

    def _reset_kernels(self, mask: wp.array) -> None:
        """Default state, and no forces, where the mask is true."""
        mjw.reset_data(self._m, self._d, reset=mask)
        for rows in self._force_rows.values():
            wp.launch(zero_rows, dim=rows.shape, inputs=[mask], outputs=[rows])

    def _failure_kernels(self) -> None:
        """Latch what the state shows and what the engine counted."""
        d = self._d
        wp.launch(
            find_failures,
            dim=self.num_envs,
            inputs=[d.qpos, d.qvel, d.act, d.qacc_warmstart, d.ctrl, float(MAX_VALUE), _OVERFLOWS],
            outputs=[d.overflow, self._failed, *self._latched],
        )

    def _refresh_kernels(self) -> None:
        """Position-dependent fields, velocity-dependent ones if any is bound, and sensors of these stages."""
        m, d, plan = self._m, self._d, self._plan
        if plan.collision:
            mjw.fwd_position(m, d)
        else:
            mjw.fwd_kinematics(m, d)
            mjw.transmission(m, d)
        if plan.velocity == "com":
            mjw.com_vel(m, d)
        elif plan.velocity == "all":
            mjw.fwd_velocity(m, d)
        if plan.sensors:
            wp.copy(self._sensor_saved, d.sensordata)
            d.sensordata.zero_()
            mjw.sensor_pos(m, d)
            if plan.velocity == "all":
                mjw.sensor_vel(m, d)
            wp.launch(
                keep_columns,
                dim=d.sensordata.shape,
                inputs=[self._force_sensors, self._sensor_saved],
                outputs=[d.sensordata],
            )

    # -- model

    def randomizable(self, name: str) -> torch.Tensor:
        self._check_randomizable(name)
        return self._hand_out(name, self._expand(name))

    def _set_constants(self) -> None:
        for name in (*_DERIVED_CONSTANTS, *(_DERIVED_FROM_SIZE if "geom_size" in self._randomized else ())):
            if getattr(self._m, name).size:
                self._expand(name)
        # hundreds of small kernels: a graph, once they are compiled
        if self._constants_compiled:
            self._run("constants", self._constants_kernels)
        else:
            with self._on_torch_stream(), say_when_compiling(self._wp_device):
                self._constants_kernels()
            self._constants_compiled = True

    def _constants_kernels(self) -> None:
        m, d = self._m, self._d
        mjw.set_const(m, d)
        if self._fixed_geoms.size:
            wp.launch(
                place_fixed_geoms,
                dim=(self.num_envs, self._fixed_geoms.size),
                inputs=[self._fixed_geoms, m.geom_bodyid, m.geom_pos, m.geom_quat, d.xpos, d.xquat],
                outputs=[d.geom_xpos, d.geom_xmat],
            )

    def _expand(self, name: str) -> torch.Tensor:
        """Give a model field one row per environment; every captured graph still refers to the shared one."""
        if name in self._randomized:
            return self._randomized[name]
        owner, attribute = (self._m.opt, name[4:]) if name.startswith("opt.") else (self._m, name)
        host = getattr(self.model.opt, attribute) if owner is self._m.opt else getattr(self.model, name)
        shared = getattr(owner, attribute)
        if self._graphs:
            wp.synchronize_device(self._wp_device)  # a graph may still run
            self._graphs.clear()
        with self._on_torch_stream():
            rows = wp.array(np.repeat(shared.numpy(), self.num_envs, axis=0), dtype=shared.dtype)
        setattr(owner, attribute, rows)
        with torch.inference_mode(False):  # so that torch counts what is written into it
            self._randomized[name] = _shared_tensor(rows, (self.num_envs, *np.shape(host)), self.device)
        return self._randomized[name]

    # -- saved state

    def _live_state(self) -> dict[str, torch.Tensor]:
        notes = {"nonfinite": self._nonfinite, "overflow": self._overflow, "overflow_bits": self._overflow_bits}
        return {name: self._state_tensor(name) for name in (*STATE_FIELDS, "qacc_warmstart")} | notes

    def _model_rows(self) -> dict[str, torch.Tensor]:
        return dict(self._randomized)

    def _model_row(self, name: str) -> torch.Tensor:
        return self.randomizable(name) if name in RANDOMIZABLE_FIELDS else self._expand(name)

    def _on_state_loaded(self) -> None:
        self._looked = self._checked = False

    # -- health and inspection

    def health(self) -> Health:
        self._check()
        self._looked, self._checked = True, False  # what is still bad counts again
        report = Health(self._nonfinite.clone(), self._overflow.clone())
        self._nonfinite.zero_()
        self._overflow.zero_()
        return report

    def get_data(self, env_id: int, data: mujoco.MjData | None = None) -> mujoco.MjData:
        if not 0 <= env_id < self.num_envs:
            raise NotFoundError(f"environment {env_id} is not in [0, {self.num_envs})")
        if data is None:
            data = mujoco.MjData(self.model)
        self._follow_model()
        if self._model_of_env is None:
            self._model_of_env = self.model.__copy__()
        for name, rows in self._randomized.items():
            owner = self._model_of_env.opt if name.startswith("opt.") else self._model_of_env
            getattr(owner, name.removeprefix("opt."))[:] = rows[env_id].cpu().numpy()
        if self._inputs:
            mujoco.mj_setConst(self._model_of_env, data)  # changes positions, which are written next
        for name in STATE_FIELDS:
            value = self._state_tensor(name)[env_id].cpu().numpy()
            if name == "time":
                data.time = float(value)
            else:
                getattr(data, name)[:] = value
        silence(data)
        mujoco.mj_forward(self._model_of_env, data)
        return data

    def close(self) -> None:
        if not self._is_closed and self._wp_device.is_cuda:
            wp.synchronize_device(self._wp_device)  # a graph may still run
        super().close()

    # -- private

    def _put(self, model: mujoco.MjModel) -> tuple[mjw.Model, mjw.Data]:
        """The model and the arrays of all environments on the device."""
        model = model.__copy__()
        model.opt.disableflags &= ~_UNSUPPORTED_FLAGS
        try:
            on_device = mjw.put_model(model)
            # what the engine raised it to (float32), so that the model tells what runs
            self.model.opt.tolerance = max(self.model.opt.tolerance, float(f"{on_device.opt.tolerance.numpy()[0]:.7g}"))
            on_device.opt.warn_overflow = 0  # reported by health(), not printed by kernels
            return on_device, mjw.make_data(model, self.num_envs, nconmax=self.nconmax, njmax=self.njmax)
        except (NotImplementedError, ValueError) as error:
            raise PhysicsError(f"warp physics cannot run this model: {error}; choose physics 'native'") from error

    def _warm_up(self) -> None:
        """Run every kernel once, so that compiling happens here and not inside a step or a capture."""
        start = time.monotonic()
        with say_when_compiling(self._wp_device):
            with self._on_torch_stream():
                mjw.step(self._m, self._d)
            self.reset()
            self.refresh()
            self.health()
        _LOG.info("MuJoCo-Warp kernels loaded in %.1f s", time.monotonic() - start)

    def _state_tensor(self, name: str) -> torch.Tensor:
        return _shared_tensor(getattr(self._d, name), (self.num_envs, *self._shape(name)), self.device)

    def _check(self) -> None:
        """Latch failures, unless that was done since anything changed; all on the device."""
        if not self._checked:
            self._run("check", self._failure_kernels)
            self._checked = True

    @contextmanager
    def _on_torch_stream(self) -> Iterator[None]:
        """Launch on torch's current stream, in order with torch's own work."""
        if self._wp_device.is_cuda:
            with wp.ScopedStream(wp.stream_from_torch(self.device)):
                yield
        else:
            with wp.ScopedDevice(self._wp_device):
                yield

    def _run(self, key: Hashable, kernels: Callable[[], None]) -> None:
        """Launch kernels as a graph, captured the first time `key` is seen."""
        if not self._use_graphs:
            with self._on_torch_stream():
                return kernels()
        if key not in self._graphs:
            self._graphs[key] = self._capture(kernels)
        stream = wp.stream_from_torch(self.device) if self._wp_device.is_cuda else None
        wp.capture_launch(self._graphs[key], stream=stream)

    def _capture(self, kernels: Callable[[], None]) -> wp.Graph:
        """Record kernels on warp's own stream: torch's default stream cannot be captured."""
        collecting = gc.isenabled()
        gc.disable()  # freeing an old graph would be recorded into the new one
        try:
            with say_when_compiling(self._wp_device), wp.ScopedDevice(self._wp_device), wp.ScopedCapture() as capture:
                kernels()
        finally:
            if collecting:
                gc.enable()
        if capture.graph is None:
            raise PhysicsError("graph capture failed")
        return capture.graph


def _shared_tensor(array: wp.array, shape: tuple[int, ...], device: torch.device) -> torch.Tensor:
    """A warp array as a torch tensor on the same memory, shaped as MuJoCo has it (matrices flattened)."""
    if not array.size:
        return torch.zeros(shape, device=device)
    return wp.to_torch(array).view(shape)

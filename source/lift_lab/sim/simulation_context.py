"""The running simulation: the compiled model and the engine that steps it.

A scene hands over one MjSpec; :meth:`SimulationContext.reset` compiles it, starts the engine chosen by device and
lets the scene find its indices. Everything above reads and writes the engine through ``sim.physics``.
"""

from __future__ import annotations

import gc
import math
import re
import weakref
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import mujoco
import torch

from lift_lab.utils.configclass import validate
from lift_lab.utils.errors import ConfigError, PhysicsError
from lift_lab.utils.saved_state import Stateless

from .engines import engine_class
from .ignored import note_changed_fields
from .physics import make_physics
from .rendering import FrameRenderer, RenderView
from .simulation_cfg import MujocoCfg, SimulationCfg
from .spawners.appearance import add_checker_to_planes

if TYPE_CHECKING:
    import numpy as np

    from .physics.base import Physics

__all__ = ["SimulationContext"]


_IGNORED = {
    "enable_scene_query_support": "PhysX scene queries",
    "use_fabric": "Omniverse Fabric",
    "create_stage_in_memory": "stages are always in memory",
    "save_logs_to_file": "logging is Python's",
    "log_dir": "logging is Python's",
    "logging_level": "logging is Python's",
    "physics_material": "a shape without a material has MuJoCo's friction of 1; set its spawner's own",
}


class SceneLike(Protocol):
    """Interface of a scene that the simulation uses."""

    num_envs: int
    spec: mujoco.MjSpec

    def initialize(self) -> None:
        """Find indices in the compiled model and write the initial state."""
        ...


_INTEGRATORS = {
    "Euler": mujoco.mjtIntegrator.mjINT_EULER,
    "RK4": mujoco.mjtIntegrator.mjINT_RK4,
    "implicit": mujoco.mjtIntegrator.mjINT_IMPLICIT,
    "implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    "discrete": mujoco.mjtIntegrator.mjINT_DISCRETE,
}
_CONES = {"pyramidal": mujoco.mjtCone.mjCONE_PYRAMIDAL, "elliptic": mujoco.mjtCone.mjCONE_ELLIPTIC}
_SOLVERS = {
    "PGS": mujoco.mjtSolver.mjSOL_PGS,
    "CG": mujoco.mjtSolver.mjSOL_CG,
    "Newton": mujoco.mjtSolver.mjSOL_NEWTON,
}


_MOST_CLOSED, _MOST_CLOSED_ENVS = 16, 256
"""Closed simulations, and environments in them, from which on a new simulation has them freed first: that takes up to
a second."""


def resolve_device(device: str | None) -> str:
    """``"auto"`` as a GPU where torch sees one, else the CPU; ``"cuda"`` as ``"cuda:0"``.

    None is ``"auto"``: scripts copy ``args_cli.device`` into the config, and that flag is optional.

    Raises:
        ConfigError: no device, or one that torch does not have.
    """
    if device is None or device == "auto":
        return "cuda:0" if torch.cuda.is_available() else "cpu"
    count = torch.cuda.device_count() if torch.cuda.is_available() else 0
    found = ["cpu", *(f"cuda:{i}" for i in range(count))]
    known = re.fullmatch(r"cpu(?::0)?|cuda(?::(\d+))?", str(device))
    if known is None:
        raise ConfigError(f"'{device}' is no device; choose one of: {', '.join(['auto', *found])}")
    if str(device).startswith("cpu"):
        return "cpu"
    index = int(known[1] or 0)
    if index >= count:
        raise ConfigError(f"device '{device}' is not available; choose one of: {', '.join(found)}")
    return f"cuda:{index}"


def _pick(table: dict[str, Any], key: str, field: str) -> Any:
    if key not in table:
        raise ConfigError(f"sim.mujoco.{field}: '{key}' is not one of {', '.join(table)}")
    return table[key]


class SimulationContext(Stateless):
    """One simulation at a time, as in Isaac Lab: the newest instance is :meth:`instance`."""

    _current: ClassVar[SimulationContext | None] = None
    _closed: ClassVar[weakref.WeakSet[SimulationContext]] = weakref.WeakSet()  # not yet freed

    def __init__(self, cfg: SimulationCfg | None = None, auto_reset_failed: bool = False):
        """Hold the settings; nothing is compiled before :meth:`reset`.

        Args:
            cfg: the settings; None for the defaults.
            auto_reset_failed: whether a step resets environments in which the physics fails, see
                :attr:`~lift_lab.sim.physics.base.Physics.auto_reset_failed`.

        Raises:
            ConfigError: the device or the engine does not exist, or the engine cannot honour a setting.
        """
        SimulationContext._free_closed()
        self.cfg = (cfg if cfg is not None else SimulationCfg()).copy()
        validate(self.cfg, "sim")
        self._device = resolve_device(self.cfg.device)
        self._scene: SceneLike | None = None
        self._physics: Physics | None = None
        self._num_envs = 0
        self._initial_state: tuple[np.ndarray, np.ndarray] | None = None
        self._renderer: FrameRenderer | None = None
        self._view = RenderView()
        engine = engine_class(self.cfg.physics, self._device)
        self._engine_options = engine.options_of(self.cfg) | {"auto_reset_failed": auto_reset_failed}
        self._note_ignored()
        SimulationContext._current = self

    @classmethod
    def _free_closed(cls) -> None:
        """Free closed simulations with their scenes and environments, if there is much to free.

        Terms and managers refer to their environment and it to them. Python frees such cycles only now and then: after
        a hundred environments a dozen closed ones would take up memory.
        """
        if len(cls._closed) >= _MOST_CLOSED or sum(sim._num_envs for sim in cls._closed) >= _MOST_CLOSED_ENVS:
            gc.collect()
            cls._closed.clear()  # what is still there is held by the user

    @classmethod
    def instance(cls) -> SimulationContext | None:
        """The newest simulation, or None."""
        return cls._current

    @classmethod
    def clear_instance(cls) -> None:
        """Close and forget the newest simulation."""
        if cls._current is not None:
            cls._current.close()

    @contextmanager
    def as_current(self) -> Iterator[None]:
        """While this lasts, :meth:`instance` is this simulation; then it is again the one that it was."""
        before, SimulationContext._current = SimulationContext._current, self
        try:
            yield
        finally:
            SimulationContext._current = before

    @property
    def device(self) -> str:
        """Torch device of every tensor."""
        return self._device

    @property
    def physics(self) -> Physics:
        """The engine.

        Raises:
            PhysicsError: the simulation was not reset yet.
        """
        if self._physics is None:
            raise PhysicsError("the simulation has not started: call sim.reset() after building the scene")
        return self._physics

    @property
    def is_started(self) -> bool:
        """Whether the model is compiled and the engine runs."""
        return self._physics is not None

    @property
    def model(self) -> mujoco.MjModel:
        """The compiled model of one environment."""
        return self.physics.model

    def get_physics_dt(self) -> float:
        """Physics step in seconds."""
        return float(self.cfg.dt)

    def has_gui(self) -> bool:
        """Always False: there is no window."""
        return False

    def has_rtx_sensors(self) -> bool:
        """Always False: there are no rendered sensors. Steps written out after Isaac Lab's ask for it."""
        return False

    def is_playing(self) -> bool:
        """Isaac Lab's name of :attr:`is_started`: nothing pauses it."""
        return self.is_started

    def is_stopped(self) -> bool:
        """Whether :meth:`reset` was not called yet, or :meth:`close` was."""
        return not self.is_started

    def set_camera_view(
        self, eye: Sequence[float], target: Sequence[float], camera_prim_path: str = "/OmniverseKit_Persp"
    ) -> None:
        """Choose from where :meth:`render` looks when it is given no view.

        Args:
            eye: position of the camera in m, in the frame of the first environment.
            target: point looked at in m.
            camera_prim_path: Isaac Lab's prim of the camera. Not used.

        Raises:
            ConfigError: the camera would be at the point that it looks at.
        """
        x, y, z = (float(value) for value in target)
        ahead = (x - float(eye[0]), y - float(eye[1]), z - float(eye[2]))
        distance = math.hypot(*ahead)
        if not distance > 0:
            raise ConfigError(f"set_camera_view: eye and target are the same point {(x, y, z)}")
        self._view = RenderView(
            lookat=(x, y, z),
            distance=distance,
            azimuth_deg=math.degrees(math.atan2(ahead[1], ahead[0])),
            elevation_deg=math.degrees(math.asin(ahead[2] / distance)),
        )

    def set_scene(self, scene: SceneLike) -> None:
        """Register the scene that :meth:`reset` compiles."""
        self._scene = scene

    def configure(self, spec: mujoco.MjSpec) -> None:
        """Write time step, gravity and solver settings into a spec.

        Raises:
            ConfigError: an unknown integrator, cone or solver, or a time step that is not positive.
        """
        if not self.cfg.dt > 0:
            raise ConfigError(f"sim.dt must be positive, got {self.cfg.dt}")
        mj: MujocoCfg = self.cfg.mujoco
        option = spec.option
        option.timestep = float(self.cfg.dt)
        option.gravity = self.cfg.gravity
        option.integrator = _pick(_INTEGRATORS, mj.integrator, "integrator")
        option.cone = _pick(_CONES, mj.cone, "cone")
        option.solver = _pick(_SOLVERS, mj.solver, "solver")
        option.impratio = mj.impratio
        option.iterations = mj.iterations
        option.ls_iterations = mj.ls_iterations
        if mj.tolerance is not None:
            option.tolerance = mj.tolerance
        if not mj.eulerdamp:
            option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
        if not mj.warmstart:
            option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_WARMSTART)
        if not mj.island:
            option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ISLAND)

    def reset(self) -> None:
        """Compile the scene, start the engine and put everything into its initial state.

        Raises:
            PhysicsError: there is no scene, or MuJoCo cannot compile it.
        """
        if self._scene is None:
            raise PhysicsError("there is nothing to simulate: build an InteractiveScene before sim.reset()")
        self.configure(self._scene.spec)
        add_checker_to_planes(self._scene.spec)
        try:
            model = self._scene.spec.compile()
        except ValueError as error:
            raise PhysicsError(f"MuJoCo cannot compile the scene: {error}") from error
        num_envs, kind = self._scene.num_envs, self.cfg.physics
        self._physics = make_physics(model, num_envs, self._device, kind, **self._engine_options)
        self._scene.initialize()
        qpos, qvel = (self._physics.field(name)[0].double().cpu().numpy().copy() for name in ("qpos", "qvel"))
        self._initial_state = qpos, qvel
        self._physics.refresh()

    def export_mjcf(self, path: str | Path) -> list[Path]:
        """Write the scene of one environment as MJCF; see :func:`lift_lab.sim.mjcf.write_mjcf`.

        The file has the scene as it was built. Events that change the model of single environments are not in it.

        Args:
            path: of the ``.xml`` file.

        Returns:
            The files, the MJCF first.

        Raises:
            PhysicsError: the simulation was not reset yet, or MuJoCo cannot write the scene as MJCF.
            FileError: a file cannot be written.
        """
        if self._scene is None or self._initial_state is None:
            raise PhysicsError("the simulation has not started: call sim.reset() after building the scene")
        from .mjcf import write_mjcf

        return write_mjcf(self._scene.spec, self.model, path, *self._initial_state)

    def step(self, render: bool = True) -> None:
        """Advance one physics step. ``render`` is Isaac Lab's; frames are drawn by :meth:`render` alone."""
        self.physics.step(1)

    def forward(self) -> None:
        """Make kinematics current after states were written."""
        self.physics.refresh()

    def render(self, view: RenderView | None = None) -> np.ndarray:
        """Draw one frame off screen.

        Args:
            view: camera, size and environments; None looks at the first environment as :meth:`set_camera_view` says.

        Returns:
            RGB image, shape (height, width, 3), uint8.

        Raises:
            PhysicsError: there is no OpenGL library to draw with.
        """
        view = view or self._view
        if self._renderer is None or not self._renderer.fits(view):
            if self._renderer is not None:
                self._renderer.close()
            self._renderer = FrameRenderer(self.physics, view)
        return self._renderer.draw(view)

    def close(self) -> None:
        """Free the engine and the renderer. May be called again."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None
        if self._physics is not None:
            self._num_envs = self._physics.num_envs
            self._physics.close()
            SimulationContext._closed.add(self)
        self._physics = None
        self._scene = None
        if SimulationContext._current is self:
            SimulationContext._current = None

    def _note_ignored(self) -> None:
        for name, reason in (
            ("physx", "PhysX setting; MuJoCo's are in sim.mujoco"),
            ("render", "Omniverse renderer setting"),
        ):
            group = getattr(self.cfg, name)
            note_changed_fields(f"sim.{name}", group, dict.fromkeys(vars(group), reason))
        note_changed_fields("sim", self.cfg, _IGNORED)

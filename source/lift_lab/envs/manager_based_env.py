"""An environment without rewards: a scene, and managers for actions, observations, events and recordings."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import torch

from lift_lab.managers import ActionManager, EventManager, ManagerBase, ObservationManager, RecorderManager
from lift_lab.scene import InteractiveScene
from lift_lab.sim import SimulationContext
from lift_lab.sim.ignored import note_ignored, report_ignored
from lift_lab.sim.physics.base import ids_tensor
from lift_lab.utils.configclass import validate
from lift_lab.utils.errors import ConfigError, ConfigTypeError, suggest
from lift_lab.utils.saved_state import Stateful
from lift_lab.utils.seed import configure_seed

from .arguments import action_tensor
from .common import VecEnvObs
from .grad_mode import in_any_grad_mode
from .manager_based_env_cfg import ManagerBasedEnvCfg
from .state import ChangedSettings, env_state, load_env_state, named_objects
from .utils.io_descriptors import io_descriptors, write_io_descriptors

if TYPE_CHECKING:
    from lift_lab.sim.physics.base import Physics

__all__ = [
    "ManagerBasedEnv",
]

logger = logging.getLogger(__name__)

_IGNORED = {
    "ui_window_class_type": (None, "there is no window"),
    "rerender_on_reset": (False, "there are no rendered sensors"),
    "num_rerenders_on_reset": (0, "there are no rendered sensors"),
    "wait_for_textures": (True, "there are no rendered sensors"),
    "xr": (None, "there are no XR devices"),
    "teleop_devices": (None, "there are no teleoperation devices"),
}
"""Fields of the config that have no effect: their default, and why."""


class ManagerBasedEnv(Stateful):
    """``num_envs`` copies of a scene, stepped together.

    One environment step is ``cfg.decimation`` physics steps. Where nothing has to be computed between them, the
    engine takes them in one call.
    """

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset(
        {"extras", "render_mode", "metadata", "_records", "_fuses_substeps", "_has_interval_events", "_is_closed"}
        | {"step_cache", "prefetched", "changed_settings", "_capture"}
    )

    cfg: Any
    """The config."""
    sim: SimulationContext
    """The simulation."""
    scene: InteractiveScene
    """The scene."""
    extras: dict[str, Any]
    """Values that are returned besides observations; ``extras["log"]`` is the log of the last resets."""
    obs_buf: VecEnvObs
    """The last observations."""
    step_cache: dict[Any, Any] | None
    """Results of :func:`~lift_lab.utils.step_cache.once_a_step` functions while nothing moves, else None."""
    prefetched: dict[Any, torch.Tensor]
    """Ids of environments that the host read with the question which episodes ended; see ``ManagerBase.masks``."""
    changed_settings: ChangedSettings
    """Changes that terms made to the configurations since construction."""
    event_modes: ClassVar[tuple[str, ...] | None] = ("prestartup", "startup", "reset", "interval")
    """Modes of events that this environment applies; an event of another mode is an error. A sub-class that applies
    modes of its own lists them here, or None for any."""

    auto_reset_failed: ClassVar[bool] = False
    """Whether the engine resets environments in which the physics fails within the step."""

    def __init__(self, cfg: ManagerBasedEnvCfg):
        """Build the scene, start the simulation and create the managers.

        Raises:
            TypeError: no config, or one that lacks values; the message lists the path of each.
            ConfigError: a setting is outside of its range, or something in the config cannot be built.
        """
        if not isinstance(cfg, ManagerBasedEnvCfg):
            raise ConfigTypeError(f"cfg has to be a ManagerBasedEnvCfg, not a {type(cfg).__name__}")
        validate(cfg, "env")
        if type(cfg).validate is not validate:  # the task's own
            cfg.validate()
        self.cfg = cfg
        self._is_closed = False
        if cfg.seed is None:
            logger.warning("cfg.seed is None: the random numbers of this run cannot be repeated")
        else:
            cfg.seed = self.seed(cfg.seed)
        self._note_ignored()
        if cfg.export_io_descriptors and cfg.log_dir is None:
            raise ConfigError("env.export_io_descriptors writes into env.log_dir, which is None: set it")
        self.sim = SimulationContext(cfg.sim, self.auto_reset_failed)
        try:
            self._build()
        except BaseException:
            self.close()
            raise
        report_ignored()
        logger.info("%s", self)

    def _build(self) -> None:
        """The part of construction after which the simulation has to be closed."""
        self._sim_step_counter = 0
        self.extras = {}
        self.obs_buf = {}
        self.step_cache, self.prefetched = None, {}
        self.scene = InteractiveScene(self.cfg.scene)
        self._create_buffers()
        self.event_manager: EventManager = EventManager(self.cfg.events, self)
        self._check_event_modes()
        if "prestartup" in self.event_manager.available_modes:
            self.event_manager.apply(mode="prestartup")
        self.event_manager.prepare_model()
        self.sim.reset()
        self.scene.update(dt=self.physics_dt)
        self.event_manager.resolve_terms()
        self.load_managers()
        self.changed_settings = ChangedSettings(self._settings)
        self._plan_steps()
        self._apply_startup_events()
        if self.cfg.export_io_descriptors:
            logger.info("IO descriptors: %s", self.export_IO_descriptors())

    def _plan_steps(self) -> None:
        """Decide once what no step can change."""
        actions, records = self.action_manager, self.recorder_manager.active_terms
        changing = [name for name in actions.active_terms if not actions.get_term(name).constant_over_substeps]
        self._records = bool(records)
        between = [f"env.actions.{name}" for name in changing] + [f"env.recorders.{name}" for name in records]
        between += [f"env.scene.{name}" for name in self.scene.substep_entities]
        self._fuses_substeps = not between
        if between and self.cfg.decimation > 1:
            logger.info("every physics step is a call of its own, for the sake of %s", ", ".join(between))
        self._has_interval_events = "interval" in self.event_manager.available_modes

    def _check_event_modes(self) -> None:
        """Find events that nobody would ever apply."""
        for mode, names in self.event_manager.active_terms.items():
            if self.event_modes is not None and mode not in self.event_modes:
                raise ConfigError(
                    f"env.events.{names[0]}.mode is '{mode}', which nothing applies; {suggest(mode, self.event_modes)} "
                    f"(an environment class lists modes of its own in event_modes)"
                )

    def _create_buffers(self) -> None:
        """Make what terms may read while the managers are created."""

    def load_managers(self) -> None:
        """Create the managers that need the running simulation."""
        self.recorder_manager: RecorderManager = RecorderManager(self.cfg.recorders, self)
        self.action_manager: ActionManager = ActionManager(self.cfg.actions, self)
        self.observation_manager: ObservationManager = ObservationManager(self.cfg.observations, self)

    def _apply_startup_events(self) -> None:
        if "startup" in self.event_manager.available_modes:
            self.event_manager.apply(mode="startup")
            self._refresh(None)

    def _note_ignored(self) -> None:
        for name, (default, reason) in _IGNORED.items():
            if getattr(self.cfg, name) != default:
                note_ignored(name, reason)

    # -- what a policy needs to know

    @property
    def get_IO_descriptors(self) -> dict[str, Any]:
        """Inputs and outputs of a policy as plain data, with Isaac Lab's keys.

        ``observations`` (the terms of the group "policy"), ``actions``, ``articulations`` (joint names and default
        values) and ``scene`` (steps). A property with a verb in its name, as in Isaac Lab.
        """
        return io_descriptors(self)

    def export_IO_descriptors(self, output_dir: str | Path | None = None) -> Path:
        """Write :attr:`get_IO_descriptors` to ``IO_descriptors.yaml``.

        Args:
            output_dir: folder; None for ``io_descriptors`` in ``cfg.log_dir``.

        Returns:
            Path of the file.

        Raises:
            ConfigError: no folder is given and ``cfg.log_dir`` is None.
            FileError: the file cannot be written.
        """
        return write_io_descriptors(self, output_dir)

    # -- what it is

    @property
    def num_envs(self) -> int:
        """Number of environments."""
        return self.cfg.scene.num_envs

    @property
    def device(self) -> str:
        """Torch device of every tensor."""
        return self.sim.device

    @property
    def physics_dt(self) -> float:
        """Physics step in s."""
        return float(self.cfg.sim.dt)

    @property
    def step_dt(self) -> float:
        """Environment step in s."""
        return float(self.cfg.sim.dt) * int(self.cfg.decimation)

    @property
    def unwrapped(self) -> ManagerBasedEnv:
        """This environment."""
        return self

    def __str__(self) -> str:
        lines = [
            f"{type(self).__name__} on {self.device}, seed {self.cfg.seed}",
            f"physics step {self.physics_dt:g} s, environment step {self.step_dt:g} s",
            str(self.scene),
        ]
        return "\n".join(lines + [str(manager) for manager in self._managers()])

    def _managers(self) -> list[Any]:
        """The managers, in the order in which their tables are shown."""
        return [self.event_manager, self.recorder_manager, self.action_manager, self.observation_manager]

    # -- saved state

    def state_parts(self) -> dict[str, Any]:
        saved_by_name = (InteractiveScene, ManagerBase)
        return {name: part for name, part in super().state_parts().items() if not isinstance(part, saved_by_name)}

    def named_objects(self) -> dict[str, Any]:
        return named_objects(self)

    def state_dict(self) -> dict[str, Any]:
        """Everything that the future of the environment depends on, but the global random numbers.

        Returns:
            ``physics``: the engine's state. ``objects``: the states of the environment, the scene, its entities, the
            managers and their terms, by name (:mod:`lift_lab.utils.saved_state`), as copies on the CPU and plain
            values. ``settings``: values that terms have changed in configurations. ``unsaved``: path and type of what
            cannot be written down (an iterator, an open file). ``version`` and ``num_envs``.
        """
        return env_state(self)

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Continue from a state of :meth:`state_dict`.

        Args:
            state: of this environment, or of another one with the same configuration.

        Raises:
            StateMismatchError: the environment holds other things than the state; names the first of them. The
                environment is unchanged then.
        """
        load_env_state(self, state)

    def _settings(self) -> dict[str, Any]:
        """The configurations that terms may change, by name. Those of scene, simulation and camera are used once."""
        used_once = ("scene", "sim", "viewer", "mirror")
        own = {name: value for name, value in vars(self.cfg).items() if name not in used_once}
        managers = {name: value.cfg for name, value in vars(self).items() if isinstance(value, ManagerBase)}
        return {"cfg": own, **{name: cfg for name, cfg in managers.items() if cfg is not None}}

    # -- running

    @staticmethod
    def seed(seed: int = -1) -> int:
        """Seed torch, numpy and random; -1 draws a seed. Returns the seed."""
        return configure_seed(seed)

    @in_any_grad_mode
    def reset(
        self,
        seed: int | None = None,
        env_ids: Sequence[int] | torch.Tensor | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[VecEnvObs, dict[str, Any]]:
        """Reset environments and observe.

        Args:
            seed: seed for all random numbers; None leaves them as they are.
            env_ids: environments to reset; None resets all.
            options: gymnasium's; not used.

        Returns:
            Observations of all environments, and extras.
        """
        ids = self._begin_reset(env_ids, seed)
        return self._after_reset(ids)

    def _begin_reset(self, env_ids: Sequence[int] | torch.Tensor | None, seed: int | None) -> torch.Tensor:
        ids = self._as_ids(env_ids)
        self.prefetched = {}  # of a step that raised
        self.recorder_manager.record_pre_reset(ids)
        if seed is not None:
            self.seed(seed)
        self._reset_idx(ids)
        return ids

    @in_any_grad_mode
    def reset_to(
        self,
        state: dict[str, dict[str, dict[str, torch.Tensor]]],
        env_ids: Sequence[int] | torch.Tensor | None,
        seed: int | None = None,
        is_relative: bool = False,
    ) -> tuple[VecEnvObs, dict[str, Any]]:
        """Reset environments, then put their assets into a state.

        Args:
            state: as ``scene.get_state()`` gives it, for the environments that are reset.
            env_ids: environments to reset; None resets all.
            seed: seed for all random numbers; None leaves them as they are.
            is_relative: whether positions in the state are relative to the environments' origins.

        Returns:
            Observations of all environments, and extras.
        """
        ids = self._begin_reset(env_ids, seed)
        self.scene.reset_to(state, ids, is_relative=is_relative)
        return self._after_reset(ids)

    @in_any_grad_mode
    def step(self, action: torch.Tensor | np.ndarray | Sequence[Any]) -> tuple[VecEnvObs, dict[str, Any]]:
        """Advance by one environment step.

        Args:
            action: shape (num_envs, action_dim).

        Returns:
            Observations and extras.

        Raises:
            ValueError: the action has another shape, or is not made of numbers.
        """
        self.action_manager.process_action(action_tensor(action, self.device))
        self.recorder_manager.record_pre_step()
        self._step_physics()
        if self._has_interval_events:
            self.event_manager.apply(mode="interval", dt=self.step_dt)
        self.obs_buf = self._observe()
        self.recorder_manager.record_post_step()
        return self.obs_buf, self.extras

    def close(self) -> None:
        """Close recordings and free the engine. May be called again; a closed environment cannot be used."""
        if self._is_closed:
            return
        self._is_closed = True
        recorder = getattr(self, "recorder_manager", None)
        if recorder is not None:
            recorder.close()
        self.sim.close()

    # -- parts of a step

    def _observe(self) -> VecEnvObs:
        """The observations that are returned."""
        self.step_cache = {}
        try:
            return self.observation_manager.compute(update_history=True)
        finally:
            self.step_cache = None

    def _step_physics(self) -> None:
        """Take ``decimation`` physics steps with the current actions; leaves the kinematics of the new state."""
        physics, decimation = self.sim.physics, self.cfg.decimation
        self._sim_step_counter += decimation
        if self._fuses_substeps:
            self.action_manager.apply_action()
            self.scene.write_data_to_sim()
            physics.step(decimation)
            self._check_health(physics)
            self.scene.update(dt=self.step_dt)
            return
        for _ in range(decimation):
            self.action_manager.apply_action()
            self.scene.write_data_to_sim()
            physics.step(1)
            self._check_health(physics)
            self.scene.update(dt=self.physics_dt)
            self.recorder_manager.record_post_physics_decimation_step()

    def _check_health(self, physics: Physics) -> None:
        """React to environments in which the physics failed."""

    def _reset_idx(self, env_ids: torch.Tensor) -> None:
        """Reset some environments; ``env_ids`` is a LongTensor. The kinematics are not refreshed."""
        self._reset_scene(env_ids)
        self.extras["log"] = {}
        for manager in (
            self.observation_manager,
            self.action_manager,
            self.event_manager,
            self.recorder_manager,
        ):
            self.extras["log"].update(manager.reset(env_ids))

    def _reset_scene(self, env_ids: torch.Tensor) -> None:
        """Reset the entities' buffers and apply reset events."""
        self.scene.reset(env_ids)
        if "reset" in self.event_manager.available_modes:
            step_count = self._sim_step_counter // self.cfg.decimation
            self.event_manager.apply(mode="reset", env_ids=env_ids, global_env_step_count=step_count)

    def _after_reset(self, env_ids: torch.Tensor) -> tuple[VecEnvObs, dict[str, Any]]:
        """What :meth:`reset` does once the state is written."""
        self.scene.start_episodes(env_ids)
        self._refresh(env_ids)
        self.recorder_manager.record_post_reset(env_ids)
        self.obs_buf = self._observe()
        return self.obs_buf, self.extras

    def _refresh(self, env_ids: torch.Tensor | None) -> None:
        """Make the kinematics of some environments current after their state was written."""
        everything = env_ids is None or len(env_ids) == self.num_envs
        self.sim.physics.refresh(None if everything else env_ids)
        self.scene.update(dt=0.0)

    def _as_ids(self, env_ids: Sequence[int] | torch.Tensor | None) -> torch.Tensor:
        if env_ids is None:
            return torch.arange(self.num_envs, device=self.device)
        return ids_tensor(env_ids, torch.device(self.device))

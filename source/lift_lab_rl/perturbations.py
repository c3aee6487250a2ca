"""Perturbations: how a task's configuration is changed to ask how far a policy reaches beyond its training.

Each fixes one thing that the policy met in one form only. Several may be combined:

- ``mass=2.0``: the object's mass and inertia times this factor.
- ``friction=0.5``: the sliding friction of every collider and soft body times this factor. (All of them, since a
  contact takes the larger coefficient of its two.)
- ``pose=1.5``: the object starts outside the range of its reset event, within that range times this factor about its
  middle, evenly over the area between the two.
- ``delay=0.01``: actions reach the actuators this many seconds late.

Randomisation by the task is off for a quantity that a perturbation fixes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import torch

from lift_lab.envs import mdp
from lift_lab.managers import ActionTermCfg, EventTermCfg, SceneEntityCfg
from lift_lab.utils.errors import ConfigError, suggest

_PREFIX = "perturbed_"
"""Start of the names of the event terms that a perturbation adds."""


def parse_perturbation(text: str) -> tuple[str, float]:
    """``"mass=2.0"`` as name and value.

    Raises:
        ConfigError: not of this form, an unknown name, or a value out of its range.
    """
    name, equals, value = text.partition("=")
    if name not in PERTURBATIONS:
        raise ConfigError(f"unknown perturbation '{name}': {suggest(name, PERTURBATIONS)}")
    try:
        number = float(value)
    except ValueError:
        number = math.nan
    least = {"pose": 1.0, "delay": 0.0}.get(name, 0.0)
    if not equals or not math.isfinite(number) or number < least or (number == least and name != "delay"):
        bound = "at least 0" if name == "delay" else f"above {least:g}"
        raise ConfigError(f"perturbation '{text}': expected {name}=NUMBER, {bound}")
    return name, number


def perturb(env_cfg: Any, text: str, object_name: str = "object") -> None:
    """Change an environment's configuration.

    Args:
        env_cfg: configuration of a manager-based environment.
        text: e.g. ``"mass=2.0"``.
        object_name: scene entity that ``mass`` and ``pose`` are about.

    Raises:
        ConfigError: the text cannot be read, or the task has nothing that it could change.
    """
    name, value = parse_perturbation(text)
    if name in ("mass", "pose") and getattr(env_cfg.scene, object_name, None) is None:
        raise ConfigError(f"perturbation '{text}': this task has no '{object_name}' to perturb")
    PERTURBATIONS[name](env_cfg, value, object_name)


def perturb_all(env_cfg: Any, texts: Sequence[str]) -> None:
    """Change an environment's configuration by several perturbations, which act together.

    Raises:
        ConfigError: as of :func:`perturb`, or one comes twice.
    """
    names = [parse_perturbation(text)[0] for text in texts]
    for name in names:
        if names.count(name) > 1:
            raise ConfigError(f"perturbation '{name}' is given twice")
    for text in texts:
        perturb(env_cfg, text)


# -- mass and friction


def _perturb_mass(env_cfg: Any, factor: float, object_name: str) -> None:
    _leave_out(env_cfg, (mdp.randomize_rigid_body_mass,), object_name)
    params = {
        "asset_cfg": SceneEntityCfg(object_name),
        "mass_distribution_params": (factor, factor),
        "operation": "scale",
    }
    _add_event(env_cfg, "mass", EventTermCfg(func=mdp.randomize_rigid_body_mass, mode="startup", params=params))


def _perturb_friction(env_cfg: Any, factor: float, _: str) -> None:
    _leave_out(env_cfg, (mdp.randomize_rigid_body_material,), None)
    event = EventTermCfg(func=mdp.scale_friction, mode="startup", params={"factor": factor})
    _add_event(env_cfg, "friction", event)


# -- pose


def _perturb_pose(env_cfg: Any, factor: float, object_name: str) -> None:
    for name, event in _events(env_cfg):
        asset = event.params.get("asset_cfg") if event is not None else None
        if event is not None and event.func in _OUTSIDE and asset and asset.name == object_name:
            changed = event.copy()
            changed.func = _OUTSIDE[event.func]
            changed.params = {**event.params, "factor": factor}
            _set_event(env_cfg, name, changed)
            return
    raise ConfigError(f"perturbation 'pose': no reset event of the task places '{object_name}' uniformly in a range")


_OUTSIDE: dict[Any, Callable[..., None]] = {
    mdp.reset_root_state_uniform: mdp.reset_root_state_outside,
    mdp.reset_nodal_state_uniform: mdp.reset_nodal_state_outside,
}
"""The event that replaces each reset event."""


# -- delay


def _perturb_delay(env_cfg: Any, delay_s: float, _: str) -> None:
    substeps = round(delay_s / env_cfg.sim.dt)
    if not math.isclose(substeps * env_cfg.sim.dt, delay_s, abs_tol=1e-9):
        raise ConfigError(
            f"perturbation 'delay={delay_s:g}': has to be a multiple of the physics step of {env_cfg.sim.dt:g} s"
        )
    terms = env_cfg.actions if isinstance(env_cfg.actions, dict) else vars(env_cfg.actions)
    for name, term in terms.items():
        if substeps and isinstance(term, ActionTermCfg):
            if not term.class_type.constant_over_substeps:
                raise ConfigError(
                    f"perturbation 'delay': action '{name}' ({term.class_type.__name__}) reads the state at every "
                    f"physics step; only actions that hold during an environment step can be delayed"
                )
            term.class_type = _delayed(term.class_type, substeps)


def _delayed(base: Any, substeps: int) -> type:
    """A sub-class of an action term whose targets arrive ``substeps`` physics steps late.

    Before an episode's first targets arrive, they are those of a zero action, as the action manager has it after a
    reset.
    """

    class Delayed(base):
        def __init__(self, cfg: Any, env: Any):
            super().__init__(cfg, env)
            self._queue = self._at_rest().repeat(substeps + 1, 1, 1)

        def process_actions(self, actions: torch.Tensor) -> None:
            super().process_actions(actions)
            self._newest = self._processed_actions.clone()

        def apply_actions(self) -> None:
            self._queue = self._queue.roll(1, 0)
            self._queue[0] = self._newest
            self._processed_actions = self._queue[-1]
            super().apply_actions()

        def reset(self, env_ids: Any = None) -> None:
            super().reset(env_ids)
            rows = slice(None) if env_ids is None else env_ids
            self._queue[:, rows] = self._at_rest()[rows]

        def _at_rest(self) -> torch.Tensor:
            """Targets of a zero action, which leaves the term as it is."""
            before = [(name, value, value.clone()) for name, value in vars(self).items() if torch.is_tensor(value)]
            super().process_actions(torch.zeros(self.num_envs, self.action_dim, device=self.device))
            targets = self._processed_actions.clone()
            for name, value, content in before:
                setattr(self, name, value.copy_(content))
            return targets

    Delayed.__name__ = Delayed.__qualname__ = f"Delayed{base.__name__}"
    return Delayed


# -- event terms of a configuration


def _events(env_cfg: Any) -> list[tuple[str, Any]]:
    events = env_cfg.events
    items = events.items() if isinstance(events, dict) else vars(events).items()
    return [(name, event) for name, event in items if event is None or isinstance(event, EventTermCfg)]


def _set_event(env_cfg: Any, name: str, event: EventTermCfg | None) -> None:
    if isinstance(env_cfg.events, dict):
        env_cfg.events[name] = event
    else:
        setattr(env_cfg.events, name, event)


def _add_event(env_cfg: Any, name: str, event: EventTermCfg) -> None:
    if env_cfg.events is None:
        env_cfg.events = {}
    _set_event(env_cfg, _PREFIX + name, event)


def _leave_out(env_cfg: Any, funcs: tuple[Any, ...], asset_name: str | None) -> None:
    """Remove the task's own event terms of these functions (of one asset, or of all)."""
    if env_cfg.events is None:
        return
    for name, event in _events(env_cfg):
        if event is not None and event.func in funcs:
            asset = event.params.get("asset_cfg")
            if asset_name is None or (asset is not None and asset.name == asset_name):
                _set_event(env_cfg, name, None)


PERTURBATIONS: dict[str, Callable[[Any, float, str], None]] = {
    "mass": _perturb_mass,
    "friction": _perturb_friction,
    "pose": _perturb_pose,
    "delay": _perturb_delay,
}
"""Perturbations by name."""

STANDARD = (
    *("mass=0.5", "mass=2.0", "friction=0.5", "friction=0.75", "friction=1.25", "friction=1.5"),
    *("pose=1.25", "pose=1.5", "delay=0.01"),
)
"""The perturbations of the generalisation table."""

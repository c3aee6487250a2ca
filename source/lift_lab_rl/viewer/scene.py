"""Layers of the live viewer's scene, and which of them are shown."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco

from lift_lab.envs.frame_capture import update_markers
from lift_lab.utils.errors import ConfigError, suggest
from lift_lab.visualizers import BodyLayer, Contact, ContactLayer, FrameLayer, MarkerLayer, World, contacts_of

from .camera import Camera


class ViewerScene:
    """The layers of the scene, the environment that is selected, and the camera."""

    def __init__(self, env: Any, server: Any):
        """Draw the bodies of all environments.

        Args:
            env: the environment without wrappers.
            server: the viser server.
        """
        self._env = env
        physics, origins_w = env.sim.physics, env.scene.env_origins
        self._physics = physics
        self.world = World(server)
        self.bodies = BodyLayer(server, physics, origins_w)
        self.markers = MarkerLayer(server, env.sim, origins_w)
        self.frames = FrameLayer(server, physics.model)
        self.contacts = ContactLayer(server, physics.model)
        self.camera = Camera(server, self.world, self.bodies, physics, origins_w)
        self.env_id = 0
        """The environment that is selected."""
        self.last_contacts: list[Contact] = []
        """Contacts of the selected environment when it was last drawn; empty unless they are shown."""
        self._data: mujoco.MjData | None = None
        self._switches: dict[str, Callable[[bool], None]] = {
            "visuals": self.bodies.show_visuals,
            "colliders": self.bodies.show_colliders,
            "only_env": self._show_only_env,
            "frames": self._show_frames,
            "contact_points": lambda _: None,
            "contact_forces": lambda _: None,
        }
        self.shown: dict[str, bool] = dict.fromkeys(self._switches, False) | {"visuals": True}
        """What can be shown and hidden -> whether it is shown."""
        for name, sources in _marker_sources(env).items():
            self._switches[name] = lambda shown, sources=sources: _set_debug_vis(sources, shown)
            self.shown[name] = any(source.cfg.debug_vis for source in sources)
        names = [physics.model.body(i).name or f"body_{i}" for i in range(physics.model.nbody)]
        self.body_names: list[str] = names
        """Names of all bodies of the compiled model."""
        self.moving: dict[str, int] = {
            name: i for i, name in enumerate(names) if i and physics.model.body_weldid[i] != 0
        }
        """Bodies that a camera can follow: name -> id."""
        self.default_body: str | None = self._default_body()
        """The body to follow unless another is chosen; None if nothing moves."""

    def _default_body(self) -> str | None:
        """Root of the first robot, its last body where the root is fixed; else the first body that moves."""
        for robot in self._env.scene.articulations.values():
            names = [self.body_names[i] for i in robot.engine_body_ids]
            moving = [name for name in names if name in self.moving]
            if moving:
                return moving[0] if moving[0] == names[0] else moving[-1]
        return next(iter(self.moving), None)

    def show(self, what: str, shown: bool) -> None:
        """Show or hide something.

        Raises:
            ConfigError: there is no such thing in this scene.
        """
        if what not in self._switches:
            raise ConfigError(f"the viewer cannot show '{what}'; {suggest(what, self._switches)}")
        self.shown[what] = bool(shown)
        self._switches[what](bool(shown))

    def select(self, env_id: int) -> None:
        """Select an environment: the cameras move there.

        Raises:
            ConfigError: there is no such environment.
        """
        num_envs = self._env.num_envs
        if env_id not in range(num_envs):
            raise ConfigError(f"there is no environment {env_id}; choose one from 0 to {num_envs - 1}")
        self.env_id = int(env_id)
        if self.shown["only_env"]:
            self._show_only_env(True)
        self.camera.select(self.env_id)

    def follow(self, name: str | None) -> None:
        """Keep a body of the selected environment in front of the cameras; None for nothing.

        Raises:
            ConfigError: no body that moves has this name.
        """
        if name is not None and name not in self.moving:
            raise ConfigError(f"no body '{name}' moves; {suggest(name, self.moving)}")
        self.camera.follow(None if name is None else self.moving[name], self.env_id)

    def draw(self) -> None:
        """Draw everything that is shown as it is now."""
        update_markers(self._env)
        self.bodies.update()
        self.markers.update()
        self._draw_state()
        self.camera.update(self.env_id)

    def _draw_state(self) -> None:
        """Draw what is computed from the whole state of the selected environment."""
        shown = self.shown
        with_contacts = shown["contact_points"] or shown["contact_forces"]
        self.last_contacts = []
        if not with_contacts:
            self.contacts.hide()
        if with_contacts or shown["frames"]:
            self._data = data = self._physics.get_data(self.env_id, self._data)
            origin_w = self._env.scene.env_origins[self.env_id].cpu().numpy()
            if shown["frames"]:
                self.frames.update(data, origin_w)
            if with_contacts:
                self.last_contacts = contacts_of(self._physics.model, data)
                self.contacts.update(self.last_contacts, origin_w, shown["contact_points"], shown["contact_forces"])

    def _show_only_env(self, only: bool) -> None:
        self.bodies.show_envs([self.env_id] if only else None)
        self.markers.show_env(self.env_id if only else None)

    def _show_frames(self, shown: bool) -> None:
        if not shown:
            self.frames.hide()


def _marker_sources(env: Any) -> dict[str, list[Any]]:
    """What draws markers, by kind, without kinds of which nothing does."""
    commands, actions = env.command_manager, env.action_manager
    kinds = {
        "commands": [commands.get_term(name) for name in commands.active_terms],
        "actions": [actions.get_term(name) for name in actions.active_terms],
        "sensors": list(env.scene.sensors.values()),
    }
    drawing = {kind: [one for one in found if one.has_debug_vis_implementation] for kind, found in kinds.items()}
    return {kind: found for kind, found in drawing.items() if found}


def _set_debug_vis(sources: list[Any], shown: bool) -> None:
    for source in sources:
        source.set_debug_vis(shown)

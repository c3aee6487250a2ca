"""Contact sensor.

Each body, and each pair of a body and a filter, is one MuJoCo ``contact`` sensor. It reports a number of contacts with
force and normal, and tangent and position if asked for. Contact forces belong to the last physics step.
"""

from __future__ import annotations

import dataclasses
import logging
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar

import mujoco
import torch

from lift_lab.utils.errors import ConfigError, PhysicsError
from lift_lab.utils.string import resolve_matching_names

from ..sensor_base import SensorBase, find_asset_by_prim_path, find_bodies_by_prim_path
from .contact_sensor_data import ContactSensorData

if TYPE_CHECKING:
    from lift_lab.sim.physics.base import Physics

    from .contact_sensor_cfg import ContactSensorCfg

_BODY, _GEOM, _ANYTHING = mujoco.mjtObj.mjOBJ_BODY, mujoco.mjtObj.mjOBJ_GEOM, mujoco.mjtObj.mjOBJ_UNKNOWN
_FIELD = mujoco.mjtConDataField
_MAXFORCE = 2
"""MuJoCo's ``reduce="maxforce"``: the strongest contacts first."""
_CONTACTS_OF_A_PAIR = 8
"""Contacts that two convex colliders have at most in MuJoCo."""
_MOST_CONTACTS = 64
"""Contacts that mujoco-warp matches with one sensor."""
_READS_BETWEEN_CHECKS = 1000
"""How often the readings of a GPU are searched for contacts that had no room: the host waits for the answer."""
_TIME_TOLERANCE = 1e-6
"""Least tolerance in s when an update period is compared with the time that has passed."""
_PERIOD_TOLERANCE = 0.05
"""The same as a part of the time between two updates: sums of float32 steps are off by far less."""
_WINDOW_TOLERANCE = 1e-4
"""Tolerance of the first-contact window as a part of the window. Sums of n float32 steps are off by up to n * 6e-8 of
their value, and the next step after the window lies 1 / n of it further: between the two up to 1,000 steps."""

_LOG = logging.getLogger(__name__)


class _Group:
    """Sensors of the same size, one for each entry of a (bodies, filters) table, read as one block."""

    def __init__(self, sensors: list[list[str]], slots: int, with_tangent: bool, with_position: bool):
        self.sensors = sensors  # the names that an entry sums; each ends in body or body:target
        self.slots = slots
        self.with_tangent = with_tangent
        self.with_position = with_position
        self.width = 7 + 3 * with_position + 3 * with_tangent
        self._reads, self._missing_told = 0, False

    @property
    def dataspec(self) -> int:
        """MuJoCo's bits of what each contact reports; the order in memory is that of the bits."""
        fields = [_FIELD.mjCONDATA_FOUND, _FIELD.mjCONDATA_FORCE, _FIELD.mjCONDATA_NORMAL]
        fields += [_FIELD.mjCONDATA_POS] if self.with_position else []
        fields += [_FIELD.mjCONDATA_TANGENT] if self.with_tangent else []
        return sum(1 << int(field) for field in fields)

    def find(self, model: mujoco.MjModel, device: torch.device) -> None:
        """Find the sensors' columns in the compiled model; entries with fewer sensors are filled with no column."""
        most = max(len(names) for names in self.sensors)
        size = self.slots * self.width
        columns = torch.full((len(self.sensors), most, size), -1, dtype=torch.long)
        for i, names in enumerate(self.sensors):
            for j, name in enumerate(names):
                start = int(model.sensor(name).adr[0])
                columns[i, j] = torch.arange(start, start + size)
        self._present = (columns >= 0).to(device)
        self._columns = columns.clamp(min=0).to(device)
        self._most_found = torch.zeros(len(self.sensors), most, device=device)

    def read(self, sensordata: torch.Tensor) -> dict[str, torch.Tensor]:
        """Contacts of each entry; shapes (N, entries, contacts, 3) by name. Absent contacts are zero."""
        values = sensordata[:, self._columns] * self._present
        if not self._missing_told:
            self._look_for_missing(values[..., 0])
        contacts = values.reshape(len(values), len(self.sensors), -1, self.width)
        parts = {"force": contacts[..., 1:4]}  # in the contact's frame
        start = 4
        for name, there in (("pos", self.with_position), ("normal", True), ("tangent", self.with_tangent)):
            if there:
                parts[name] = contacts[..., start : start + 3]
                start += 3
        return parts

    def _look_for_missing(self, found: torch.Tensor) -> None:
        """Say once which sensor had more contacts than it has room for; shape of ``found`` is (N, entries, sensors)."""
        self._most_found = torch.maximum(self._most_found, found.amax(dim=0))
        self._reads += 1
        if found.is_cuda and self._reads % _READS_BETWEEN_CHECKS:
            return
        most = int(self._most_found.max())
        if most <= self.slots:
            return
        entry, sensor = divmod(int(self._most_found.argmax()), self._most_found.shape[1])
        name, _, of = self.sensors[entry][sensor].partition("/")
        body, _, target = of.partition(":")
        _LOG.warning(
            "scene.%s: '%s' had %d contacts%s at once; the strongest %d of them count. "
            "max_contact_data_count_per_prim=%d counts %s",
            *(name, body, most, f" with '{target}'" if target else "", self.slots),
            *(min(most, _MOST_CONTACTS), "all" if most <= _MOST_CONTACTS else "as many as can be"),
        )
        self._missing_told = True


class ContactSensor(SensorBase):
    """Contact forces on bodies (Isaac Lab's ``ContactSensor``)."""

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"_bodies", "_body_ids", "_sensordata", "_targets"})

    cfg: ContactSensorCfg

    @property
    def data(self) -> ContactSensorData:
        """The readings of the last physics step; zero between a reset and the next step."""
        self._take()
        return self._data

    @property
    def num_bodies(self) -> int:
        """Number of bodies."""
        return len(self._bodies)

    @property
    def body_names(self) -> list[str]:
        """Names of the bodies."""
        return [body.split("/", 1)[-1] for body in self._bodies]

    @property
    def needs_every_substep(self) -> bool:
        """Histories and times are kept per physics step."""
        return self.cfg.history_length > 0 or self.cfg.track_air_time

    def find_bodies(self, name_keys: str | Sequence[str], preserve_order: bool = False) -> tuple[list[int], list[str]]:
        """Indices and names of the bodies that match regular expressions.

        Raises:
            ValueError: a pattern matches nothing, or a name matches two patterns.
        """
        return resolve_matching_names(name_keys, self.body_names, preserve_order)

    # -- building

    def build(self, spec: mujoco.MjSpec, name: str, prim_paths: Mapping[str, str]) -> None:
        """Add a MuJoCo sensor for each body, and for each pair of body and filter.

        Raises:
            ConfigError: a prim path that nothing answers to, or contact points or friction without filters.
        """
        super().build(spec, name, prim_paths)
        cfg, where = self.cfg, f"scene.{name}"
        if (cfg.track_contact_points or cfg.track_friction_forces) and not cfg.filter_prim_paths_expr:
            raise ConfigError(f"{where}: contact points and friction forces need filter_prim_paths_expr")
        self._bodies = find_bodies_by_prim_path(spec, prim_paths, cfg.prim_path, f"{where}.prim_path")
        self._targets: list[list[tuple[mujoco.mjtObj, str]]] = []
        for i, path in enumerate(cfg.filter_prim_paths_expr):
            self._targets += _filter_targets(spec, prim_paths, path, f"{where}.filter_prim_paths_expr[{i}]")
        colliders = [sum(bool(g.contype or g.conaffinity) for g in spec.body(body).geoms) for body in self._bodies]
        of_pair = max(cfg.max_contact_data_count_per_prim, _CONTACTS_OF_A_PAIR * max(colliders))
        slots = min(of_pair, _MOST_CONTACTS)
        net_slots = min(2 * of_pair, _MOST_CONTACTS)  # a body between two others
        self._net = _Group([[f"{name}/{body}"] for body in self._bodies], net_slots, False, False)
        self._pairs: _Group | None = None
        for body in self._bodies:
            _add_sensor(spec, f"{name}/{body}", body, (_ANYTHING, ""), self._net)
        if self._targets:
            table: list[list[str]] = []
            self._pairs = _Group(table, slots, cfg.track_friction_forces, cfg.track_contact_points)
            for body in self._bodies:
                for objects in self._targets:
                    table.append([f"{name}/{body}:{target}" for _, target in objects])
                    for sensor, target in zip(table[-1], objects, strict=True):
                        _add_sensor(spec, sensor, body, target, self._pairs)

    def initialize(self, physics: Physics, env_origins_w: torch.Tensor) -> None:
        """Find the sensors in the compiled model and make the buffers."""
        super().initialize(physics, env_origins_w)
        model, device = physics.model, physics.device
        self._net.find(model, device)
        if self._pairs is not None:
            self._pairs.find(model, device)
        self._sensordata = physics.field("sensordata")
        self._body_ids = torch.tensor([model.body(body).id for body in self._bodies], device=device)
        self._elapsed = torch.zeros(physics.num_envs, device=device)
        self._outdated = False
        shape, length = (physics.num_envs, len(self._bodies)), max(self.cfg.history_length, 1)
        net = torch.zeros(*shape, 3, device=device)
        self._data = data = ContactSensorData(net, net[:, None].repeat(1, length, 1, 1))
        data.entity_name = self.name
        if self._pairs is not None:
            data.force_matrix_w = torch.zeros(*shape, len(self._targets), 3, device=device)
            data.force_matrix_w_history = data.force_matrix_w[:, None].repeat(1, length, 1, 1, 1)
            if self.cfg.track_friction_forces:
                data.friction_forces_w = torch.zeros_like(data.force_matrix_w)
            if self.cfg.track_contact_points:
                data.contact_pos_w = torch.full_like(data.force_matrix_w, float("nan"))
        self._update_dt = 0.0
        self._contact_age: torch.Tensor | None = None  # time since contact began, also between readings
        self._air_age: torch.Tensor | None = None
        if self.cfg.track_air_time:
            data.current_air_time, data.last_air_time = torch.zeros(2, *shape, device=device)
            data.current_contact_time, data.last_contact_time = torch.zeros(2, *shape, device=device)
            if self.cfg.update_period > 0:
                self._contact_age, self._air_age = torch.zeros(2, *shape, device=device)
        self._read_poses()

    # -- stepping

    def reset(self, env_ids: Sequence[int] | torch.Tensor | slice | None = None) -> None:
        """Set readings, histories and times of some environments to zero."""
        self._take()
        rows = slice(None) if env_ids is None else env_ids
        data = self._data
        for field in dataclasses.fields(data):
            value = getattr(data, field.name)
            if value is not None:
                value[rows] = 0.0
        if data.contact_pos_w is not None:
            data.contact_pos_w[rows] = float("nan")
        self._elapsed[rows] = 0.0
        if self._contact_age is not None and self._air_age is not None:
            self._contact_age[rows] = 0.0
            self._air_age[rows] = 0.0
        self._read_poses()

    def update(self, dt: float, force_recompute: bool = False) -> None:
        """Take note of a physics step; histories and times are kept now, the rest is read on demand."""
        self._elapsed += dt
        self._outdated |= dt > 0
        if dt > 0:
            self._update_dt = dt
        if dt == 0:
            self._read_poses()
        elif force_recompute or self.needs_every_substep:
            self._take()

    def compute_first_contact(self, dt: float, abs_tol: float = 1.0e-8) -> torch.Tensor:
        """Whether each body is in contact and came into it within the last ``dt`` seconds, shape (N, B).

        Called once every ``dt`` seconds it reports each landing once, for any number of physics steps in ``dt``. With
        an update period a landing counts from the reading that shows it. The first reading after a reset counts as a
        landing where the body touches something. A contact that ended again before the call is not reported.

        Args:
            dt: length of the time window in s, a multiple of the physics step (usually ``env.step_dt``).
            abs_tol: tolerance in s; at least 1e-4 of ``dt`` is used.

        Raises:
            PhysicsError: the config does not track times.
        """
        time = self._times().current_contact_time
        return self._began_within(time if self._contact_age is None else self._contact_age, dt, abs_tol)

    def compute_first_air(self, dt: float, abs_tol: float = 1.0e-8) -> torch.Tensor:
        """Whether each body is in the air and lost contact within the last ``dt`` seconds, shape (N, B).

        Windows and tolerances are those of :meth:`compute_first_contact`.

        Args:
            dt: length of the time window in s, a multiple of the physics step (usually ``env.step_dt``).
            abs_tol: tolerance in s; at least 1e-4 of ``dt`` is used.

        Raises:
            PhysicsError: the config does not track times.
        """
        time = self._times().current_air_time
        return self._began_within(time if self._air_age is None else self._air_age, dt, abs_tol)

    def _times(self) -> ContactSensorData:
        if not self.cfg.track_air_time:
            raise PhysicsError(f"scene.{self.name}: times are not tracked; set track_air_time")
        return self.data

    @staticmethod
    def _began_within(time: torch.Tensor | None, dt: float, abs_tol: float) -> torch.Tensor:
        """Whether a state that has lasted ``time`` (0: not that state) began in the last ``dt`` seconds."""
        assert time is not None
        return (time > 0.0) & (time < dt + max(abs_tol, _WINDOW_TOLERANCE * dt))

    # -- reading

    def _take(self) -> None:
        """Read the engine, in environments in which ``update_period`` has passed, if it moved on since."""
        if not self._outdated:
            return
        self._outdated = False
        tolerance = max(_TIME_TOLERANCE, _PERIOD_TOLERANCE * self._update_dt)
        due = self._elapsed + tolerance >= self.cfg.update_period
        elapsed = self._elapsed.clone()
        self._elapsed.masked_fill_(due, 0.0)
        self._read_forces(due)
        if self.cfg.track_air_time:
            self._count_times(due, elapsed[:, None])
        self._read_poses()

    def _read_forces(self, due: torch.Tensor) -> None:
        data = self._data
        contacts = self._net.read(self._sensordata)
        # a contact's force acts on the other object, along the normal away from the body
        net = -(contacts["force"][..., :1] * contacts["normal"]).sum(dim=-2)
        _put(data.net_forces_w, net, due)
        _push(data.net_forces_w_history, net, due)
        if self._pairs is None:
            return
        contacts = self._pairs.read(self._sensordata)
        force, normal = contacts["force"], contacts["normal"]
        shape = (len(due), len(self._bodies), len(self._targets), 3)
        matrix = -(force[..., :1] * normal).sum(dim=-2).view(shape)
        _put(data.force_matrix_w, matrix, due)
        _push(data.force_matrix_w_history, matrix, due)
        if data.friction_forces_w is not None:
            first = contacts["tangent"]
            second = torch.linalg.cross(normal, first)
            friction = -(force[..., 1:2] * first + force[..., 2:3] * second).sum(dim=-2)
            _put(data.friction_forces_w, friction.view(shape), due)
        if data.contact_pos_w is not None:
            there = (normal != 0).any(dim=-1, keepdim=True)
            mean = (contacts["pos"] * there).sum(dim=-2) / there.sum(dim=-2)  # 0 / 0 is NaN
            _put(data.contact_pos_w, mean.view(shape) + self._env_origins_w[:, None, None], due)

    def _count_times(self, due: torch.Tensor, elapsed: torch.Tensor) -> None:
        data = self._data
        air, contact = data.current_air_time, data.current_contact_time
        assert air is not None
        assert contact is not None
        touching = data.net_forces_w.norm(dim=-1) > self.cfg.force_threshold
        landed, left = (air > 0) & touching, (contact > 0) & ~touching
        _put(data.last_air_time, air + elapsed, due[:, None] & landed)
        _put(data.last_contact_time, contact + elapsed, due[:, None] & left)
        _put(air, torch.where(touching, 0.0, air + elapsed), due)
        _put(contact, torch.where(touching, contact + elapsed, 0.0), due)
        if self._contact_age is not None and self._air_age is not None:
            self._count_ages(self._contact_age, touching, due)
            self._count_ages(self._air_age, ~touching, due)

    def _count_ages(self, age: torch.Tensor, there: torch.Tensor, due: torch.Tensor) -> None:
        """Let time pass in ``age`` between readings too; a reading starts it (at one update) or sets it to zero."""
        age += torch.where(age > 0, self._update_dt, 0.0)
        started = torch.where(age > 0, age, self._update_dt)
        _put(age, torch.where(there, started, 0.0), due)

    def _read_poses(self) -> None:
        if self.cfg.track_pose:
            self._data.pos_w = self._physics.current("xpos")[:, self._body_ids] + self._env_origins_w[:, None]
            self._data.quat_w = self._physics.current("xquat")[:, self._body_ids]


def _filter_targets(
    spec: mujoco.MjSpec, prim_paths: Mapping[str, str], path: str, where: str
) -> list[list[tuple[mujoco.mjtObj, str]]]:
    """What a filter's prim path means: one entry for each body, or one for all colliders of what is static."""
    asset, _ = find_asset_by_prim_path(prim_paths, path, where)
    if any(body.name.startswith(f"{asset}/") for body in spec.bodies):
        return [[(_BODY, body)] for body in find_bodies_by_prim_path(spec, prim_paths, path, where)]
    colliders = [g for g in spec.worldbody.geoms if g.name.startswith(f"{asset}/") and (g.contype or g.conaffinity)]
    if not colliders:
        raise ConfigError(f"{where}: '{path}' has no collider")
    return [[(_GEOM, geom.name) for geom in colliders]]


def _add_sensor(spec: mujoco.MjSpec, name: str, body: str, target: tuple[mujoco.mjtObj, str], group: _Group) -> None:
    kind, other = target
    spec.add_sensor(
        name=name,
        type=mujoco.mjtSensor.mjSENS_CONTACT,
        objtype=_BODY,
        objname=body,
        reftype=kind,
        refname=other,
        intprm=[group.dataspec, _MAXFORCE, group.slots],
    )


def _put(buffer: torch.Tensor | None, values: torch.Tensor, where: torch.Tensor) -> None:
    """Write ``values`` into ``buffer`` where the mask, over its first dimensions, is set."""
    assert buffer is not None
    mask = where.view(*where.shape, *[1] * (buffer.dim() - where.dim()))
    buffer.copy_(torch.where(mask, values, buffer))


def _push(history: torch.Tensor | None, values: torch.Tensor, due: torch.Tensor) -> None:
    """Put ``values`` in front of a history of shape (N, T, ...) in environments that are due."""
    assert history is not None
    _put(history, torch.cat((values[:, None], history[:, :-1]), dim=1), due)

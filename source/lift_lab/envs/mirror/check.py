"""Check of a declared mirror symmetry on states of the environment.

Random states of the first environment and their mirror images are written, one after the other. Then the bodies'
places and velocities, the joints' targets and the observations have to be mirror images, too.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
import torch

from lift_lab.envs.grad_mode import in_any_grad_mode
from lift_lab.utils import math as math_utils
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.mirror import KINDS, MirrorMap
from lift_lab.utils.string import resolve_matching_names

from .task_mirror import TaskMirror

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedEnv

SAMPLES = 4
"""States that are compared. A number is wrong if it is in most of them: some terms jump, such as an angle at pi."""

TOLERANCE = 1e-3
"""Largest difference, relative to the largest number of a term."""

_JOINT_STEP, _POS_STEP, _TURN, _SPEED = 0.2, 0.1, 0.5, 1.0
"""Size of the random changes of joints (of their range, at most of 1), positions in m, rotations in rad, velocities."""


class _Compared:
    """Numbers of some states and of their images, which a map has to connect."""

    def __init__(self, image: MirrorMap, names: list[str], advice: str):
        self.image, self.names, self.advice = image, names, advice
        self.values: tuple[list[torch.Tensor], list[torch.Tensor]] = ([], [])

    def check(self, path: str) -> None:
        """Compare the numbers; those that no state changes say nothing.

        Raises:
            ConfigError: one is not as the map says.
        """
        given, found = (torch.stack(rows).double().cpu() for rows in self.values)
        expected = self.image(given)
        size = torch.cat([expected, found]).abs().max().clamp(min=1e-6)
        moves = (given != given[:1]).any(0) | (found != found[:1]).any(0)
        moves = moves | moves[self.image.index]
        off = ((expected - found).abs() > TOLERANCE * size) | ~torch.isfinite(expected - found)
        wrong = (off.sum(0) * 2 > len(off)) & moves
        if not wrong.any():
            return
        i = int(wrong.nonzero()[0, 0])
        row = int(off[:, i].nonzero()[0, 0])
        name = f" ({self.names[i]})" if i < len(self.names) else ""
        raise ConfigError(
            f"{path}: number {i}{name} does not mirror as declared: it is {found[row, i]:.4g} in a mirrored state, "
            f"{expected[row, i]:.4g} was expected. {self.advice}"
        )


@in_any_grad_mode
def check_mirror(env: ManagerBasedEnv, groups: Iterable[str]) -> None:
    """Compare states of an environment with their mirror images, and put everything back.

    Global random numbers are not used here; a term may draw some.

    Args:
        env: the environment; it has a declaration, ``env.cfg.mirror``.
        groups: observation groups to compare.

    Raises:
        ConfigError: the declaration is wrong; names the first term and number that differ.
    """
    mirror = TaskMirror(env)
    compared = _what_to_compare(mirror, groups)
    before = env.state_dict()
    try:
        generator = torch.Generator().manual_seed(0)
        for _ in range(SAMPLES):
            sample = _Sample(mirror, generator)
            for side in (0, 1):
                sample.write(side)
                for path, row in _rows(mirror, compared):
                    compared[path].values[side].append(row)
    finally:
        env.load_state_dict(before)
    for path, one in compared.items():
        one.check(path)


class _Sample:
    """A random state, commands and actions of the first environment, and the mirror image of each."""

    def __init__(self, mirror: TaskMirror, generator: torch.Generator):
        self._mirror, self._generator = mirror, generator
        env: Any = mirror.env
        pose, velocity = MirrorMap.of(KINDS["pose"]), MirrorMap.of(KINDS["twist"])
        point = MirrorMap.of(KINDS["vector"])
        self._states: list[dict[str, dict[str, dict[str, torch.Tensor]]]] = [{}, {}]
        for kind, group in env.scene.get_state(is_relative=True).items():
            for name, entry in group.items():
                given = {key: value[:1].clone() for key, value in entry.items()}
                self._move(given)
                image = dict(given)
                if "joint_position" in given and name in mirror.cfg.assets:
                    joints = mirror.joints(name)
                    self._move_joints(given, joints.asset)
                    image["joint_position"] = _image(joints.positions, given["joint_position"])
                    image["joint_velocity"] = _image(joints.columns(slice(None), False), given["joint_velocity"])
                if "root_pose" in given:
                    image["root_pose"] = _image(pose, given["root_pose"])
                    image["root_velocity"] = _image(velocity, given["root_velocity"])
                else:
                    image |= {key: _image(point, value) for key, value in given.items()}
                for state, side in zip(self._states, (given, image), strict=True):
                    state.setdefault(kind, {})[name] = side
        self._commands = {
            name: self._both(image, env.command_manager.get_command(name)[:1])
            for name, image in _known_commands(mirror).items()
        }
        zero = torch.zeros(1, env.action_manager.total_action_dim)
        self._actions = [self._both(mirror.actions(), zero) for _ in range(2)]

    def write(self, side: int) -> None:
        """Put the state (0) or its image (1) into the first environment, and act."""
        env: Any = self._mirror.env
        first = torch.zeros(1, dtype=torch.long, device=env.device)
        env.scene.reset_to(_on(env.device, self._states[side]), first, is_relative=True)
        env.action_manager.reset(env_ids=first)
        env.sim.physics.refresh(first)
        env.scene.update(0.0)
        for name, sides in self._commands.items():
            env.command_manager.get_command(name)[0] = sides[side].to(env.device)[0]
        for sides in self._actions:
            action = torch.zeros(env.num_envs, sides[side].shape[1], device=env.device)
            action[0] = sides[side].to(env.device)[0]
            env.action_manager.process_action(action)
        env.action_manager.apply_action()

    def _both(self, image: MirrorMap, values: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Changed numbers, shape (1, dim), and their image."""
        changed = values.cpu() + 0.3 * self._normal(values.shape)
        return changed, _image(image, changed)

    def _move(self, entry: dict[str, torch.Tensor]) -> None:
        """Move roots and nodes of an asset."""
        if "root_pose" in entry:
            pose = entry["root_pose"].cpu()
            axis = self._normal((1, 3))
            turn = math_utils.quat_from_angle_axis(torch.full((1,), _TURN), axis / axis.norm())
            pose[:, :3] += _POS_STEP * self._normal((1, 3))
            pose[:, 3:] = math_utils.quat_mul(turn, pose[:, 3:])
            entry["root_pose"], entry["root_velocity"] = pose, _SPEED * self._normal((1, 6))
        else:
            entry["nodal_position"] = entry["nodal_position"].cpu() + _POS_STEP * self._normal((1, 1, 3))
            entry["nodal_velocity"] = (_SPEED * self._normal((1, 1, 3))).expand_as(entry["nodal_position"])

    def _move_joints(self, entry: dict[str, torch.Tensor], asset: Any) -> None:
        limits = asset.data.soft_joint_pos_limits[:1].cpu()
        room = (limits[..., 1] - limits[..., 0]).clamp(max=1.0)
        entry["joint_position"] = entry["joint_position"].cpu() + _JOINT_STEP * room * self._uniform(room.shape)
        entry["joint_velocity"] = _SPEED * self._normal(room.shape)

    def _normal(self, shape: tuple[int, ...]) -> torch.Tensor:
        return torch.randn(shape, generator=self._generator)

    def _uniform(self, shape: tuple[int, ...]) -> torch.Tensor:
        return 2.0 * torch.rand(shape, generator=self._generator) - 1.0


def _what_to_compare(mirror: TaskMirror, groups: Iterable[str]) -> dict[str, _Compared]:
    """Everything that is compared, by path; what others follow from comes first."""
    found: dict[str, _Compared] = {}
    for name, cfg in mirror.cfg.assets.items():
        joints, asset = mirror.joints(name), mirror.env.scene[name]
        advice = f"Correct signs, swaps and offsets of env.mirror.assets.{name}, or leave bodies out of checked_bodies."
        _, bodies = resolve_matching_names(cfg.checked_bodies, asset.body_names)
        partners = joints.partners(bodies)
        for what, kind, axes in (("positions", "vector", "xyz"), ("velocities", "twist", "xyzXYZ")):
            one = MirrorMap.of(KINDS[kind])
            image = one.of_parts(partners)
            names = [f"{axis} of {body}" for body in bodies for axis in axes]
            found[f"env.scene.{name}: the bodies' {what}"] = _Compared(image, names, advice)
        advice = "Correct env.mirror.actions, or the joints of env.mirror.assets."
        for what, moves in (("position", True), ("velocity", False), ("effort", False)):
            image = joints.columns(slice(None), moves)
            found[f"env.scene.{name}: the joints' {what} targets"] = _Compared(image, asset.joint_names, advice)
    for group in groups:
        mirror.group(group)
        for name in mirror.env.observation_manager.active_terms[group]:
            advice = f"Declare it: env.mirror.observations.{name}."
            image = mirror.observation(group, name)
            found[f"env.observations.{group}.{name}"] = _Compared(image, [], advice)
    return found


def _rows(mirror: TaskMirror, compared: dict[str, _Compared]) -> list[tuple[str, torch.Tensor]]:
    """The numbers of the first environment, by path."""
    env: Any = mirror.env
    rows: dict[str, torch.Tensor] = {}
    for name, cfg in mirror.cfg.assets.items():
        data = env.scene[name].data
        ids, _ = resolve_matching_names(cfg.checked_bodies, env.scene[name].body_names)
        positions, velocities = _motion(env, [env.scene[name].engine_body_ids[i] for i in ids])
        rows[f"env.scene.{name}: the bodies' positions"] = positions
        rows[f"env.scene.{name}: the bodies' velocities"] = velocities
        targets = {"position": data.joint_pos_target, "velocity": data.joint_vel_target}
        targets["effort"] = data.joint_effort_target
        for what, values in targets.items():
            rows[f"env.scene.{name}: the joints' {what} targets"] = values[0].clone()
    manager = env.observation_manager
    for path in compared.keys() - rows.keys():
        group, name = path.removeprefix("env.observations.").split(".")
        rows[path] = manager.clean_value(group, name)[0].clone()
    return list(rows.items())


def _motion(env: Any, bodies: list[int]) -> tuple[torch.Tensor, torch.Tensor]:
    """Positions and velocities of bodies of the first environment, each in one row.

    They are computed here: a field of the engine that is asked for is kept current from then on, which costs time.
    """
    model, data = env.sim.model, env.sim.physics.get_data(0)
    angular, of_com = data.cvel[bodies, :3], data.cvel[bodies, 3:]
    arm = data.xpos[bodies] - data.subtree_com[model.body_rootid[bodies]]
    velocities = np.concatenate([of_com + np.cross(angular, arm), angular], axis=1)
    return torch.from_numpy(data.xpos[bodies].flatten()), torch.from_numpy(velocities.flatten())


def _known_commands(mirror: TaskMirror) -> dict[str, MirrorMap]:
    """Maps of the commands that can be set; a command that no observation shows needs no declaration."""
    env: Any = mirror.env
    found = {}
    for name in env.command_manager.active_terms if hasattr(env, "command_manager") else ():
        try:
            found[name] = mirror.command(name)
        except ConfigError:
            continue
    return found


def _image(image: MirrorMap, values: torch.Tensor) -> torch.Tensor:
    return image.to("cpu")(values.cpu())


def _on(device: str, state: dict[str, Any]) -> dict[str, Any]:
    return {
        key: value.to(device) if isinstance(value, torch.Tensor) else _on(device, value) for key, value in state.items()
    }

"""Metadata with which a program runs an exported policy: ``policy.onnx`` and ``policy.pt``.

The keys are listed in docs/deploy.md. Those that mjlab's exporter writes, too, have its names and its form: lists
separated by commas. Everything that is nested is JSON.
"""

from __future__ import annotations

import inspect
import json
import math
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import torch

import lift_lab
from lift_lab.envs.utils.io_descriptors import export_articulations_data
from lift_lab.utils.io_descriptors import formatted, plain

from .checkpoint_file import read_checkpoint

if TYPE_CHECKING:
    from rsl_rl.models import MLPModel

    from lift_lab.envs import ManagerBasedRLEnv

    from .vecenv_wrapper import RslRlVecEnvWrapper

FORMAT = "1"
"""Version of the keys: raised when the meaning of one changes."""

_NOT_OF_COMMANDS = ("class_type", "debug_vis")


def policy_metadata(env: RslRlVecEnvWrapper, policy: MLPModel, checkpoint: str | Path | None = None) -> dict[str, str]:
    """Return the metadata of an exported policy, as texts by key.

    Args:
        env: the environment that the policy acts in.
        policy: the actor.
        checkpoint: the file that the policy is from; None if it is from none.

    Raises:
        FileError: the checkpoint cannot be read.
    """
    inner = env.unwrapped
    observations, actions, commands = _observations(inner, policy), _actions(inner), _commands(inner)
    assets = _assets(inner)
    robot = assets.get(actions[0].get("asset", ""), {}) if actions else {}
    found: dict[str, Any] = {
        "format": FORMAT,
        "lift_lab_version": lift_lab.__version__,
        "task": "" if inner.spec is None else inner.spec.id,
        "step_dt": inner.step_dt,
        "physics_dt": inner.physics_dt,
        "decimation": inner.cfg.decimation,
        "episode_length_s": inner.max_episode_length_s,
        "quaternion_order": "wxyz",
        "observation_normalizer": "inside" if policy.obs_normalization else "none",
        "is_recurrent": bool(policy.is_recurrent),
        "clip_actions": env.clip_actions,
        "observations": observations,
        "actions": actions,
        "commands": commands,
        "assets": assets,
        "observation_names": _csv(term["name"] for term in observations),
        "command_names": _csv(term["name"] for term in commands),
        "action_scale": _csv(number for term in actions for number in _each(term, "scale", 1.0)),
        "action_offset": _csv(number for term in actions for number in _each(term, "offset", 0.0)),
    }
    for key, name in (
        ("joint_names", "joint_names"),
        ("default_joint_pos", "default_joint_pos"),
        ("joint_stiffness", "default_joint_stiffness"),
        ("joint_damping", "default_joint_damping"),
    ):
        if name in robot:
            found[key] = _csv(robot[name])
    if checkpoint is not None:
        checkpoint = Path(checkpoint)
        found |= {
            "run_path": checkpoint.parent.name,
            "checkpoint": checkpoint.name,
            "iteration": read_checkpoint(checkpoint, "cpu").get("iter", ""),
        }
    return {key: value if isinstance(value, str) else json.dumps(_finite(value)) for key, value in found.items()}


def _observations(env: ManagerBasedRLEnv, policy: MLPModel) -> list[dict[str, Any]]:
    """The terms of the policy's groups, in the order of its input."""
    manager, start = env.observation_manager, 0
    found = []
    for group in policy.obs_groups:
        names, shapes = manager.active_terms[group], manager.group_obs_term_dim[group]
        cfgs = manager.group_obs_term_cfgs[group]
        for name, shape, cfg in zip(names, shapes, cfgs, strict=True):
            described = manager.describe_term(group, name)
            extras, size = described.pop("extras"), math.prod(shape)
            extras.pop("description")
            function = described.pop("name")
            entry = {"name": name, "group": group, "function": function, "start": start, "size": size}
            found.append(entry | {"params": _parameters(env, cfg)} | described.pop("overloads") | extras | described)
            start += size
    return found


def _parameters(env: ManagerBasedRLEnv, cfg: Any) -> dict[str, Any]:
    """Arguments of an observation term, with the defaults of those that its config does not give."""
    defaults = inspect.signature(cfg.func).parameters.values()
    given = {p.name: p.default for p in defaults if p.default is not p.empty} | cfg.params
    return {key: _parameter(env, value) for key, value in given.items()}


def _parameter(env: ManagerBasedRLEnv, value: Any) -> Any:
    """An argument of a term; of a scene entity its name and the names of the chosen joints and bodies."""
    from lift_lab.managers import SceneEntityCfg

    if not isinstance(value, SceneEntityCfg):
        return plain(value)
    found: dict[str, Any] = {"name": value.name}
    entity = env.scene[value.name]
    for key, ids in (("joint_names", value.joint_ids), ("body_names", value.body_ids)):
        if ids != slice(None):
            names = getattr(entity, key)
            found[key] = names[ids] if isinstance(ids, slice) else [names[i] for i in ids]
    return found


def _actions(env: ManagerBasedRLEnv) -> list[dict[str, Any]]:
    """The action terms, in the order of the policy's output."""
    manager, start, found = env.action_manager, 0, []
    for name, size in zip(manager.active_terms, manager.action_term_dim, strict=True):
        term = manager.get_term(name)
        described = formatted(term.IO_descriptor)
        extras = described.pop("extras", {})
        extras.pop("description", None)
        entry = {"name": name, "class": described.pop("name", type(term).__name__), "start": start, "size": size}
        found.append(entry | {"asset": term.cfg.asset_name} | described | extras)
        start += size
    return found


def _commands(env: ManagerBasedRLEnv) -> list[dict[str, Any]]:
    """The command terms: how long each is, and what it is drawn from."""
    found = []
    for name in env.command_manager.active_terms:
        term = env.command_manager.get_term(name)
        settings = {
            key: plain(value)
            for key, value in vars(term.cfg).items()
            if key not in _NOT_OF_COMMANDS and not key.endswith("visualizer_cfg")
        }
        entry = {"name": name, "class": type(term).__name__, "size": int(term.command.shape[-1])}
        found.append(entry | settings)
    return found


def _assets(env: ManagerBasedRLEnv) -> dict[str, dict[str, Any]]:
    """What moves in the scene, by name, with the body of ``scene.xml`` that is its root."""
    found: dict[str, dict[str, Any]] = {}
    joints = export_articulations_data(env)
    for name, asset in env.scene.articulations.items():
        groups = {
            group: {
                "class": type(actuator).__name__,
                "is_implicit": actuator.is_implicit_model,
                "joint_names": list(actuator.joint_names),
            }
            for group, actuator in asset.actuators.items()
        }
        limits = plain(asset.data.joint_effort_limits[0])
        found[name] = {"type": "articulation", "root_body": _root_body(env, name)}
        found[name] |= {"joint_effort_limits": limits, "actuators": groups} | joints[name]
    for name in env.scene.rigid_objects:
        found[name] = {"type": "rigid_object", "root_body": _root_body(env, name)}
    found |= {name: {"type": "deformable_object"} for name in env.scene.deformable_objects}
    return found


def _root_body(env: ManagerBasedRLEnv, asset: str) -> str:
    """Name that the root of an asset has in the model."""
    model = env.sim.model
    names = [model.body(body).name for body in range(model.nbody)]
    mine = [name.startswith(f"{asset}/") for name in names]
    return next(names[body] for body in range(model.nbody) if mine[body] and not mine[model.body_parentid[body]])


def _each(term: dict[str, Any], key: str, default: float) -> list[float]:
    """A number of an action term for each of its entries."""
    value = term.get(key)
    values = [default if value is None else value] if not isinstance(value, list) else value
    return values * term["size"] if len(values) == 1 else values


def _csv(values: Iterable[Any]) -> str:
    return ",".join(str(value) for value in values)


def _finite(value: Any) -> Any:
    """The value with None instead of infinite numbers, which JSON does not have."""
    if isinstance(value, dict):
        return {key: _finite(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(entry) for entry in value]
    if isinstance(value, torch.Tensor):
        return _finite(plain(value))
    return None if isinstance(value, float) and not math.isfinite(value) else value

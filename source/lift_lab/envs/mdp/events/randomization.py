"""Event terms that randomise the physics: masses, friction, gains, joints, gravity.

Each event starts from the original values, never from values that were already randomised.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal

import torch

from lift_lab.managers import ManagerTermBase, SceneEntityCfg
from lift_lab.sim.ignored import note_ignored
from lift_lab.utils import math as math_utils
from lift_lab.utils.errors import ConfigError, suggest
from lift_lab.utils.indexing import EnvIds, block, num_rows
from lift_lab.utils.ranges import COUNT, FINITE, POSITIVE, POSITIVE_SPAN, SPAN

from ..sampling import axis_ranges, sample_ranges

if TYPE_CHECKING:
    from lift_lab.assets import Articulation, RigidObject
    from lift_lab.envs import ManagerBasedEnv
    from lift_lab.managers import EventTermCfg

__all__ = [
    "randomize_actuator_gains",
    "randomize_joint_parameters",
    "randomize_physics_scene_gravity",
    "randomize_rigid_body_collider_offsets",
    "randomize_rigid_body_com",
    "randomize_rigid_body_mass",
    "randomize_rigid_body_material",
    "scale_friction",
]

Operation = Literal["add", "scale", "abs"]
Distribution = Literal["uniform", "log_uniform", "gaussian"]

_OPERATIONS = ("add", "scale", "abs")
_SAMPLERS = {
    "uniform": math_utils.sample_uniform,
    "log_uniform": math_utils.sample_log_uniform,
    "gaussian": math_utils.sample_gaussian,
}


def _vary(
    default: torch.Tensor,
    parameters: tuple[Any, Any],
    operation: str,
    distribution: str,
) -> torch.Tensor:
    """``default`` plus, times or replaced by random values, one for each element.

    Args:
        default: the values at start.
        parameters: (low, high), or (mean, standard deviation) for ``gaussian``.
        operation: ``add``, ``scale`` or ``abs``.
        distribution: ``uniform``, ``log_uniform`` or ``gaussian``.

    Raises:
        ConfigError: unknown operation or distribution.
    """
    if distribution not in _SAMPLERS:
        raise ConfigError(f"unknown distribution '{distribution}': {suggest(distribution, _SAMPLERS)}")
    sample = _SAMPLERS[distribution](*parameters, default.shape, device=str(default.device))
    if operation == "add":
        return default + sample
    if operation == "scale":
        return default * sample
    if operation == "abs":
        return sample
    raise ConfigError(f"unknown operation '{operation}': {suggest(operation, _OPERATIONS)}")


def _check_operation(cfg: EventTermCfg, positive: Sequence[str] = (), not_negative: Sequence[str] = ()) -> None:
    """Check a term's operation and that factors of ``scale`` make sense.

    Raises:
        ConfigError: an unknown operation, a range out of order, or a factor that is negative (or zero).
    """
    operation = cfg.params.get("operation", "abs")
    name = getattr(cfg.func, "__name__", type(cfg.func).__name__)
    if operation not in _OPERATIONS:
        raise ConfigError(f"{name}: unknown operation '{operation}': {suggest(str(operation), _OPERATIONS)}")
    if operation != "scale" or cfg.params.get("distribution") == "gaussian":
        return
    for key in (*positive, *not_negative):
        limits = cfg.params.get(key)
        if limits is None:
            continue
        low, high = limits
        if low < 0 or (low == 0 and key in positive):
            wanted = "above zero" if key in positive else "at least zero"
            raise ConfigError(f"{name}: {key} must be {wanted} to scale by, got {tuple(limits)}")
        if high < low:
            raise ConfigError(f"{name}: {key} must be (low, high), got {tuple(limits)}")


class randomize_rigid_body_material(ManagerTermBase):
    """Give each chosen body one of a number of materials, which are drawn once at construction.

    MuJoCo has one sliding friction coefficient, and no restitution. We use the static friction; dynamic friction and
    restitution are reported as ignored. In a contact the larger coefficient of the two colliders counts.

    Params:
        static_friction_range: (low, high) of the friction coefficient.
        dynamic_friction_range: ignored.
        restitution_range: ignored.
        num_buckets: how many materials are drawn.
        asset_cfg: the asset and which of its bodies.
        make_consistent: Isaac Lab's; concerns the dynamic friction only.
    """

    def __init__(self, cfg: EventTermCfg, env: ManagerBasedEnv):
        super().__init__(cfg, env)
        self.asset_cfg: SceneEntityCfg = cfg.params["asset_cfg"]
        self.asset: RigidObject | Articulation = env.scene[self.asset_cfg.name]
        friction_range = cfg.params.get("static_friction_range", (1.0, 1.0))
        low, high = friction_range
        if low < 0 or high < low:
            raise ConfigError(
                "randomize_rigid_body_material: static_friction_range must be (low, high) with low at least zero,"
                f" got {tuple(friction_range)}"
            )
        num_buckets = int(cfg.params.get("num_buckets", 1))
        if num_buckets < 1:
            raise ConfigError(f"randomize_rigid_body_material: num_buckets must be at least 1, got {num_buckets}")
        path = f"events.{self.asset_cfg.name}: randomize_rigid_body_material"
        if tuple(cfg.params.get("dynamic_friction_range", friction_range)) != tuple(friction_range):
            note_ignored(f"{path}.dynamic_friction_range", "MuJoCo has one sliding friction: the static one")
        if any(cfg.params.get("restitution_range", (0.0, 0.0))):
            note_ignored(f"{path}.restitution_range", "MuJoCo has no restitution; see solref")
        self.material_buckets = sample_ranges([friction_range], num_buckets, env.device)[:, 0]

    def __call__(
        self,
        env: ManagerBasedEnv,
        env_ids: EnvIds,
        static_friction_range: Annotated[tuple[float, float], POSITIVE_SPAN],
        dynamic_friction_range: Annotated[tuple[float, float], POSITIVE_SPAN],
        restitution_range: Annotated[tuple[float, float], POSITIVE_SPAN],
        num_buckets: Annotated[int, COUNT],
        asset_cfg: SceneEntityCfg,
        make_consistent: bool = False,
    ) -> None:
        count = num_rows(env_ids, env.num_envs)
        body_ids = asset_cfg.body_ids
        for body_id in range(self.asset.num_bodies) if isinstance(body_ids, slice) else body_ids:
            bucket = torch.randint(0, len(self.material_buckets), (count,), device=env.device)
            self.asset.write_friction_to_sim(self.material_buckets[bucket], body_ids=[body_id], env_ids=env_ids)


class randomize_rigid_body_mass(ManagerTermBase):
    """Add to, scale or set the masses of the chosen bodies.

    Params:
        asset_cfg: the asset and which of its bodies.
        mass_distribution_params: parameters of the distribution: (low, high), or (mean, standard deviation).
        operation: ``add`` (kg), ``scale`` or ``abs`` (kg).
        distribution: ``uniform``, ``log_uniform`` or ``gaussian``.
        recompute_inertia: whether inertias scale with the masses, as of a body of uniform density.
        min_mass: no mass becomes smaller than this, in kg.
    """

    def __init__(self, cfg: EventTermCfg, env: ManagerBasedEnv):
        super().__init__(cfg, env)
        self.asset_cfg: SceneEntityCfg = cfg.params["asset_cfg"]
        self.asset: RigidObject | Articulation = env.scene[self.asset_cfg.name]
        _check_operation(cfg, positive=("mass_distribution_params",))
        min_mass = cfg.params.get("min_mass")
        if min_mass is not None and min_mass < 1e-6:
            raise ConfigError(f"randomize_rigid_body_mass: min_mass must be at least 1e-6 kg, got {min_mass}")

    def __call__(
        self,
        env: ManagerBasedEnv,
        env_ids: EnvIds,
        asset_cfg: SceneEntityCfg,
        mass_distribution_params: Annotated[tuple[float, float], FINITE],
        operation: Operation,
        distribution: Distribution = "uniform",
        recompute_inertia: bool = True,
        min_mass: Annotated[float, POSITIVE] = 1e-6,
    ) -> None:
        body_ids = asset_cfg.body_ids
        default = block(self.asset.data.default_mass, env_ids, body_ids)
        masses = _vary(default, mass_distribution_params, operation, distribution).clamp(min=min_mass)
        self.asset.write_body_mass_to_sim(
            masses,
            body_ids=None if isinstance(body_ids, slice) else body_ids,
            env_ids=env_ids,
            recompute_inertia=recompute_inertia,
        )


def scale_friction(env: ManagerBasedEnv, env_ids: EnvIds, factor: Annotated[float, POSITIVE]) -> None:
    """Multiply the sliding friction of every collider and soft body. For mode ``startup``: a second call adds to it.

    Args:
        env: the environment.
        env_ids: not used; all environments change.
        factor: above 0.
    """
    physics = env.sim.physics
    for name in ("geom_friction", "flex_friction") if physics.model.nflex else ("geom_friction",):
        physics.randomizable(name)[..., 0] *= factor


class randomize_rigid_body_com(ManagerTermBase):
    """Move the centres of mass of the chosen bodies away from where they are at start, all of them alike.

    Params:
        com_range: (low, high) of the displacement for any of ``x, y, z`` in m, along the link's axes.
        asset_cfg: the asset and which of its bodies.

    Raises:
        ConfigError: the range names an axis that does not exist.
    """

    @classmethod
    def prepare_model(cls, env: ManagerBasedEnv, *, asset_cfg: SceneEntityCfg, **params: Any) -> None:
        """Keep MuJoCo from compiling a free body for a centre of mass that stays at its origin."""
        for body in env.scene.spec.bodies:
            if body.name.startswith(f"{asset_cfg.name}/"):
                body.simple = False

    def __call__(
        self,
        env: ManagerBasedEnv,
        env_ids: EnvIds,
        com_range: Annotated[Mapping[str, Sequence[float]], SPAN],
        asset_cfg: SceneEntityCfg,
    ) -> None:
        asset: RigidObject | Articulation = env.scene[asset_cfg.name]
        body_ids = asset_cfg.body_ids
        default = block(asset.data.default_body_com_pos_b, env_ids, body_ids)
        ranges = axis_ranges(com_range, "randomize_rigid_body_com: com_range", axes=("x", "y", "z"))
        coms = default + sample_ranges(ranges, len(default), env.device)[:, None]
        asset.write_body_com_to_sim(coms, None if isinstance(body_ids, slice) else body_ids, env_ids)


def randomize_rigid_body_collider_offsets(
    env: ManagerBasedEnv,
    env_ids: EnvIds,
    asset_cfg: SceneEntityCfg,
    rest_offset_distribution_params: Annotated[tuple[float, float] | None, FINITE] = None,
    contact_offset_distribution_params: Annotated[tuple[float, float] | None, FINITE] = None,
    distribution: Distribution = "uniform",
) -> None:
    """Set the contact margins of the chosen bodies' colliders, one value for each body and environment.

    Args:
        env: the environment.
        env_ids: environments to change.
        asset_cfg: the asset and which of its bodies.
        rest_offset_distribution_params: parameters of the margin's distribution in m; None leaves margins alone.
        contact_offset_distribution_params: ignored: MuJoCo needs none.
        distribution: ``uniform``, ``log_uniform`` or ``gaussian``.
    """
    asset: RigidObject | Articulation = env.scene[asset_cfg.name]
    if contact_offset_distribution_params is not None:
        path = f"events.{asset_cfg.name}: randomize_rigid_body_collider_offsets.contact_offset_distribution_params"
        note_ignored(path, "MuJoCo finds contacts without it")
    if rest_offset_distribution_params is None:
        return
    body_ids = asset_cfg.body_ids
    for body_id in range(asset.num_bodies) if isinstance(body_ids, slice) else body_ids:
        zeros = torch.zeros(num_rows(env_ids, env.num_envs), device=env.device)
        margin = _vary(zeros, rest_offset_distribution_params, "abs", distribution)
        asset.write_collider_margin_to_sim(margin, body_ids=[body_id], env_ids=env_ids)


def randomize_physics_scene_gravity(
    env: ManagerBasedEnv,
    env_ids: EnvIds,
    gravity_distribution_params: Annotated[tuple[list[float], list[float]], FINITE],
    operation: Operation,
    distribution: Distribution = "uniform",
) -> None:
    """Add to, scale or set gravity; one draw for all environments, as in Isaac Lab.

    Args:
        env: the environment.
        env_ids: not used: gravity changes everywhere.
        gravity_distribution_params: parameters of the distribution for the three components.
        operation: ``add`` (m/s^2), ``scale`` or ``abs`` (m/s^2).
        distribution: ``uniform``, ``log_uniform`` or ``gaussian``.
    """
    default = torch.tensor([env.sim.cfg.gravity], dtype=torch.float32, device=env.device)
    low, high = (torch.tensor(p, dtype=torch.float32, device=env.device) for p in gravity_distribution_params)
    gravity = env.sim.physics.randomizable("opt.gravity")
    gravity[:] = _vary(default, (low, high), operation, distribution).to(gravity.dtype)


class randomize_actuator_gains(ManagerTermBase):
    """Add to, scale or set stiffness and damping of the chosen joints' actuators.

    Params:
        asset_cfg: the articulation and which of its joints.
        stiffness_distribution_params: parameters of the distribution; None leaves stiffness alone.
        damping_distribution_params: parameters of the distribution; None leaves damping alone.
        operation: ``add``, ``scale`` or ``abs``.
        distribution: ``uniform``, ``log_uniform`` or ``gaussian``.
    """

    def __init__(self, cfg: EventTermCfg, env: ManagerBasedEnv):
        super().__init__(cfg, env)
        self.asset_cfg: SceneEntityCfg = cfg.params["asset_cfg"]
        self.asset: Articulation = env.scene[self.asset_cfg.name]
        _check_operation(cfg, ("stiffness_distribution_params",), ("damping_distribution_params",))

    def __call__(
        self,
        env: ManagerBasedEnv,
        env_ids: EnvIds,
        asset_cfg: SceneEntityCfg,
        stiffness_distribution_params: Annotated[tuple[float, float] | None, FINITE] = None,
        damping_distribution_params: Annotated[tuple[float, float] | None, FINITE] = None,
        operation: Operation = "abs",
        distribution: Distribution = "uniform",
    ) -> None:
        asset, ids = self.asset, asset_cfg.joint_ids
        for parameters, default, write in (
            (
                stiffness_distribution_params,
                asset.data.default_joint_stiffness,
                asset.write_joint_stiffness_to_sim,
            ),
            (damping_distribution_params, asset.data.default_joint_damping, asset.write_joint_damping_to_sim),
        ):
            if parameters is not None:
                gains = _vary(block(default, env_ids, ids), parameters, operation, distribution)
                write(gains.clamp(min=0.0), joint_ids=ids, env_ids=env_ids)


class randomize_joint_parameters(ManagerTermBase):
    """Add to, scale or set friction, armature and position limits of the chosen joints.

    Params:
        asset_cfg: the articulation and which of its joints.
        friction_distribution_params: parameters of the distribution; None leaves friction alone.
        armature_distribution_params: parameters of the distribution; None leaves armatures alone.
        lower_limit_distribution_params: parameters of the distribution; None leaves the limit alone.
        upper_limit_distribution_params: parameters of the distribution; None leaves the limit alone.
        operation: ``add``, ``scale`` or ``abs``.
        distribution: ``uniform``, ``log_uniform`` or ``gaussian``.
    """

    def __init__(self, cfg: EventTermCfg, env: ManagerBasedEnv):
        super().__init__(cfg, env)
        self.asset_cfg: SceneEntityCfg = cfg.params["asset_cfg"]
        self.asset: Articulation = env.scene[self.asset_cfg.name]
        _check_operation(cfg, not_negative=("friction_distribution_params", "armature_distribution_params"))

    def __call__(
        self,
        env: ManagerBasedEnv,
        env_ids: EnvIds,
        asset_cfg: SceneEntityCfg,
        friction_distribution_params: Annotated[tuple[float, float] | None, FINITE] = None,
        armature_distribution_params: Annotated[tuple[float, float] | None, FINITE] = None,
        lower_limit_distribution_params: Annotated[tuple[float, float] | None, FINITE] = None,
        upper_limit_distribution_params: Annotated[tuple[float, float] | None, FINITE] = None,
        operation: Operation = "abs",
        distribution: Distribution = "uniform",
    ) -> None:
        asset, ids = self.asset, asset_cfg.joint_ids
        if friction_distribution_params is not None:
            default = block(asset.data.default_joint_friction_coeff, env_ids, ids)
            friction = _vary(default, friction_distribution_params, operation, distribution).clamp(min=0.0)
            asset.write_joint_friction_coefficient_to_sim(friction, joint_ids=ids, env_ids=env_ids)
        if armature_distribution_params is not None:
            default = block(asset.data.default_joint_armature, env_ids, ids)
            armature = _vary(default, armature_distribution_params, operation, distribution).clamp(min=0.0)
            asset.write_joint_armature_to_sim(armature, joint_ids=ids, env_ids=env_ids)
        if lower_limit_distribution_params is None and upper_limit_distribution_params is None:
            return
        limits = block(asset.data.default_joint_pos_limits, env_ids, ids)
        for side, parameters in enumerate((lower_limit_distribution_params, upper_limit_distribution_params)):
            if parameters is not None:
                limits[..., side] = _vary(limits[..., side], parameters, operation, distribution)
        if bool((limits[..., 0] > limits[..., 1]).any()):
            raise ConfigError(
                "randomize_joint_parameters: a lower joint limit was drawn above its upper limit; narrow"
                " lower_limit_distribution_params or upper_limit_distribution_params"
            )
        asset.write_joint_position_limit_to_sim(limits, joint_ids=ids, env_ids=env_ids)

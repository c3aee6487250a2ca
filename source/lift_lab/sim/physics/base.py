"""Interface of the physics engines for all layers above.

All values are torch tensors whose first dimension is the environment. The other dimensions are those of the MjData or
MjModel field of that name: `xmat` is (num_envs, nbody, 9). Quaternions are wxyz. Each environment is a world of its own
around its own origin.
"""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import mujoco
import numpy as np
import torch

from lift_lab.utils.errors import ConfigError, NotFoundError, PhysicsError, suggest
from lift_lab.utils.saved_state import Stateless

from .data_fields import DERIVED_FIELDS, MOVING_FIELDS, NEEDS_SENSOR, STATE_FIELDS, Stage, sensor_stages
from .engine_warnings import throttle_engine_warnings
from .model_fields import CONSTANT_INPUTS, RANDOMIZABLE_FIELDS, check_model_fields
from .rows import ids_tensor

if TYPE_CHECKING:
    from lift_lab.sim.simulation_cfg import SimulationCfg


@dataclasses.dataclass(frozen=True)
class Health:
    """Masks of the environments that failed since the last :meth:`Physics.health` call; bool tensors, (num_envs,)."""

    nonfinite: torch.Tensor
    """Position, velocity, acceleration or control NaN, infinite or beyond 1e10, or the inertia singular."""
    overflow: torch.Tensor
    """Contacts or constraints did not fit their memory, so some were dropped or the step was not taken."""
    none_failed: bool = False
    """True if the engine knows, without reading the tensors, that neither has a True."""

    @property
    def failed(self) -> torch.Tensor:
        """Either of the two, shape (num_envs,)."""
        return self.nonfinite | self.overflow


class Physics(ABC, Stateless):
    """`num_envs` simulations of one compiled model.

    A failed environment disturbs no other. :meth:`health` reports it. It keeps its bad state until :meth:`reset`,
    unless :attr:`auto_reset_failed`.

    Args:
        model: the compiled model; copied, so that the caller's own stays as it was.
        num_envs: number of environments, at least 1.
        device: device of the tensors.
        auto_reset_failed: see the attribute.

    Raises:
        ConfigError: `num_envs` is below 1.
    """

    name: ClassVar[str]
    """Name of the engine in :mod:`lift_lab.sim.engines`."""
    is_asynchronous: ClassVar[bool] = False
    """Whether calls return before their work is done, so that the host waits where it reads a value."""
    model: mujoco.MjModel
    """The compiled model all environments share, with MuJoCo's own automatic reset of bad states disabled."""
    num_envs: int
    device: torch.device
    auto_reset_failed: bool
    """Whether step() itself puts environments that fail into the model's default state and makes their kinematics
    current. health() reports them as ever."""
    moving_dofs: torch.Tensor
    """Matrix of the degrees of freedom that move each body, ones and zeros, (nbody, nv)."""

    _is_closed = False

    def __init__(self, model: mujoco.MjModel, num_envs: int, device: torch.device, auto_reset_failed: bool = False):
        if num_envs < 1:
            raise ConfigError(f"num_envs must be at least 1, got {num_envs}")
        throttle_engine_warnings()
        self.model = _own_copy(model)
        self.num_envs = num_envs
        self.device = device
        self.auto_reset_failed = auto_reset_failed
        self._shapes = mujoco.MjData(self.model)
        self.moving_dofs = _moving_dofs(self.model).to(device)
        self._gravity = torch.tensor(self.model.opt.gravity, dtype=torch.float32, device=device).expand(num_envs, 3)
        self._gravity_may_differ = False
        self._stale: list[torch.Tensor | Sequence[int] | None] = []  # environments moved since kinematics were current
        self._acceleration: torch.Tensor | None = None
        self._inputs: dict[str, tuple[torch.Tensor, int]] = {}  # CONSTANT_INPUTS in use, as of the constants
        self._has_own_constants = False  # whether constants were derived for each environment

    @classmethod
    def options_of(cls, cfg: SimulationCfg) -> dict[str, Any]:
        """The constructor's own arguments that the simulation's settings ask for.

        The place where an engine refuses settings that it cannot honour, and notes those that it does not use
        (:func:`lift_lab.sim.ignored.note_ignored`), before anything is built.

        Raises:
            ConfigError: a setting that the engine cannot honour.
        """
        return {}

    @abstractmethod
    def field(self, name: str) -> torch.Tensor:
        """The live float32 view of an MjData field, (num_envs, *shape); read-only, the same tensor for life.

        It is bound, and made current, on first use; then kept current as its :class:`Stage` says.
        Force-dependent fields are zero between reset() and the next step() or forward().

        Raises:
            NotFoundError: no such field, or one that this model has no sensor to compute.
        """

    @property
    @abstractmethod
    def bound_fields(self) -> tuple[str, ...]:
        """Names of the fields that were asked for so far and are kept current, in that order."""

    @abstractmethod
    def write(
        self,
        name: str,
        values: torch.Tensor | float,
        env_ids: torch.Tensor | Sequence[int] | None = None,
        cols: slice | torch.Tensor | Sequence[int] | None = None,
    ) -> None:
        """Write a state field, flattened per environment (`mocap_pos` has 3 * nmocap columns).

        Args:
            name: one of `STATE_FIELDS`.
            values: anything that broadcasts to (len(env_ids), number of columns).
            env_ids: the environments, None for all.
            cols: the columns, None for all.

        Raises:
            NotFoundError: `name` is no state field.
            ConfigError: `values` do not broadcast.
        """

    @abstractmethod
    def step(self, num_substeps: int = 1) -> None:
        """Advance by `num_substeps` time steps and leave the kinematics current at the new state."""

    @abstractmethod
    def refresh(self, env_ids: torch.Tensor | Sequence[int] | None = None) -> None:
        """Make the kinematics current after writes, to the stage at which step() leaves them."""

    @abstractmethod
    def forward(self, env_ids: torch.Tensor | Sequence[int] | None = None) -> None:
        """Make every field current: kinematics, forces, accelerations and sensors. The state is untouched."""

    @abstractmethod
    def reset(self, env_ids: torch.Tensor | Sequence[int] | None = None) -> None:
        """Set the model's default state: qpos0, all else zero, warm start included: the past leaves no trace.

        Kinematics are not computed: write the initial state, then refresh().
        """

    @abstractmethod
    def randomizable(self, name: str) -> torch.Tensor:
        """The per-environment values of a model field, (num_envs, *shape), to write into.

        Floating point, in the engine's own precision. What follows from a field in :data:`CONSTANT_INPUTS` is computed
        at the next step(), refresh() or forward() after a write. Writes that torch does not see (into a numpy array
        on the same memory, by a kernel) need a call of :meth:`recompute_constants`.

        Raises:
            NotFoundError: not in `RANDOMIZABLE_FIELDS`.
        """

    def recompute_constants(self) -> None:
        """Derive the model's constants from the randomised fields, as `mj_setConst`.

        Raises:
            ConfigError: a field has values that the compiled model cannot have, see
                :func:`~lift_lab.sim.physics.model_fields.check_model_fields`.
        """
        inputs = {name: (field, field._version) for name, (field, _) in self._inputs.items()}
        check_model_fields(self.model, {name: field for name, (field, _) in inputs.items()})
        self._set_constants()
        self._inputs = inputs
        self._has_own_constants = True

    @abstractmethod
    def _set_constants(self) -> None:
        """Run the engine's own `mj_setConst` for all environments."""

    @abstractmethod
    def health(self) -> Health:
        """Return the failures since the last call, including environments that were reset. An environment that is still
        in a bad state counts again."""

    @abstractmethod
    def get_data(self, env_id: int, data: mujoco.MjData | None = None) -> mujoco.MjData:
        """One environment as an MjData with everything computed, to render or to inspect.

        Args:
            env_id: the environment.
            data: written into and returned; None for a new one.
        """

    def close(self) -> None:
        """Free the memory of all simulations. May be called again; every other use raises a PhysicsError.

        Tensors that were handed out stay valid.
        """
        for name in [name for name in vars(self) if not hasattr(type(self), name)]:  # leaves replaced methods
            delattr(self, name)
        self._is_closed = True

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            if self._is_closed:
                raise PhysicsError("this simulation was closed; make a new environment or scene")
            raise AttributeError(f"'{type(self).__name__}' object has no attribute '{name}'")

    def current(self, name: str) -> torch.Tensor:
        """:meth:`field` at the current state: after writes the kinematics are computed first if needed.

        Of kinematic fields; what depends on forces is as :meth:`field` says.
        """
        if self._stale:
            some = [ids_tensor(env_ids, self.device) for env_ids in self._stale if env_ids is not None]
            ids = torch.cat(some) if len(some) == len(self._stale) else None
            self.refresh(ids)
            self._stale.clear()
        return self.field(name)

    def acceleration(self) -> torch.Tensor:
        """Change of `qvel` over the last time step, divided by its length, (num_envs, nv); the same tensor for life.

        MuJoCo's `qacc` differs from it where an integrator is implicit in velocities: a stiff damper slows a joint by
        less than the force at the start of the step would. It is zero until the first step after the first call, and
        where velocities were written or reset since.
        """
        if self._acceleration is None:
            self._acceleration = torch.zeros(self.num_envs, self.model.nv, device=self.device)
        return self._acceleration

    @property
    def gravity(self) -> torch.Tensor:
        """Current acceleration of gravity in m/s^2, (num_envs, 3)."""
        return self.randomizable("opt.gravity").float() if self._gravity_may_differ else self._gravity

    def jac_body(self, body_id: int) -> torch.Tensor:
        """Jacobian of a body's frame origin in the world frame, (num_envs, 6, nv), rows (linear, angular).

        Equal to `mj_jacBody`, from the current kinematics. Column i is the motion axis of dof i, moved to the body's
        origin. `cdof` gives it at the centre of mass of the tree.
        """
        if not 0 <= body_id < self.model.nbody:
            raise NotFoundError(f"body id {body_id} is not in [0, {self.model.nbody})")
        axes = self.current("cdof") * self.moving_dofs[body_id].unsqueeze(-1)
        angular, linear = axes[..., :3], axes[..., 3:]
        root_com = self.field("subtree_com")[:, self.model.body_rootid[body_id]]
        arm = (self.field("xpos")[:, body_id] - root_com).unsqueeze(1)
        linear = linear + torch.linalg.cross(angular, arm.expand_as(angular))
        return torch.cat((linear, angular), dim=-1).transpose(1, 2)

    def com_acc(self, qacc: torch.Tensor | None = None) -> torch.Tensor:
        """Accelerations of all bodies without gravity's share, (num_envs, nbody, 6), rows (angular, linear).

        MuJoCo's `cacc` minus that of the world, for a model with or without sensors. It is in the world frame, with the
        linear part at the centre of mass of the tree, from the current motion axes.

        Args:
            qacc: accelerations of the degrees of freedom, (num_envs, nv); None for :meth:`acceleration`.
        """
        qvel, qacc = self.field("qvel").unsqueeze(-1), (self.acceleration() if qacc is None else qacc).unsqueeze(-1)
        of_dofs = self.current("cdof_dot") * qvel + self.current("cdof") * qacc
        return torch.einsum("bv,nvk->nbk", self.moving_dofs, of_dofs)

    # -- saved state

    @abstractmethod
    def state_dict(self) -> dict[str, Any]:
        """Return the whole state in the engine's own precision, as copies on the CPU.

        To continue with the same bits, more is needed than :meth:`write` takes. It includes the solver's warm start,
        fields of the last step, model fields that differ between environments, and failures that :meth:`health` has not
        reported yet.
        """

    @abstractmethod
    def check_state_dict(self, state: Any) -> None:
        """Check that a state can be loaded; changes nothing.

        Raises:
            StateMismatchError: it is of another engine, version, model or number of environments.
        """

    @abstractmethod
    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Continue from a state of :meth:`state_dict`.

        Raises:
            StateMismatchError: as :meth:`check_state_dict`; nothing has changed then.
            PhysicsError: the constants of the saved model cannot be derived.
        """

    @abstractmethod
    def storages(self) -> set[int]:
        """Addresses of the memory that :meth:`load_state_dict` writes: a tensor there is the engine's to restore."""

    # -- shared by the engines

    def _hand_out(self, name: str, field: torch.Tensor) -> torch.Tensor:
        """Return a model field, and take note of it where constants follow from it."""
        if name in CONSTANT_INPUTS and name not in self._inputs:
            self._inputs[name] = (field, field._version)
        return field

    def _follow_model(self) -> None:
        """Recompute the constants if a field that they follow from was written since they were computed."""
        for field, version in self._inputs.values():
            if field._version != version:
                self.recompute_constants()
                return

    def _moved(self, name: str, env_ids: torch.Tensor | Sequence[int] | None) -> None:
        """Take note that a field of some environments was written."""
        if name in MOVING_FIELDS and not (self._stale and self._stale[-1] is env_ids):
            self._stale.append(env_ids)

    def _caught_up(self, env_ids: torch.Tensor | Sequence[int] | None) -> None:
        """Take note that the kinematics of some environments are current."""
        if env_ids is None:
            self._stale.clear()
        elif self._stale:
            self._stale = [stale for stale in self._stale if stale is not env_ids]

    def _shape(self, name: str) -> tuple[int, ...]:
        """Per-environment shape of an MjData field."""
        return np.shape(getattr(self._shapes, name))

    def _field_stage(self, name: str) -> Stage:
        """The stage a field needs in this model; raises NotFoundError for a name that cannot be bound."""
        if name in STATE_FIELDS:
            return Stage.NONE
        if name not in DERIVED_FIELDS:
            choices = [*STATE_FIELDS, *DERIVED_FIELDS]
            raise NotFoundError(f"unknown physics field '{name}'; {suggest(name, choices)}")
        sensors = NEEDS_SENSOR.get(name)
        if sensors and not np.isin(self.model.sensor_type, [int(s) for s in sensors]).any():
            names = ", ".join(s.name.removeprefix("mjSENS_").lower() for s in sensors)
            raise NotFoundError(f"field '{name}' is computed only for a model with one of the sensors {names}")
        if name == "sensordata":
            kinematic = [s for s in sensor_stages(self.model) if s < Stage.ACC]
            return Stage(max(kinematic, default=Stage.POS))
        return DERIVED_FIELDS[name]

    def _check_state_field(self, name: str) -> None:
        if name not in STATE_FIELDS:
            derived = " is derived and read-only" if name in DERIVED_FIELDS else " is no state field"
            raise NotFoundError(f"cannot write '{name}': it{derived}; {suggest(name, STATE_FIELDS)}")

    def _check_randomizable(self, name: str) -> None:
        if name not in RANDOMIZABLE_FIELDS:
            hint = suggest(name, RANDOMIZABLE_FIELDS)
            raise NotFoundError(f"model field '{name}' cannot differ between environments; {hint}")
        self._gravity_may_differ |= name == "opt.gravity"


def silence(data: mujoco.MjData) -> None:
    """Keep MuJoCo from printing this data's warnings: it does so only when a counter leaves zero."""
    for warning in data.warning:
        warning.number = 1


def _moving_dofs(model: mujoco.MjModel) -> torch.Tensor:
    """Which dofs move which bodies, (nbody, nv) of ones and zeros: a body's own and those of its ancestors."""
    moving = torch.zeros(model.nbody, model.nv)
    for body in range(1, model.nbody):  # a parent comes before its children
        moving[body] = moving[model.body_parentid[body]]
        start, count = model.body_dofadr[body], model.body_dofnum[body]
        if count:
            moving[body, start : start + count] = 1.0
    return moving


def _own_copy(model: mujoco.MjModel) -> mujoco.MjModel:
    """A copy that does not reset itself: the reset would hide a failure."""
    model = model.__copy__()
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET.value
    return model

"""A policy that is exactly symmetric: it averages a network's action and the mirrored action at the mirror image.

With a network f, the image M s of an observation s and the image A a of an action a, the mean action is
(f(s) + A f(M s)) / 2. Since M and A are their own inverses, the mean action at M s is exactly the image of that at s,
for any weights.
"""

# TorchScript reads the annotations of the modules' attributes: they have to be types, not text

import copy
from collections.abc import Mapping
from typing import Any, Self

import torch
from rsl_rl.models import MLPModel
from rsl_rl.modules import HiddenState
from tensordict import TensorDict
from torch import nn

from lift_lab.utils.errors import ConfigError
from lift_lab.utils.mirror import MirrorMap, image_of

from .network_inputs import network_input

_PREFIX = "mirror."
"""Beginning of the names of the maps' numbers in a checkpoint."""


class PolicyMirror(nn.Module):
    """Maps of observations and actions to those of the mirror image, kept with the policy's weights."""

    obs_index: torch.Tensor
    obs_factor: torch.Tensor
    obs_offset: torch.Tensor
    action_index: torch.Tensor
    action_factor: torch.Tensor
    action_offset: torch.Tensor

    def __init__(self, num_obs: int, num_actions: int):
        """Make maps that change nothing.

        Args:
            num_obs: numbers of an observation.
            num_actions: numbers of an action.
        """
        super().__init__()
        for name, size in (("obs", num_obs), ("action", num_actions)):
            self.register_buffer(f"{name}_index", torch.arange(size))
            self.register_buffer(f"{name}_factor", torch.ones(size))
            self.register_buffer(f"{name}_offset", torch.zeros(size))

    def clear(self) -> None:
        """Take maps that change nothing."""
        self.load_state_dict(PolicyMirror(len(self.obs_index), len(self.action_index)).state_dict())

    def set_maps(self, obs: MirrorMap, actions: MirrorMap) -> None:
        """Take the maps of a task."""
        for name, given in (("obs", obs), ("action", actions)):
            for part in ("index", "factor", "offset"):
                self.get_buffer(f"{name}_{part}").copy_(getattr(given, part))

    def obs(self, obs: torch.Tensor) -> torch.Tensor:
        """Image of observations, shape (..., num_obs)."""
        return image_of(obs, self.obs_index, self.obs_factor, self.obs_offset)

    def actions(self, actions: torch.Tensor) -> torch.Tensor:
        """Image of actions, shape (..., num_actions)."""
        return image_of(actions, self.action_index, self.action_factor, self.action_offset)

    def mean(self, both: torch.Tensor) -> torch.Tensor:
        """Mean actions of the symmetric policy.

        Args:
            both: outputs of the network for observations and their images, shape (2, samples, num_actions).
        """
        return 0.5 * (both[0] + self.actions(both[1]))

    def mean_gradient(self, grad: torch.Tensor) -> torch.Tensor:
        """Derivative by the network's outputs, shape (2, samples, num_actions), of that by the mean actions."""
        mirrored = (grad * self.action_factor).index_select(-1, self.action_index)  # the index is its own inverse
        return 0.5 * torch.stack([grad, mirrored])


class SymmetricMlp(MLPModel):
    """rsl_rl's multi-layer perceptron as an exactly symmetric policy.

    Attributes:
        mirror: maps of observations and actions.
    """

    def __init__(self, *args: Any, **kwargs: Any):
        """Build the network; :meth:`PolicyMirror.set_maps` sets the maps.

        Args:
            *args: rsl_rl's.
            **kwargs: rsl_rl's.
        """
        super().__init__(*args, **kwargs)
        *_, last = (layer for layer in self.mlp.modules() if isinstance(layer, nn.Linear))
        self.mirror = PolicyMirror(self.obs_dim, last.out_features)

    @classmethod
    def like(cls, model: MLPModel) -> Self:
        """A symmetric policy of another policy's parts, with maps that change nothing."""
        self = cls.__new__(cls)
        nn.Module.__init__(self)
        self.obs_groups, self.obs_dim, self.obs_normalization = model.obs_groups, model.obs_dim, model.obs_normalization
        self.obs_normalizer, self.mlp, self.distribution = model.obs_normalizer, model.mlp, model.distribution
        *_, last = (layer for layer in self.mlp.modules() if isinstance(layer, nn.Linear))
        self.mirror = PolicyMirror(self.obs_dim, last.out_features).to(last.weight.device)
        return self.train(model.training)

    def forward(
        self,
        obs: TensorDict,
        masks: torch.Tensor | None = None,
        hidden_state: HiddenState = None,
        stochastic_output: bool = False,
    ) -> torch.Tensor:
        """Actions, shape (samples, num_actions): the mean, or with ``stochastic_output`` drawn."""
        given = network_input(self, obs)
        mean = _symmetric_mean(given, self.obs_normalizer, self.mlp, self.mirror)
        assert self.distribution is not None
        if stochastic_output:
            self.distribution.update(mean)
            return self.distribution.sample()
        return self.distribution.deterministic_output(mean)

    def as_jit(self) -> nn.Module:
        """The policy in a form that TorchScript takes."""
        return _Exported(self)

    def as_onnx(self, verbose: bool) -> nn.Module:
        """The policy in a form that torch's ONNX exporter takes."""
        return _Exported(self)


def _symmetric_mean(obs: torch.Tensor, normalizer: nn.Module, mlp: nn.Module, mirror: PolicyMirror) -> torch.Tensor:
    both = torch.stack([obs, mirror.obs(obs)])
    return mirror.mean(mlp(normalizer(both)))


class _Exported(nn.Module):
    """The policy without noise, for files."""

    is_recurrent: bool = False
    input_names = ("obs",)
    output_names = ("actions",)

    def __init__(self, model: SymmetricMlp):
        super().__init__()
        self.obs_normalizer, self.mlp = copy.deepcopy(model.obs_normalizer), copy.deepcopy(model.mlp)
        self.mirror = copy.deepcopy(model.mirror)
        self.input_size = model.obs_dim

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Mean actions of observations, shape (batch, num_obs)."""
        mirrored = self.mlp(self.obs_normalizer(self.mirror.obs(x)))
        return 0.5 * (self.mlp(self.obs_normalizer(x)) + self.mirror.actions(mirrored))

    @torch.jit.export
    def reset(self) -> None:
        """Nothing is remembered."""

    @torch.jit.unused
    def get_dummy_inputs(self) -> tuple[torch.Tensor]:
        """An observation of zeros."""
        return (torch.zeros(1, self.input_size),)


def is_symmetric(state: Mapping[str, Any]) -> bool:
    """Return whether the saved state of an actor is that of a symmetric policy."""
    return any(name.startswith(_PREFIX) for name in state)


def with_mirror(state: dict[str, torch.Tensor], mirror: PolicyMirror) -> dict[str, torch.Tensor]:
    """The saved state of an actor, with the maps of ``mirror`` where it has none."""
    if is_symmetric(state):
        return state
    return state | {f"{_PREFIX}{name}": value for name, value in mirror.state_dict().items()}


def check_mirror_state(state: Mapping[str, torch.Tensor], path: str) -> None:
    """Check the maps in the saved state of an actor.

    Args:
        state: the saved state.
        path: file of the checkpoint, for the message.

    Raises:
        ConfigError: an index leads nowhere.
    """
    for part in ("obs_index", "action_index"):
        index = state.get(f"{_PREFIX}{part}")
        if index is None or index.ndim != 1 or sorted(index.tolist()) != list(range(len(index))):
            raise ConfigError(f"'{path}' is no valid checkpoint: '{_PREFIX}{part}' does not name each number once")

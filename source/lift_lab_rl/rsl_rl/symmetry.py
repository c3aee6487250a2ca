"""Mirrored samples and the mirror loss in our update (Mittal et al. 2024, arXiv:2403.04359).

rsl_rl's symmetry extension calls a function ``func(env=, obs=, actions=)``. It returns observations and actions with
their images appended: ``copies`` times as many samples, the given ones first. For tasks that declare their symmetry
(:class:`~lift_lab.envs.mirror.MirrorCfg`), :func:`mirror_samples` is such a function.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import Any
from weakref import WeakKeyDictionary

import torch
from rsl_rl.extensions import Symmetry
from tensordict import TensorDict

from lift_lab.envs.mirror import TaskMirror
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.mirror import MirrorMap

from .symmetric_policy import PolicyMirror

_MIRRORS: WeakKeyDictionary[Any, _EnvMirror] = WeakKeyDictionary()


class _EnvMirror:
    """Maps of one environment, on the learner's device, made when they are first needed."""

    def __init__(self, env: Any):
        self._task = TaskMirror(env)
        self._maps: dict[tuple[str | None, torch.device], MirrorMap] = {}

    def map(self, group: str | None, device: torch.device) -> MirrorMap:
        """Map of an observation group, or (None) of the actions."""
        key = (group, device)
        if key not in self._maps:
            found = self._task.actions() if group is None else self._task.group(group)
            self._maps[key] = found.to(device)
        return self._maps[key]


def mirror_samples(
    env: Any, obs: TensorDict | None = None, actions: torch.Tensor | None = None
) -> tuple[TensorDict | None, torch.Tensor | None]:
    """Append the mirror image of every sample, as the task declares it.

    Args:
        env: the environment, as rsl_rl sees it; its configuration has a ``mirror``.
        obs: observations by group, batch size (samples,); None for none.
        actions: shape (samples, num_actions); None for none.

    Returns:
        Observations and actions of twice as many samples: the given ones, then their images.

    Raises:
        ConfigError: the task declares no symmetry, or a term has no known mirror image.
    """
    mirror = _mirror_of(env)
    if obs is not None:
        own: dict[str, Any] = dict(obs.items())
        images = {name: mirror.map(name, values.device)(values) for name, values in own.items()}
        obs = torch.cat([obs, TensorDict(images, batch_size=obs.batch_size)])  # type: ignore[arg-type]
    if actions is not None:
        actions = torch.cat([actions, mirror.map(None, actions.device)(actions)])
    return obs, actions


def _mirror_of(env: Any) -> _EnvMirror:
    inner = env.unwrapped
    if inner not in _MIRRORS:
        _MIRRORS[inner] = _EnvMirror(inner)
    return _MIRRORS[inner]


def policy_maps(symmetry: Symmetry, groups: Sequence[str]) -> tuple[MirrorMap, MirrorMap]:
    """Maps of a policy's observations and actions, as the task declares them.

    Args:
        symmetry: rsl_rl's extension.
        groups: the policy's observation groups.

    Raises:
        ConfigError: the extension has a function of the user's, which is not a map.
    """
    if symmetry.data_augmentation_func is not mirror_samples:
        raise ConfigError(
            "agent.algorithm.symmetry_cfg.average_policy needs the task's declared symmetry, env.mirror; leave out "
            "data_augmentation_func"
        )
    env: Any = symmetry.env
    task = TaskMirror(env.unwrapped)
    return MirrorMap.cat([task.group(name) for name in groups]), task.actions()


class MirroredSamples:
    """Use of rsl_rl's symmetry extension in our update.

    The actor sees every sample and, next to it, its images: ``copies`` rows. There are three cases:

    - The images are samples of their own (``use_data_augmentation``).
    - They are for the mirror loss alone.
    - The policy averages over both (:class:`~lift_lab_rl.rsl_rl.symmetric_policy.SymmetricMlp`). Then an image as a
      sample of its own would add to the actor's loss what its sample does, so it is left out there.

    Attributes:
        augments: whether the images are samples of their own, at least for the critic.
        loss_coef: weight of the mirror loss; 0 where it is only logged.
        copies: samples that each one becomes, itself included.
    """

    def __init__(self, symmetry: Symmetry, groups: Sequence[str], policy: PolicyMirror | None = None):
        """Take over the extension's settings.

        Args:
            symmetry: rsl_rl's extension.
            groups: observation groups that the networks see.
            policy: the maps of a policy that averages; None for another policy.
        """
        self._policy = policy
        self._symmetry, self._groups = symmetry, list(groups)
        self._lock = threading.Lock()  # the function is the user's
        self.augments = symmetry.use_data_augmentation
        self.loss_coef = symmetry.mirror_loss_coeff if symmetry.use_mirror_loss else 0.0
        self.copies = 0

    @property
    def rows_per_sample(self) -> int:
        """Rows of the actor to a sample of its loss."""
        return 1 if self.augments and self._policy is None else self.copies

    def check(self, obs: TensorDict, actions: torch.Tensor) -> None:
        """Mirror a few samples to learn the number of copies.

        Args:
            obs: observations of the right shapes.
            actions: actions of the right shape.

        Raises:
            ConfigError: the function fails, or does not return the samples and their images.
        """
        more, their_actions = self._call(obs, actions)
        copies = len(their_actions) // len(actions)
        fits = copies > 1 and their_actions.shape == (copies * len(actions), *actions.shape[1:])
        fits = fits and all(more[name].shape == (copies * len(obs), *obs[name].shape[1:]) for name in self._groups)
        if not fits:
            raise ConfigError(
                "agent.algorithm.symmetry_cfg.data_augmentation_func: of "
                f"{_shapes(obs, actions, self._groups)} it returned {_shapes(more, their_actions, self._groups)}; "
                "expected the given samples and after them their images"
            )
        if not torch.equal(their_actions[: len(actions)], actions):
            raise ConfigError(
                "agent.algorithm.symmetry_cfg.data_augmentation_func: the first samples that it returns are not the "
                "given ones; expected the given samples and after them their images"
            )
        self.copies = copies

    def append(self, obs: TensorDict, actions: torch.Tensor) -> tuple[TensorDict, torch.Tensor]:
        """Samples, each followed by its images.

        Args:
            obs: observations by group, batch size (samples,).
            actions: shape (samples, num_actions).

        Returns:
            Observations of the networks' groups and actions, of ``copies`` times as many samples.
        """
        more, their_actions = self._call(obs, actions)
        groups = {name: self._next_to_each_other(more[name]) for name in self._groups}
        return TensorDict(groups, batch_size=more.batch_size), self._next_to_each_other(their_actions)

    def repeated(self, samples: dict[str, torch.Tensor]) -> dict[str, torch.Tensor]:
        """Numbers of samples that their images have, too, in the order of :meth:`append`."""
        return {name: values.repeat_interleave(self.copies, 0) for name, values in samples.items()}

    def means(self, outputs: torch.Tensor) -> torch.Tensor:
        """Mean actions of the samples of the actor's loss.

        Args:
            outputs: of the actor's network, shape (rows, num_actions).

        Returns:
            Shape (rows / rows_per_sample, num_actions).
        """
        if self._policy is not None:
            return self._policy.mean(outputs.view(-1, self.copies, outputs.shape[-1]).transpose(0, 1))
        return outputs[:: self.rows_per_sample]

    def to_outputs(self, grad: torch.Tensor) -> torch.Tensor:
        """Derivative by the network's outputs, not divided by the number of rows yet, of that by :meth:`means`."""
        count = self.rows_per_sample
        if count == 1:
            return grad
        by_row = grad.new_zeros(len(grad), count, grad.shape[-1])
        if self._policy is not None:
            by_row[:] = self._policy.mean_gradient(grad).transpose(0, 1)
        else:
            by_row[:, 0] = grad
        return by_row.mul_(count).flatten(0, 1)

    def of_given(self, values: torch.Tensor) -> torch.Tensor:
        """Sum over the given samples, scaled to the number of all samples of the actor's loss.

        Args:
            values: shape (samples, num_actions), in the order of :meth:`append`.
        """
        count = self.copies // self.rows_per_sample
        return values[::count].sum(0) * count

    def loss(self, means: torch.Tensor, grad: torch.Tensor) -> torch.Tensor:
        """Mirror loss: mean squared difference between the actions at the images and the images of the actions.

        Its derivative is added to ``grad``. As in rsl_rl, only the actions at the images are drawn to the others.

        Args:
            means: mean actions of samples and images, shape (samples * copies, num_actions), in the order of
                :meth:`append`.
            grad: derivative of the loss by ``means``, not yet divided by the number of rows; changed in place.

        Returns:
            The loss times the number of rows, a scalar; 0 of a policy that averages.
        """
        if self._policy is not None:
            return means.new_zeros(())
        by_sample = means.view(-1, self.copies, means.shape[-1])
        own = by_sample[:, 0]
        with self._lock:
            _, every = self._symmetry.data_augmentation_func(env=self._symmetry.env, obs=None, actions=own)
        off = by_sample[:, 1:] - every[len(own) :].view(self.copies - 1, *own.shape).transpose(0, 1)
        share = self.copies / ((self.copies - 1) * means.shape[-1])
        if self.loss_coef:
            grad.view_as(by_sample)[:, 1:].add_(off, alpha=2.0 * self.loss_coef * share)
        return off.square().sum() * share

    def _call(self, obs: TensorDict, actions: torch.Tensor) -> tuple[TensorDict, torch.Tensor]:
        function: Any = self._symmetry.data_augmentation_func
        if function is mirror_samples:  # other groups need no declaration
            obs = obs.select(*self._groups)
        return function(env=self._symmetry.env, obs=obs, actions=actions)

    def _next_to_each_other(self, values: torch.Tensor) -> torch.Tensor:
        """From copy after copy of all samples to sample after sample."""
        return values.view(self.copies, -1, *values.shape[1:]).transpose(0, 1).flatten(0, 1)


def _shapes(obs: TensorDict, actions: torch.Tensor, groups: Sequence[str]) -> str:
    parts = [f"{name} {tuple(obs[name].shape)}" for name in groups]
    return ", ".join([*parts, f"actions {tuple(actions.shape)}"])

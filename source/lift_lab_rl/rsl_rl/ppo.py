"""PPO whose update is cut into pieces of fixed size: fast on few cores and the same bits on any number of them.

rsl_rl's :class:`~rsl_rl.algorithms.PPO` stays the algorithm. Two of its steps are done differently here, with the
same mathematics:

- A minibatch's gradient is the sum of the gradients of its pieces (:class:`~lift_lab_rl.threads.PiecePool`).
- What does not change within an update (observation normalisation, the shuffled order of samples) is computed once
  instead of once an epoch, and the critic looks at a whole rollout at its end instead of at every step.

With several processes (:mod:`~lift_lab_rl.distributed`) gradients, divergence and the scale of the advantages are those
of all their samples together, in one exchange a minibatch: all processes take the same steps.

Networks this cannot do (recurrent, convolutional, other distributions) and the extensions (random network
distillation, symmetry, mixed precision) go through rsl_rl's own update.
"""

from __future__ import annotations

import math
from typing import Any

import torch
from rsl_rl.algorithms import PPO
from rsl_rl.models import MLPModel
from rsl_rl.modules.distribution import GaussianDistribution
from tensordict import TensorDict
from torch import nn

from lift_lab.utils.errors import ConfigError
from lift_lab_rl import distributed
from lift_lab_rl.threads import PiecePool, piece_bounds

PIECE_ROWS = 1536
"""Samples in a piece. Large enough to keep matrix products efficient, small enough for the second-level cache."""


class EluMlp(torch.autograd.Function):
    """A multi-layer perceptron with ELU between its layers, forward and backward in as few passes as torch allows.

    ``apply(x, weight_0, bias_0, weight_1, bias_1, ...)`` with x of shape (rows, inputs).
    """

    @staticmethod
    def forward(ctx: Any, x: torch.Tensor, *params: torch.Tensor) -> torch.Tensor:
        """Output of the last layer, shape (rows, outputs)."""
        inputs = [x]
        last = len(params) // 2 - 1
        for layer in range(last + 1):
            weight, bias = params[2 * layer], params[2 * layer + 1]
            y = torch.addmm(bias, inputs[-1], weight.t())
            if layer < last:
                # elu(y) = max(y, exp(min(y, 0)) - 1)
                negative = torch.clamp_max(y, 0.0).exp_().sub_(1.0)
                inputs.append(torch.maximum(y, negative, out=negative))
        ctx.save_for_backward(*inputs, *params[0::2])
        return y

    @staticmethod
    def backward(ctx: Any, *grad_outputs: torch.Tensor) -> tuple[torch.Tensor | None, ...]:
        """Gradients of weights and biases; the input gets none."""
        saved = ctx.saved_tensors
        layers = len(saved) // 2
        inputs, weights = saved[:layers], saved[layers:]
        grad = grad_outputs[0]
        grads: list[torch.Tensor | None] = []
        for layer in reversed(range(layers)):
            grads += [grad.sum(0), grad.t() @ inputs[layer]]
            if layer:
                grad = grad @ weights[layer]
                # elu'(y) = 1 + min(elu(y), 0)
                slope = torch.clamp_max(inputs[layer], 0.0)
                grad = torch.addcmul(grad, grad, slope, out=slope)
        return None, *reversed(grads)


class PiecewisePPO(PPO):
    """Proximal policy optimization with piecewise gradients (Schulman et al. 2017, arXiv:1707.06347)."""

    _raw_actor: Any
    _raw_critic: Any
    transition: Any
    storage: Any

    def __init__(
        self,
        actor: MLPModel,
        critic: MLPModel,
        storage: Any,
        *,
        num_threads: int | None = None,
        mean_reg_coef: float = 0.0,
        **kwargs: Any,
    ):
        """Build rsl_rl's PPO.

        Args:
            actor: policy network.
            critic: value network.
            storage: rollout storage.
            num_threads: threads the update may use on the CPU; None takes every CPU this process may run on.
            mean_reg_coef: weight in the loss of the squared length of the policy's mean action, averaged over samples.
            **kwargs: rsl_rl's settings.

        Raises:
            ConfigError: ``mean_reg_coef`` is negative, or not zero with networks or extensions that go through
                rsl_rl's own update.
        """
        super().__init__(actor, critic, storage, **kwargs)
        on_cpu = torch.device(self.device).type == "cpu"
        self._pool = PiecePool(num_threads if on_cpu else 1)
        self._piece_rows = PIECE_ROWS if on_cpu else 1 << 40
        self._params = self._parameters()
        if type(self.optimizer) is torch.optim.Adam:
            self.optimizer = torch.optim.Adam(self._params, lr=self.learning_rate, fused=True)
        self._time_outs = torch.zeros_like(self.storage.rewards)
        self._plain = self._is_plain()
        if not 0.0 <= mean_reg_coef < math.inf:
            raise ConfigError(f"agent.algorithm.mean_reg_coef is {mean_reg_coef}; it must be at least 0")
        if mean_reg_coef and not self._plain:
            raise ConfigError(
                "agent.algorithm.mean_reg_coef needs a Gaussian multi-layer perceptron without random network"
                " distillation, symmetry or mixed precision; set it to 0"
            )
        self.mean_reg_coef = mean_reg_coef

    def _is_plain(self) -> bool:
        """Whether the networks and settings are those that the piecewise update covers."""
        return (
            type(self._raw_actor) is MLPModel
            and type(self._raw_critic) is MLPModel
            and type(self._raw_actor.distribution) is GaussianDistribution
            and self.rnd is None
            and self.symmetry is None
            and not self.use_mixed_precision
        )

    def _parameters(self) -> list[nn.Parameter]:
        """Everything the loss is differentiated by."""
        return [p for model in (self._raw_actor, self._raw_critic) for p in model.parameters() if p.requires_grad]

    # -- rollout

    def act(self, obs: TensorDict) -> torch.Tensor:
        """Sample actions for ``obs``; the critic is left for :meth:`compute_returns`.

        Returns:
            Actions, shape (num_envs, num_actions).
        """
        if not self._plain:
            return super().act(obs)
        actor, transition = self._raw_actor, self.transition
        raw = torch.cat([obs[group] for group in actor.obs_groups], dim=-1)
        with torch.no_grad():
            mean, std = _mlp(actor, actor.obs_normalizer(raw)), self._std()
            noise = torch.randn_like(mean)
            transition.actions = torch.addcmul(mean, noise, std)
            transition.actions_log_prob = -0.5 * noise.square().sum(-1) - self._log_normaliser(std)
            transition.distribution_params = (mean, std.expand_as(mean))
        transition.values = self.storage.values[self.storage.step]
        transition.observations = obs
        return transition.actions

    def process_env_step(
        self, obs: TensorDict, rewards: torch.Tensor, dones: torch.Tensor, extras: dict[str, torch.Tensor]
    ) -> None:
        """Store one environment step."""
        if not self._plain:
            super().process_env_step(obs, rewards, dones, extras)
            return
        step = self.storage.step
        if "time_outs" in extras:
            self._time_outs[step].copy_(extras["time_outs"].view(-1, 1))
        self.transition.rewards = rewards
        self.transition.dones = dones
        self.storage.add_transition(self.transition)
        self.transition.clear()

    def compute_returns(self, obs: TensorDict) -> None:
        """Values of the whole rollout, bootstrapping on time-outs, then rsl_rl's generalized advantages."""
        if self._plain:
            st = self.storage
            st.values.copy_(self._values_of(st.observations.flatten(0, 1)).view_as(st.values))
            st.rewards.addcmul_(st.values, self._time_outs, value=self.gamma)
        super().compute_returns(obs)
        if self.is_multi_gpu and not self.normalize_advantage_per_mini_batch:
            self.storage.advantages = distributed.standardise(self.storage.returns - self.storage.values)

    def _values_of(self, obs: TensorDict) -> torch.Tensor:
        """The critic's values of all samples, shape (samples, 1)."""
        critic = self._raw_critic
        raw = torch.cat([obs[group] for group in critic.obs_groups], dim=-1)
        bounds = piece_bounds(len(raw), self._piece_rows)

        def piece(k: int) -> torch.Tensor:
            first, last = bounds[k]
            with torch.no_grad():
                return _mlp(critic, critic.obs_normalizer(raw[first:last]))

        return torch.cat(self._pool.map(piece, len(bounds)))

    # -- update

    def update(self) -> dict[str, float]:
        """Several epochs of minibatch updates over the stored rollout.

        Returns:
            Mean value loss, surrogate loss, entropy and divergence between old and new policy.
        """
        if not self._plain:
            return super().update()
        samples = self._gather()
        rows = samples["obs_actor"].shape[0] // self.num_mini_batches
        totals = torch.zeros(3, device=self.device)
        entropy_sum = torch.zeros((), device=self.device)
        for _ in range(self.num_learning_epochs):
            for batch in range(self.num_mini_batches):
                first = batch * rows
                part = {key: value[first : first + rows] for key, value in samples.items()}
                losses, entropy = self._step(part)
                totals += losses
                entropy_sum += entropy
        obs = self.storage.observations.flatten(0, 1)
        with distributed.answers():  # rsl_rl's normalisation takes the samples of all processes
            self._raw_actor.update_normalization(obs)
            self._raw_critic.update_normalization(obs)
        self.storage.clear()
        count = self.num_learning_epochs * self.num_mini_batches
        value, surrogate, kl = (totals / count).tolist()
        return {"value": value, "surrogate": surrogate, "entropy": entropy_sum.item() / count, "kl": kl}

    def _gather(self) -> dict[str, torch.Tensor]:
        """The rollout in the shuffled order of this update, observations normalised once for all epochs."""
        st = self.storage
        count = st.num_envs * st.num_transitions_per_env // self.num_mini_batches * self.num_mini_batches
        order = torch.randperm(count, device=self.device)
        obs = st.observations.flatten(0, 1)

        def network_input(model: Any) -> torch.Tensor:
            with torch.no_grad():
                raw = torch.cat([obs[group] for group in model.obs_groups], dim=-1)
                return model.obs_normalizer(raw[order])

        old_mean, old_std = (p.flatten(0, 1)[order] for p in st.distribution_params)
        samples = {
            "obs_actor": network_input(self._raw_actor),
            "obs_critic": network_input(self._raw_critic),
            "actions": st.actions.flatten(0, 1)[order],
            "values": st.values.flatten()[order],
            "returns": st.returns.flatten()[order],
            "advantages": st.advantages.flatten()[order],
            "old_log_prob": st.actions_log_prob.flatten()[order],
            "old_mean": old_mean,
            "old_std": old_std,
        }
        if self.normalize_advantage_per_mini_batch:
            parts = samples["advantages"].view(self.num_mini_batches, -1)
            samples["advantages"] = ((parts - parts.mean(1, True)) / (parts.std(1, keepdim=True) + 1e-8)).flatten()
        return samples

    def _step(self, batch: dict[str, torch.Tensor]) -> tuple[torch.Tensor, torch.Tensor]:
        """One optimiser step on one minibatch.

        Returns:
            Mean (value loss, surrogate loss, KL divergence) over the minibatch, and the policy's entropy.
        """
        rows = len(batch["actions"])
        bounds = piece_bounds(rows, self._piece_rows)
        params = self._params

        def piece(k: int) -> list[torch.Tensor]:
            first, last = bounds[k]
            with torch.enable_grad():
                loss, stats = self._piece_loss({key: value[first:last] for key, value in batch.items()}, rows)
                return [stats, *torch.autograd.grad(loss, params, allow_unused=True, materialize_grads=True)]

        pieces = self._pool.map(piece, len(bounds))
        total = pieces[0]
        for other in pieces[1:]:
            torch._foreach_add_(total, other)
        if self.is_multi_gpu:
            distributed.average_(total)
        losses, *grads = total
        std = self._std()
        entropy = self._log_normaliser(std) + 0.5 * len(std)
        if self.entropy_coef != 0.0 and entropy.requires_grad:
            param = next(iter(self._raw_actor.distribution.parameters()))
            index = next(k for k, other in enumerate(params) if other is param)
            grads[index] = grads[index] - self.entropy_coef * torch.autograd.grad(entropy, param)[0]
        if self.desired_kl is not None and self.schedule == "adaptive":
            self._adapt_learning_rate(losses[2].item())
        for param, grad in zip(params, grads, strict=True):
            param.grad = grad
        nn.utils.clip_grad_norm_(self._raw_actor.parameters(), self.max_grad_norm, foreach=True)
        nn.utils.clip_grad_norm_(self._raw_critic.parameters(), self.max_grad_norm, foreach=True)
        self.optimizer.step()
        return losses, entropy.detach()

    def _piece_loss(self, piece: dict[str, torch.Tensor], rows: int) -> tuple[torch.Tensor, torch.Tensor]:
        """A piece's share of the minibatch's loss (without the entropy bonus) and of its mean statistics."""
        mean = _mlp(self._raw_actor, piece["obs_actor"])
        values = _mlp(self._raw_critic, piece["obs_critic"]).squeeze(-1)
        std = self._std()
        # Surrogate loss
        deviation = (piece["actions"] - mean) / std
        log_prob = -0.5 * deviation.square().sum(-1) - self._log_normaliser(std)
        ratio = torch.exp(log_prob - piece["old_log_prob"])
        surrogate = -piece["advantages"] * ratio
        clipped = -piece["advantages"] * ratio.clamp(1.0 - self.clip_param, 1.0 + self.clip_param)
        surrogate_loss = torch.max(surrogate, clipped).sum() / rows
        # Value function loss
        value_errors = (values - piece["returns"]).square()
        if self.use_clipped_value_loss:
            near = piece["values"] + (values - piece["values"]).clamp(-self.clip_param, self.clip_param)
            value_errors = torch.max(value_errors, (near - piece["returns"]).square())
        value_loss = value_errors.sum() / rows
        # Divergence of the new policy from the one that acted
        with torch.no_grad():
            old_mean, old_std = piece["old_mean"], piece["old_std"]
            scaled = ((old_std / std).square() + ((old_mean - mean) / std).square() - 1.0) * 0.5
            kl = (scaled - (old_std / std).log()).sum() / rows
            stats = torch.stack([value_loss, surrogate_loss, kl])
        loss = surrogate_loss + self.value_loss_coef * value_loss
        if self.mean_reg_coef:
            loss = loss + self.mean_reg_coef * mean.square().sum() / rows
        return loss, stats

    def _std(self) -> torch.Tensor:
        """Standard deviation of every action, shape (num_actions,), as rsl_rl's Gaussian clamps it."""
        distribution = self._raw_actor.distribution
        if distribution.std_type == "log":
            return distribution.log_std_param.clamp(*distribution.log_std_range).exp()
        return distribution.std_param.clamp(*distribution.std_range)

    @staticmethod
    def _log_normaliser(std: torch.Tensor) -> torch.Tensor:
        """What makes a Gaussian's density integrate to one, as a logarithm; a scalar."""
        return (std.log() + 0.5 * math.log(2 * math.pi)).sum()

    @property
    def action_std(self) -> float:
        """Standard deviation of the actions, averaged over them."""
        if self._plain:
            return float(self._std().detach().mean())
        distribution: Any = self._raw_actor.distribution
        return float(distribution.std.detach().mean())

    def _adapt_learning_rate(self, kl: float) -> None:
        """Keep the divergence of an update near ``desired_kl``."""
        if kl > self.desired_kl * 2.0:
            self.learning_rate = max(1e-5, self.learning_rate / 1.5)
        elif 0.0 < kl < self.desired_kl / 2.0:
            self.learning_rate = min(1e-2, self.learning_rate * 1.5)
        for group in self.optimizer.param_groups:
            group["lr"] = self.learning_rate


def _mlp(model: Any, x: torch.Tensor) -> torch.Tensor:
    """The network's output for normalised inputs, shape (rows, outputs)."""
    modules = list(model.mlp)
    linear = [m for m in modules if isinstance(m, nn.Linear)]
    between = [m for m in modules if not isinstance(m, nn.Linear)]
    if len(between) == len(linear) - 1 and all(type(m) is nn.ELU and m.alpha == 1.0 for m in between):
        return EluMlp.apply(x, *(p for layer in linear for p in (layer.weight, layer.bias)))  # type: ignore[return-value]
    return model.mlp(x)

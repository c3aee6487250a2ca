"""PPO whose update is cut into pieces of fixed size: fast on few cores and the same bits on any number of them.

rsl_rl's :class:`~rsl_rl.algorithms.PPO` stays the algorithm. Two of its steps are done differently here, with the
same mathematics:

- A minibatch's gradient is the sum of the gradients of its pieces (:class:`~lift_lab_rl.threads.PiecePool`), of actor
  and critic apart. The passes through the networks are in :mod:`~lift_lab_rl.rsl_rl.mlp_passes`, the loss and its
  derivatives in :mod:`~lift_lab_rl.rsl_rl.ppo_loss`.
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

from .mlp_passes import BLOCK_ROWS, DEVICE_BLOCK_ROWS, GradientSums, NetworkPasses
from .ppo_loss import divergence, log_normaliser, policy_terms, value_terms
from .time_outs import FINAL_OBS, PREVIOUS_OBS, final_values

PIECE_ROWS = 1536
"""Samples in a piece of the work that threads share, in an update and when the critic looks at a rollout."""

ACTING_ROWS = 256
"""Environments in a piece when the policy acts."""


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
        advantage_clip: float | None = None,
        time_out_bootstrap: str = PREVIOUS_OBS,
        **kwargs: Any,
    ):
        """Build rsl_rl's PPO.

        Args:
            actor: policy network.
            critic: value network.
            storage: rollout storage.
            num_threads: threads the update may use on the CPU; None takes every CPU this process may run on.
            mean_reg_coef: weight in the loss of the squared length of the policy's mean action, averaged over samples.
            advantage_clip: largest size of an advantage in standard deviations (:meth:`compute_returns`); None for
                no limit.
            time_out_bootstrap: observation whose value an episode that a time limit ends is bootstrapped with:
                ``previous_obs`` (before the last action; rsl_rl's form) or ``final_obs`` (after it). The second reads
                ``extras["final_obs"]``.
            **kwargs: rsl_rl's settings.

        Raises:
            ConfigError: ``mean_reg_coef`` is negative, or not zero with networks or extensions that go through
                rsl_rl's own update; ``advantage_clip`` is not above zero; there are more minibatches than samples.
        """
        super().__init__(actor, critic, storage, **kwargs)
        on_cpu = torch.device(self.device).type == "cpu"
        self._pool = PiecePool(num_threads if on_cpu else 1)
        self._piece_rows, self._acting_rows = (PIECE_ROWS, ACTING_ROWS) if on_cpu else (1 << 40, 1 << 40)
        self._block_rows = BLOCK_ROWS if on_cpu else DEVICE_BLOCK_ROWS
        self._params = self._parameters()
        if type(self.optimizer) is torch.optim.Adam:
            self.optimizer = torch.optim.Adam(self._params, lr=self.learning_rate, fused=True)
        self._time_outs = torch.zeros_like(self.storage.rewards)
        self._final_values = torch.zeros_like(self.storage.rewards) if time_out_bootstrap == FINAL_OBS else None
        self._plain = self._is_plain()
        if self._plain:
            self._passes = {id(model): NetworkPasses(model.mlp) for model in (self._raw_actor, self._raw_critic)}
            self._policy_sums: list[GradientSums] = []
            self._value_sums: list[GradientSums] = []
        samples, least = storage.num_envs * storage.num_transitions_per_env, 1
        if self.normalize_advantage_per_mini_batch:
            least = 2  # of one sample there is no deviation
        if samples < least * self.num_mini_batches:
            raise ConfigError(
                f"agent.algorithm.num_mini_batches is {self.num_mini_batches}: a rollout of {storage.num_envs} "
                f"environments and {storage.num_transitions_per_env} steps has {samples} samples, "
                f"enough for {samples // least}"
            )
        if not 0.0 <= mean_reg_coef < math.inf:
            raise ConfigError(f"agent.algorithm.mean_reg_coef is {mean_reg_coef}; it must be at least 0")
        if mean_reg_coef and not self._plain:
            raise ConfigError(
                "agent.algorithm.mean_reg_coef needs a Gaussian multi-layer perceptron without random network"
                " distillation, symmetry or mixed precision; set it to 0"
            )
        self.mean_reg_coef = mean_reg_coef
        if advantage_clip is not None and not 0.0 < advantage_clip < math.inf:
            raise ConfigError(f"agent.algorithm.advantage_clip is {advantage_clip}; it must be above 0, or null")
        self.advantage_clip = advantage_clip

    @property
    def needs_final_obs(self) -> bool:
        """Whether the environment has to give the last observations of the episodes that end."""
        return self._final_values is not None

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
        transition = self.transition
        with torch.no_grad():
            mean, std = self._outputs(self._raw_actor, obs, self._acting_rows), self._std()
            noise = torch.randn_like(mean)
            transition.actions = torch.addcmul(mean, noise, std)
            transition.actions_log_prob = -0.5 * noise.square().sum(-1) - log_normaliser(std)
            transition.distribution_params = (mean, std.expand_as(mean))
        transition.values = self.storage.values[self.storage.step]
        transition.observations = obs
        return transition.actions

    def _outputs(self, model: Any, obs: TensorDict, rows: int) -> torch.Tensor:
        """A network's outputs for all samples, shape (samples, outputs), in pieces of about ``rows``."""
        raw = _raw_input(model, obs)
        bounds = piece_bounds(len(raw), rows)
        network = self._passes[id(model)]

        def piece(k: int) -> torch.Tensor:
            with torch.no_grad():
                passes, outputs = network.here(), []
                for first, last in self._blocks(bounds[k]):
                    outputs.append(passes.forward(model.obs_normalizer(raw[first:last])))
                return torch.cat(outputs)

        return torch.cat(self._pool.map(piece, len(bounds)))

    def _blocks(self, bounds: tuple[int, int]) -> list[tuple[int, int]]:
        """A piece, in blocks that go through the networks at once."""
        start, end = bounds
        return [(start + first, start + last) for first, last in piece_bounds(end - start, self._block_rows)]

    def process_env_step(
        self, obs: TensorDict, rewards: torch.Tensor, dones: torch.Tensor, extras: dict[str, torch.Tensor]
    ) -> None:
        """Store one environment step."""
        step = self.storage.step
        if "time_outs" in extras:
            self._time_outs[step].copy_(extras["time_outs"].view(-1, 1))
        else:
            self._time_outs[step].zero_()
        if self._final_values is not None:
            self._final_values[step].copy_(
                final_values(self._raw_critic, self._time_outs[step], extras.get("final_obs"))
            )
        if not self._plain:
            if self._final_values is not None:  # compute_returns bootstraps
                extras = {key: value for key, value in extras.items() if key != "time_outs"}
            super().process_env_step(obs, rewards, dones, extras)
            return
        self.transition.rewards = rewards
        self.transition.dones = dones
        self.storage.add_transition(self.transition)
        self.transition.clear()

    def compute_returns(self, obs: TensorDict) -> None:
        """Values of the whole rollout, bootstrapping on time-outs, then rsl_rl's generalized advantages.

        With a limit, advantages that are normalised are cut off there and normalised once more.
        """
        if self._plain:
            st = self.storage
            values = self._outputs(self._raw_critic, st.observations.flatten(0, 1), self._piece_rows)
            st.values.copy_(values.view_as(st.values))
        if self._plain or self._final_values is not None:
            values = self.storage.values if self._final_values is None else self._final_values
            self.storage.rewards.addcmul_(values, self._time_outs, value=self.gamma)
        super().compute_returns(obs)
        if self.is_multi_gpu and not self.normalize_advantage_per_mini_batch:
            self.storage.advantages = distributed.standardise(self.storage.returns - self.storage.values)
        limit = self.advantage_clip
        if limit is not None:
            self.storage.advantages = distributed.standardise(self.storage.advantages.clamp(-limit, limit))

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
        self._update_normalization()
        self.storage.clear()
        count = self.num_learning_epochs * self.num_mini_batches
        value, surrogate, kl = (totals / count).tolist()
        return {"value": value, "surrogate": surrogate, "entropy": entropy_sum.item() / count, "kl": kl}

    def _update_normalization(self) -> None:
        """Take the rollout's observations into the networks' normalisation, once where both are the same."""
        obs, shared = self.storage.observations.flatten(0, 1), self._inputs_are_shared()
        with distributed.answers():  # rsl_rl's normalisation takes the samples of all processes
            self._raw_actor.update_normalization(obs)
            if shared:
                self._raw_critic.obs_normalizer.load_state_dict(self._raw_actor.obs_normalizer.state_dict())
            else:
                self._raw_critic.update_normalization(obs)

    def _inputs_are_shared(self) -> bool:
        """Whether actor and critic see the same numbers: the same groups of observations, normalised alike."""
        actor, critic = self._raw_actor, self._raw_critic
        ours, theirs = actor.obs_normalizer, critic.obs_normalizer
        return (
            actor.obs_groups == critic.obs_groups
            and type(ours) is type(theirs)
            and ours.training == theirs.training
            and all(torch.equal(a, b) for a, b in zip(ours.buffers(), theirs.buffers(), strict=True))
        )

    def _gather(self) -> dict[str, torch.Tensor]:
        """The rollout in the shuffled order of this update, observations normalised once for all epochs."""
        st = self.storage
        count = st.num_envs * st.num_transitions_per_env // self.num_mini_batches * self.num_mini_batches
        order = torch.randperm(count, device=self.device)
        obs = st.observations.flatten(0, 1)

        def shuffled(values: torch.Tensor) -> torch.Tensor:
            return values.index_select(0, order)

        def network_input(model: Any) -> torch.Tensor:
            with torch.no_grad():
                return model.obs_normalizer(shuffled(_raw_input(model, obs)))

        obs_actor = network_input(self._raw_actor)
        samples = {
            "obs_actor": obs_actor,
            "obs_critic": obs_actor if self._inputs_are_shared() else network_input(self._raw_critic),
            "actions": shuffled(st.actions.flatten(0, 1)),
            "values": shuffled(st.values.flatten()),
            "returns": shuffled(st.returns.flatten()),
            "advantages": shuffled(st.advantages.flatten()),
            "old_log_prob": shuffled(st.actions_log_prob.flatten()),
            "old_mean": shuffled(st.distribution_params[0].flatten(0, 1)),
        }
        if self.normalize_advantage_per_mini_batch:
            parts = samples["advantages"].view(self.num_mini_batches, -1)
            if self.is_multi_gpu:
                scaled = torch.stack([distributed.standardise(part) for part in parts])
            else:
                scaled = (parts - parts.mean(1, True)) / (parts.std(1, keepdim=True) + 1e-8)
            samples["advantages"] = scaled.flatten()
        return samples

    @torch.no_grad()
    def _step(self, batch: dict[str, torch.Tensor]) -> tuple[torch.Tensor, torch.Tensor]:
        """One optimiser step on one minibatch.

        Returns:
            Mean (value loss, surrogate loss, KL divergence) over the minibatch, and the policy's entropy.
        """
        bounds = piece_bounds(len(batch["actions"]), self._piece_rows)
        std = self._std()
        policy, value = self._sums_of(batch, bounds, std)
        grad_std, surrogate, drift = policy.extra.split([len(std), 1, len(std)])
        kl = divergence(std, self.storage.distribution_params[1][0, 0], drift)
        if self.desired_kl is not None and self.schedule == "adaptive":
            self._adapt_learning_rate(kl.item())
        grad_std -= self.entropy_coef / std  # of the entropy: its derivative by each deviation is one over it
        std_param = self._std_by_parameter(grad_std)
        grads, weights = {std_param: grad_std}, policy.vector[: -len(policy.extra)]
        for model, sums in ((self._raw_actor, policy), (self._raw_critic, value)):
            grads.update(zip(model.mlp.parameters(), sums.grads, strict=True))
        for param in self._params:
            param.grad = grads[param]
        self._clip([weights, grad_std] if std_param.requires_grad else [weights])
        self._clip([value.vector[: -len(value.extra)]])
        self.optimizer.step()
        losses = torch.cat([value.extra, surrogate, kl.view(1)])
        return losses, log_normaliser(std) + 0.5 * len(std)

    def _sums_of(
        self, batch: dict[str, torch.Tensor], bounds: list[tuple[int, int]], std: torch.Tensor
    ) -> tuple[GradientSums, GradientSums]:
        """The minibatch's gradients, averaged over its samples.

        Returns:
            Of the actor, with the derivative by the standard deviations, the surrogate loss and the squared drift of
            the mean action; of the critic, with the value loss.
        """
        while len(self._policy_sums) < len(bounds):
            self._policy_sums.append(GradientSums(list(self._raw_actor.mlp.parameters()), 2 * len(std) + 1))
            self._value_sums.append(GradientSums(list(self._raw_critic.mlp.parameters()), 1))

        def job(number: int) -> None:
            piece, of_critic = divmod(number, 2)
            if of_critic:
                self._value_piece(batch, bounds[piece], self._value_sums[piece])
            else:
                self._policy_piece(batch, bounds[piece], std, self._policy_sums[piece])

        self._pool.map(job, 2 * len(bounds))
        totals = []
        for sums in (self._policy_sums, self._value_sums):
            for other in sums[1 : len(bounds)]:
                sums[0].vector += other.vector
            sums[0].vector /= len(batch["actions"])
            totals.append(sums[0])
        if self.is_multi_gpu:
            distributed.average_([sums.vector for sums in totals])
        return totals[0], totals[1]

    @torch.no_grad()
    def _policy_piece(
        self, batch: dict[str, torch.Tensor], bounds: tuple[int, int], std: torch.Tensor, sums: GradientSums
    ) -> None:
        """Gradients of the actor over a piece of a minibatch, summed over samples, into ``sums``."""
        passes = self._passes[id(self._raw_actor)].here()
        sums.vector.zero_()
        for first, last in self._blocks(bounds):
            terms = policy_terms(
                passes.forward(batch["obs_actor"][first:last]),
                std,
                **{name: batch[name][first:last] for name in ("actions", "old_mean", "old_log_prob", "advantages")},
                clip_param=self.clip_param,
                mean_reg_coef=self.mean_reg_coef,
            )
            sums.extra += torch.cat([terms.grad_std, terms.surrogate.view(1), terms.drift])
            passes.backward(terms.grad_mean, sums.grads)

    @torch.no_grad()
    def _value_piece(self, batch: dict[str, torch.Tensor], bounds: tuple[int, int], sums: GradientSums) -> None:
        """Gradients of the critic over a piece of a minibatch, summed over samples, into ``sums``."""
        passes = self._passes[id(self._raw_critic)].here()
        sums.vector.zero_()
        for first, last in self._blocks(bounds):
            loss, grad = value_terms(
                passes.forward(batch["obs_critic"][first:last]).squeeze(-1),
                old_values=batch["values"][first:last],
                returns=batch["returns"][first:last],
                clip_param=self.clip_param if self.use_clipped_value_loss else None,
            )
            sums.extra += loss
            passes.backward(grad.mul_(self.value_loss_coef).unsqueeze(-1), sums.grads)

    def _clip(self, grads: list[torch.Tensor]) -> None:
        """Shorten a network's gradient to ``max_grad_norm``."""
        norm = torch.linalg.vector_norm(torch.stack([torch.linalg.vector_norm(grad) for grad in grads]))
        torch._foreach_mul_(grads, (self.max_grad_norm / (norm + 1e-6)).clamp_(max=1.0))

    def _std(self) -> torch.Tensor:
        """Standard deviation of every action, shape (num_actions,), as rsl_rl's Gaussian clamps it."""
        distribution = self._raw_actor.distribution
        if distribution.std_type == "log":
            return distribution.log_std_param.clamp(*distribution.log_std_range).exp()
        return distribution.std_param.clamp(*distribution.std_range)

    def _std_by_parameter(self, grad: torch.Tensor) -> nn.Parameter:
        """Turn the derivative by the standard deviations into that by the parameter they come from, in place.

        Returns:
            The parameter.
        """
        distribution = self._raw_actor.distribution
        in_log = distribution.std_type == "log"
        param = distribution.log_std_param if in_log else distribution.std_param
        limited = param.clamp(*(distribution.log_std_range if in_log else distribution.std_range))
        grad *= param == limited
        if in_log:
            grad *= limited.exp()
        return param

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


def _raw_input(model: Any, obs: TensorDict) -> torch.Tensor:
    """The observations that a network sees, not normalised, shape (samples, inputs)."""
    groups = [obs[group] for group in model.obs_groups]
    return groups[0] if len(groups) == 1 else torch.cat(groups, dim=-1)

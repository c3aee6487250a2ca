"""Our PPO: rsl_rl's algorithm with parts that can each be switched off (docs/ppo.md).

:class:`LiftLabPPO` is rsl_rl's :class:`~rsl_rl.algorithms.PPO` and these parts:

- schedules (:mod:`~lift_lab_rl.rsl_rl.schedules`), advantage clipping (:mod:`~lift_lab_rl.rsl_rl.advantages`), time-out
  bootstrap (:mod:`~lift_lab_rl.rsl_rl.time_outs`), exploration aids (:mod:`~lift_lab_rl.rsl_rl.exploration`) and an
  EMA of the policy (:mod:`~lift_lab_rl.rsl_rl.ema`);
- an update in micro-batches on threads (:mod:`~lift_lab_rl.rsl_rl.micro_batches`). It takes the same steps as rsl_rl's
  update, up to rounding, also with rsl_rl's symmetry extension (:mod:`~lift_lab_rl.rsl_rl.symmetry`). The loss and its
  derivatives are in :mod:`~lift_lab_rl.rsl_rl.ppo_loss`.

With every part off, rollout and update are rsl_rl's, bit by bit.

With several processes (:mod:`~lift_lab_rl.distributed`) gradients, divergence and the scale of the advantages are those
of all their samples together, in one exchange a minibatch: all processes take the same steps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import torch
from rsl_rl.algorithms import PPO
from rsl_rl.models import MLPModel
from rsl_rl.modules.distribution import GaussianDistribution
from tensordict import TensorDict
from torch import nn

from lift_lab.utils.errors import ConfigError
from lift_lab_rl import distributed

from .advantages import AdvantageClip
from .ema import AVERAGE, LAST, PolicyEma
from .exploration import add_mean_regularisation, set_initial_mean
from .gaussian import divergence, entropy, log_normaliser, standard_deviation, to_parameter_gradient
from .micro_batches import MicroBatches
from .mlp_gradients import GradientSums
from .network_inputs import inputs_are_shared, network_input, update_normalization
from .ppo_loss import policy_terms, value_terms
from .schedules import LinearSchedule, adapted_rate
from .symmetric_policy import SymmetricMlp
from .symmetry import MirroredSamples, policy_maps
from .time_outs import PREVIOUS_OBS, TimeOutBootstrap

ANNEAL_FROM = "anneal_from"
"""Entry of a checkpoint: iteration from which schedules count that begin at a success rate."""

ACTOR, CRITIC = 0, 1
"""Numbers of the networks in :class:`~lift_lab_rl.rsl_rl.micro_batches.MicroBatches`."""


class LiftLabPPO(PPO):
    """Proximal policy optimization (Schulman et al. 2017, arXiv:1707.06347).

    Attributes:
        iteration: updates done.
        schedules: name of a setting -> its schedule.
        anneal_at_success: smoothed success rate at which the schedules begin; None for the start of the training.
        anneal_from: iteration from which the schedules count; None before the success rate was reached.
        advantage_clip: clips advantages.
        time_outs: bootstraps episodes that a time limit ends.
        ema: moving average of the policy; None without one.
        micro_batches: runs the networks; None where rollout and update are rsl_rl's.
        mirrored: mirrored samples of our update; None without symmetry.
        averages_by_setting: whether the policy is exactly symmetric because the configuration asks for it.
    """

    transition: Any
    storage: Any
    anneal_from: int | None

    def __init__(
        self,
        actor: MLPModel,
        critic: MLPModel,
        storage: Any,
        *,
        micro_batches: bool | None = None,
        num_threads: int | None = None,
        entropy_coef_final: float | None = None,
        desired_kl_final: float | None = None,
        gamma_final: float | None = None,
        anneal_iterations: tuple[int, int] = (0, 0),
        anneal_at_success: float | None = None,
        mean_reg_coef: float = 0.0,
        init_action_mean: Sequence[float] | None = None,
        advantage_clip: float | None = None,
        advantage_clip_start: int = 0,
        time_out_bootstrap: str = PREVIOUS_OBS,
        average_share: float = 0.0,
        **kwargs: Any,
    ):
        """Build rsl_rl's PPO and the parts.

        Args:
            actor: policy network.
            critic: value network.
            storage: rollout storage.
            micro_batches: whether the update is ours; None where networks and extensions allow.
            num_threads: threads that share the micro-batches on a CPU; None takes every CPU this process may run on.
            entropy_coef_final: ``entropy_coef`` at the end of its schedule; None for no schedule.
            desired_kl_final: ``desired_kl`` at the end; None for no schedule.
            gamma_final: ``gamma`` at the end; None for no schedule.
            anneal_iterations: first and last iteration of these schedules.
            anneal_at_success: smoothed success rate at which their iterations, and that of ``advantage_clip_start``,
                begin to count (:meth:`note_success`); None counts from the start.
            mean_reg_coef: weight in the loss of the squared length of the policy's mean action, averaged over samples.
            init_action_mean: mean action that a new policy begins with; None for what the network says.
            advantage_clip: largest size of an advantage in standard deviations; None for no limit.
            advantage_clip_start: first iteration that clips advantages.
            time_out_bootstrap: observation that an episode which a time limit ends is bootstrapped with,
                ``previous_obs`` or ``final_obs`` (:class:`~lift_lab_rl.rsl_rl.time_outs.TimeOutBootstrap`).
            average_share: share of the training that the EMA of the policy covers; 0 for no EMA.
            **kwargs: rsl_rl's settings.

        Raises:
            ConfigError: a value is out of range, micro-batches or ``mean_reg_coef`` are asked for with networks or
                extensions that go through rsl_rl's update, or there are more minibatches than samples.
        """
        super().__init__(actor, critic, storage, **kwargs)
        self.iteration = 0
        finals = {"entropy_coef": entropy_coef_final, "desired_kl": desired_kl_final, "gamma": gamma_final}
        self.schedules = {
            name: LinearSchedule(getattr(self, name), final, *anneal_iterations)
            for name, final in finals.items()
            if final is not None
        }
        self.advantage_clip = AdvantageClip(advantage_clip, advantage_clip_start)
        self.anneal_at_success = anneal_at_success
        self.anneal_from = 0 if anneal_at_success is None else None
        self.time_outs = TimeOutBootstrap(time_out_bootstrap, storage.rewards)
        self._check_minibatches()
        self.micro_batches = self._make_micro_batches(micro_batches, num_threads)
        self.mirrored = None
        self.averages_by_setting = isinstance(self.actor, SymmetricMlp)
        if self.symmetry is not None:
            groups = self._groups() if self.micro_batches else list(storage.observations.keys())
            mirror = self.actor.mirror if isinstance(self.actor, SymmetricMlp) else None
            self.mirrored = MirroredSamples(self.symmetry, groups, mirror)
            self.mirrored.check(storage.observations[0], storage.actions[0])
            if mirror is not None:
                mirror.set_maps(*policy_maps(self.symmetry, self.actor.obs_groups))
        self.mean_reg_coef = self._checked_mean_reg(mean_reg_coef)
        if init_action_mean is not None:
            set_initial_mean(actor.mlp, init_action_mean)
        self.ema = PolicyEma(actor, average_share) if average_share else None

    def _check_minibatches(self) -> None:
        st = self.storage
        samples = st.num_envs * st.num_transitions_per_env
        least = 2 if self.normalize_advantage_per_mini_batch else 1  # of one sample there is no deviation
        if samples < least * self.num_mini_batches:
            raise ConfigError(
                f"agent.algorithm.num_mini_batches is {self.num_mini_batches}: a rollout of {st.num_envs} "
                f"environments and {st.num_transitions_per_env} steps has {samples} samples, "
                f"enough for {samples // least}"
            )

    def _make_micro_batches(self, wanted: bool | None, num_threads: int | None) -> MicroBatches | None:
        """Our update, with an optimiser that needs less time; None for rsl_rl's update."""
        if wanted and not self._is_covered():
            raise ConfigError(
                "agent.algorithm.micro_batches needs a Gaussian multi-layer perceptron without random network "
                "distillation or mixed precision; set it to null"
            )
        if wanted is False or not self._is_covered():
            return None
        if type(self.optimizer) is torch.optim.Adam:
            self.optimizer = torch.optim.Adam(self._parameters(), lr=self.learning_rate, fused=True)
        return MicroBatches([self.actor.mlp, self.critic.mlp], self.device, num_threads)

    def _checked_mean_reg(self, coef: float) -> float:
        if not 0.0 <= coef < math.inf:
            raise ConfigError(f"agent.algorithm.mean_reg_coef is {coef}; it must be at least 0")
        if coef and self.micro_batches is None:
            raise ConfigError(
                "agent.algorithm.mean_reg_coef needs micro-batches: a Gaussian multi-layer perceptron without random "
                "network distillation or mixed precision; set it to 0"
            )
        return coef

    def _is_covered(self) -> bool:
        """Whether micro-batches support the networks and extensions."""
        return (
            type(self.actor) in (MLPModel, SymmetricMlp)
            and type(self.critic) is MLPModel
            and type(self.actor.distribution) is GaussianDistribution
            and self.rnd is None
            and not self.use_mixed_precision
        )

    def _groups(self) -> list[str]:
        """Observation groups that the networks see."""
        return list(dict.fromkeys([*self.actor.obs_groups, *self.critic.obs_groups]))

    def _parameters(self) -> list[nn.Parameter]:
        """Everything the loss is differentiated by."""
        return [p for model in (self.actor, self.critic) for p in model.parameters() if p.requires_grad]

    # -- rollout

    def act(self, obs: TensorDict) -> torch.Tensor:
        """Sample actions for ``obs``.

        Micro-batches compute the values of the whole rollout later, in :meth:`compute_returns`.

        Returns:
            Actions, shape (num_envs, num_actions).
        """
        if self.micro_batches is None:
            return super().act(obs)
        transition = self.transition
        with torch.no_grad():
            mean, std = self._outputs(ACTOR, obs, self.micro_batches.acting_rows), self._std()
            noise = torch.randn_like(mean)
            transition.actions = torch.addcmul(mean, noise, std)
            transition.actions_log_prob = -0.5 * noise.square().sum(-1) - log_normaliser(std)
            transition.distribution_params = (mean, std.expand_as(mean))
        transition.values = self.storage.values[self.storage.step]
        transition.observations = obs
        return transition.actions

    def process_env_step(
        self, obs: TensorDict, rewards: torch.Tensor, dones: torch.Tensor, extras: dict[str, torch.Tensor]
    ) -> None:
        """Store one environment step; :meth:`compute_returns` bootstraps time-outs."""
        self.time_outs.record(self.storage.step, extras, self.critic)
        super().process_env_step(obs, rewards, dones, {k: v for k, v in extras.items() if k != "time_outs"})

    def compute_returns(self, obs: TensorDict) -> None:
        """Returns and advantages of the rollout, after the iteration's settings are set.

        Args:
            obs: observations after the last step.
        """
        since_start = -1 if self.anneal_from is None else self.iteration - self.anneal_from
        for name, schedule in self.schedules.items():
            setattr(self, name, schedule.value(since_start))
        st = self.storage
        if self.micro_batches is not None:
            values = self._outputs(CRITIC, st.observations.flatten(0, 1), self.micro_batches.rows)
            st.values.copy_(values.view_as(st.values))
        self.time_outs.add_to(st.rewards, st.values, self.gamma)
        super().compute_returns(obs)
        if self.is_multi_gpu and not self.normalize_advantage_per_mini_batch:
            st.advantages = distributed.standardise(st.returns - st.values)
        st.advantages = self.advantage_clip(st.advantages, since_start)

    def note_success(self, rate: float | None) -> bool:
        """Begin the schedules if the success rate is high enough for the first time; call after each update.

        Args:
            rate: smoothed success rate of the training; None while it is not known.

        Returns:
            Whether they begin now.
        """
        if self.anneal_from is not None or self.anneal_at_success is None:
            return False
        if rate is None or rate < self.anneal_at_success:
            return False
        self.anneal_from = self.iteration
        return True

    def _outputs(self, network: int, obs: TensorDict, rows: int) -> torch.Tensor:
        """A network's outputs for all samples, shape (samples, outputs)."""
        assert self.micro_batches is not None
        model = self.critic if network == CRITIC else self.actor
        inputs = network_input(model, obs)
        if not isinstance(model, SymmetricMlp):
            return self.micro_batches.outputs(network, inputs, model.obs_normalizer, rows)
        both = torch.cat([inputs, model.mirror.obs(inputs)])
        outputs = self.micro_batches.outputs(network, both, model.obs_normalizer, rows)
        return model.mirror.mean(outputs.view(2, len(inputs), -1))

    # -- update

    def update(self) -> dict[str, float]:
        """Several epochs of minibatch updates over the stored rollout.

        Returns:
            Mean value loss, surrogate loss, entropy; with micro-batches the divergence between old and new policy too,
            with an extension its loss, such as the mirror loss.
        """
        losses = super().update() if self.micro_batches is None else self._update_in_micro_batches()
        self.iteration += 1
        if self.ema is not None:
            self.ema.update(self.iteration)
        return losses

    def _update_in_micro_batches(self) -> dict[str, float]:
        samples = self._gather()
        minibatches = [
            dict(zip(samples, parts, strict=True))
            for parts in zip(*(value.tensor_split(self.num_mini_batches) for value in samples.values()), strict=True)
        ]
        names = ["value", "surrogate", "entropy", "kl", *(["symmetry"] if self.mirrored else [])]
        totals = torch.zeros(len(names), device=self.device)
        for _ in range(self.num_learning_epochs):
            for minibatch in minibatches:
                totals += self._step(minibatch)
        update_normalization(self.actor, self.critic, self.storage.observations.flatten(0, 1))
        with torch.no_grad():  # rsl_rl's runner logs the deviation of the last distribution
            assert self.actor.distribution is not None
            self.actor.distribution.update(self.storage.distribution_params[0][0])
        self.storage.clear()
        means = (totals / (self.num_learning_epochs * self.num_mini_batches)).tolist()
        return dict(zip(names, means, strict=True))

    def _gather(self) -> dict[str, torch.Tensor]:
        """The rollout in the shuffled order of this update, observations normalised once for all epochs.

        With symmetry every sample is followed by its images: those of the actor, and those of the critic where the
        images are samples of their own.
        """
        st, mirrored = self.storage, self.mirrored
        count = st.num_envs * st.num_transitions_per_env // self.num_mini_batches * self.num_mini_batches
        order = torch.randperm(count, device=self.device)
        obs = st.observations.flatten(0, 1)

        def shuffled(values: torch.Tensor) -> torch.Tensor:
            return values.index_select(0, order)

        def normalised(model: Any, obs: TensorDict) -> torch.Tensor:
            with torch.no_grad():
                return model.obs_normalizer(network_input(model, obs))

        for_actor = {
            "actions": shuffled(st.actions.flatten(0, 1)),
            "advantages": self._scaled_by_minibatch(shuffled(st.advantages.flatten())),
            "old_log_prob": shuffled(st.actions_log_prob.flatten()),
            "old_mean": shuffled(st.distribution_params[0].flatten(0, 1)),
        }
        for_critic = {"values": shuffled(st.values.flatten()), "returns": shuffled(st.returns.flatten())}
        groups = self._groups() if mirrored is None else list(obs.keys())  # the function may need any
        own = every = TensorDict({name: shuffled(obs[name]) for name in groups}, batch_size=[count])
        if mirrored is not None:
            every, actions = mirrored.append(own, for_actor["actions"])
            if mirrored.rows_per_sample == 1:
                for_actor = {**mirrored.repeated(for_actor), "actions": actions}
            if mirrored.augments:
                for_critic, own = mirrored.repeated(for_critic), every
        obs_actor = normalised(self.actor, every)
        shared = own is every and inputs_are_shared(self.actor, self.critic)
        obs_critic = obs_actor if shared else normalised(self.critic, own)
        return {"obs_actor": obs_actor, "obs_critic": obs_critic, **for_actor, **for_critic}

    def _scaled_by_minibatch(self, advantages: torch.Tensor) -> torch.Tensor:
        if not self.normalize_advantage_per_mini_batch:
            return advantages
        parts = advantages.view(self.num_mini_batches, -1)
        if self.is_multi_gpu:
            return torch.stack([distributed.standardise(part) for part in parts]).flatten()
        return ((parts - parts.mean(1, True)) / (parts.std(1, keepdim=True) + 1e-8)).flatten()

    @torch.no_grad()
    def _step(self, batch: dict[str, torch.Tensor]) -> torch.Tensor:
        """One optimiser step on one minibatch.

        Returns:
            Mean value loss, surrogate loss, entropy and divergence over the minibatch, and with symmetry the mirror
            loss, shape (4,) or (5,).
        """
        assert self.micro_batches is not None
        std, mirrored = self._std(), self.mirrored
        policy, value = self.micro_batches.gradients(
            [batch["obs_actor"], batch["obs_critic"]],
            [
                lambda mean, rows: self._policy_loss(mean, std, batch, rows),
                lambda values, rows: self._value_loss(values, batch["values"][rows], batch["returns"][rows]),
            ],
            [2 * len(std) + (1 if mirrored is None else 2), 1],
            [1 if mirrored is None else mirrored.copies, 1],
        )
        grad_std, surrogate, drift, symmetry = policy.extra.tensor_split([len(std), len(std) + 1, 2 * len(std) + 1])
        kl = divergence(std, self.storage.distribution_params[1][0, 0], drift)
        if self.desired_kl is not None and self.schedule == "adaptive":
            self._set_learning_rate(adapted_rate(self.learning_rate, kl.item(), self.desired_kl))
        self._apply(policy, value, grad_std - self.entropy_coef / std)  # d entropy / d std = 1 / std
        return torch.cat([value.extra, surrogate, entropy(std).view(1), kl.view(1), symmetry])

    def _policy_loss(
        self, mean: torch.Tensor, std: torch.Tensor, batch: dict[str, torch.Tensor], rows: slice
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Derivative by ``mean``, and sums: derivative by the deviations, surrogate loss, squared drift of the mean,
        and with symmetry the mirror loss."""
        names, mirrored = ("actions", "old_mean", "old_log_prob", "advantages"), self.mirrored
        outputs, per_sample = mean, 1 if mirrored is None else mirrored.rows_per_sample
        if mirrored is not None:
            mean, rows = mirrored.means(outputs), slice(rows.start // per_sample, rows.stop // per_sample)
        samples = {name: batch[name][rows] for name in names}
        terms = policy_terms(mean, std, **samples, clip_param=self.clip_param)
        add_mean_regularisation(terms.grad_mean, mean, self.mean_reg_coef)
        sums = [terms.grad_std, terms.surrogate.view(1), terms.drift]
        if mirrored is None:
            return terms.grad_mean, torch.cat(sums)
        # the divergence is that of the given samples, as in rsl_rl
        sums[2] = mirrored.of_given((mean - samples["old_mean"]).square_())
        grad = mirrored.to_outputs(terms.grad_mean)
        loss = mirrored.loss(outputs, grad)
        return grad, torch.cat([*(value * per_sample for value in sums), loss.view(1)])

    def _value_loss(
        self, values: torch.Tensor, old_values: torch.Tensor, returns: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Derivative by ``values``, shape (rows, 1), and the value loss."""
        clip = self.clip_param if self.use_clipped_value_loss else None
        loss, grad = value_terms(values.squeeze(-1), old_values=old_values, returns=returns, clip_param=clip)
        return grad.mul_(self.value_loss_coef).unsqueeze(-1), loss.view(1)

    def _apply(self, policy: GradientSums, value: GradientSums, grad_std: torch.Tensor) -> None:
        """Clip the gradients and let the optimiser take a step."""
        std_param = to_parameter_gradient(self.actor.distribution, grad_std)
        grads = {std_param: grad_std}
        for model, sums in ((self.actor, policy), (self.critic, value)):
            grads.update(zip(model.mlp.parameters(), sums.grads, strict=True))
        for param in self._parameters():
            param.grad = grads[param]
        self._clip([policy.weights, grad_std] if std_param.requires_grad else [policy.weights])
        self._clip([value.weights])
        self.optimizer.step()

    def _clip(self, grads: list[torch.Tensor]) -> None:
        """Shorten a network's gradient to ``max_grad_norm``."""
        norm = torch.linalg.vector_norm(torch.stack([torch.linalg.vector_norm(grad) for grad in grads]))
        factor = (self.max_grad_norm / (norm + 1e-6)).clamp_(max=1.0)
        torch._foreach_mul_(grads, factor)  # pyright: ignore[reportPrivateImportUsage]

    def _set_learning_rate(self, rate: float) -> None:
        self.learning_rate = rate
        for group in self.optimizer.param_groups:
            group["lr"] = rate

    def _std(self) -> torch.Tensor:
        return standard_deviation(self.actor.distribution)

    # -- checkpoints

    def average_with_images(self) -> None:
        """Make the actor an exactly symmetric policy, with maps that change nothing until some are loaded."""
        if not isinstance(self.actor, SymmetricMlp):
            self.actor = self._raw_actor = SymmetricMlp.like(self.actor)
            if self.ema is not None:
                self.ema.actor = self.actor

    def save(self) -> dict[str, Any]:
        """Networks, optimisers, the EMA, and where the schedules began."""
        content = super().save()
        if self.ema is not None:
            content[AVERAGE] = self.ema.state_dict()
        if self.anneal_at_success is not None and self.anneal_from is not None:
            content[ANNEAL_FROM] = self.anneal_from
        return content

    def load(self, loaded_dict: dict[str, Any], load_cfg: dict[str, bool] | None, strict: bool) -> bool:
        """Load what :meth:`save` returned, with the runner's ``iter``.

        Args:
            loaded_dict: the content of a checkpoint. One without an EMA starts it at the loaded policy.
            load_cfg: parts to load; None for all.
            strict: whether the networks' parameters must match exactly.

        Returns:
            Whether the iteration was loaded.
        """
        with_iteration = super().load(loaded_dict, load_cfg, strict)
        if with_iteration:
            self.iteration = loaded_dict["iter"]
            if self.anneal_at_success is not None:
                self.anneal_from = loaded_dict.get(ANNEAL_FROM)
        if self.ema is not None and (load_cfg is None or load_cfg.get("actor")):
            self.ema.load_state_dict(loaded_dict.get(AVERAGE, loaded_dict[LAST]))
        return with_iteration

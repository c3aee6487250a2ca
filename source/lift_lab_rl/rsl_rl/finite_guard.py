"""Stop a training before numbers that are not finite reach the policy.

A rollout is checked before its update, the networks after it. Nothing is read from a GPU in between. The term that is
to blame is searched for only when a number is not finite.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any

import torch

from lift_lab_rl import distributed
from lift_lab_rl.counters import manager_env
from lift_lab_rl.nonfinite import (
    NonFiniteError,
    extremes_of,
    leaves,
    listed,
    observation_terms,
    reward_terms,
    sentence,
)

_LARGE = 1e6
"""Observations and rewards above this are named as the cause of an update that overflows."""


class FiniteGuard:
    """Check of the inputs and results of an update for NaN and infinity."""

    def __init__(self, env: Any, alg: Any, tensors: Iterable[torch.Tensor]):
        """Keep what is looked at.

        Args:
            env: environment, as rsl_rl sees it.
            alg: rsl_rl's algorithm.
            tensors: parameters and buffers of the networks, which live as long as the algorithm.
        """
        self.env, self.alg, self._tensors = env, alg, list(tensors)
        self._looks: list[tuple[str, torch.Tensor]] = []

    def update(self, iteration: int, last_obs: Any, logs: Iterable[dict[str, Any]]) -> dict[str, float]:
        """Compute returns and update the policy, with a look at every number before and after.

        Args:
            iteration: number of the iteration, from 1.
            last_obs: observations after the last step, which no transition holds.
            logs: the environment's logs of the rollout.

        Returns:
            Mean losses.

        Raises:
            NonFiniteError: a number is not finite; networks and optimiser are as before the update.
        """
        with torch.inference_mode():
            self.look_at_rollout(last_obs)
            self.alg.compute_returns(last_obs)
        self.check_rollout(iteration, last_obs, logs)
        self.keep()
        losses = self.alg.update()
        self.check_update(iteration, losses)
        return losses

    # -- before the update

    def look_at_rollout(self, last_obs: Any) -> None:
        """Note the extremes of the rollout, on the device. Call before the returns are computed.

        Args:
            last_obs: observations after the last step, which no transition holds.
        """
        st = self.alg.storage
        self._looks = [("rewards", st.rewards), ("actions", st.actions)]
        self._looks += [("observations", values) for values in leaves(st.observations).values()]
        self._looks += [("observations", values) for values in leaves(last_obs).values()]
        self._looks = [(name, extremes_of(values)) for name, values in self._looks]

    def check_rollout(self, iteration: int, last_obs: Any, logs: Iterable[dict[str, Any]]) -> None:
        """Read the extremes once, with those of values, returns and advantages.

        Args:
            iteration: number of the iteration, from 1.
            last_obs: as in :meth:`look_at_rollout`.
            logs: the environment's logs of the rollout.

        Raises:
            NonFiniteError: names the first term that is not finite.
        """
        st = self.alg.storage
        names = ("values", "returns", "advantages")
        looks = [*self._looks, *((name, extremes_of(getattr(st, name))) for name in names)]
        read = torch.stack([extremes for _, extremes in looks]).tolist()
        self._looks = []
        self._largest = dict.fromkeys(("rewards", "observations"), 0.0)
        bad = []
        for (name, _), extremes in zip(looks, read, strict=True):
            if not all(map(math.isfinite, extremes)):
                bad.append(name)
            elif name in self._largest:
                self._largest[name] = max(self._largest[name], *map(abs, extremes))
        logs, problem = list(logs), None
        if bad:
            found = self._first(bad, last_obs, logs) or f"the {bad[0]} of the rollout are not finite; {self._cause()}"
            problem = f"iteration {iteration}: {found}; the update was not made"
        problem = distributed.first_problem(problem)
        if problem is not None:
            st.clear()
            raise NonFiniteError(problem)

    def _first(self, bad: list[str], last_obs: Any, logs: list[dict[str, Any]]) -> str | None:
        """The term behind the earliest number that is not finite; None if terms, actions and rewards are finite."""
        st, env, count = self.alg.storage, manager_env(self.env), len(self.alg.storage.rewards)
        found: list[tuple[int, int, str]] = []
        for name, values in leaves(st.observations).items():
            values = torch.cat([values, leaves(last_obs)[name].unsqueeze(0)])
            for step, where in _first_bad(values):
                terms = observation_terms(env, name, where) or [f"observation group '{name}'"]
                found.append((step, 0, f"{sentence(terms, values[step], where)} after step {step} of {count}"))
        for step, where in _first_bad(st.actions):
            text = sentence(["the policy's action"], st.actions[step], where)
            found.append((step, 1, f"{text} in step {step + 1} of {count}"))
        for step, where in _first_bad(st.rewards) if "rewards" in bad else ():
            terms = reward_terms(env, where.flatten(1).any(1), logs) or ["the sum of the rewards"]
            text = sentence(terms, st.rewards[step], where)
            found.append((step, 2, f"{text} in step {step + 1} of {count}"))
        return min(found)[2] if found else None

    def _cause(self) -> str:
        """What most likely drove the numbers out of range, if no term itself is infinite."""
        env, st = manager_env(self.env), self.alg.storage
        if self._largest["observations"] > _LARGE:
            name, values = max(leaves(st.observations).items(), key=lambda item: float(item[1].abs().max()))
            bad = values[values.abs().flatten(2).amax((1, 2)).argmax()].abs() == self._largest["observations"]
            terms = observation_terms(env, name, bad) or [f"observation group '{name}'"]
            return f"{listed(terms)} is up to {self._largest['observations']:.3g}: scale or clip it"
        if self._largest["rewards"] > _LARGE:
            return f"rewards are up to {self._largest['rewards']:.3g}: lower their weights"
        return f"agent.algorithm.learning_rate is {self.alg.learning_rate:.3g}: lower it, or max_grad_norm"

    # -- around the update

    def keep(self) -> None:
        """Copy the values that the update changes."""
        self._kept = [tensor.detach().clone() for tensor in self._tensors]
        self._kept_states = [
            (optimizer, {key: _copied(value) for key, value in optimizer.state.items()})
            for optimizer in self._optimizers()
        ]
        self._kept_rate = self.alg.learning_rate
        self._kept_iteration = getattr(self.alg, "iteration", None)

    def check_update(self, iteration: int, losses: dict[str, float]) -> None:
        """Look at the losses, the networks and the optimiser's state.

        Args:
            iteration: number of the iteration, from 1.
            losses: mean losses of the update.

        Raises:
            NonFiniteError: something is not finite; networks and optimiser are again as before the update.
        """
        states = [value for optimizer in self._optimizers() for value in _tensors(optimizer.state)]
        looks = [extremes_of(tensor) for tensor in (*self._tensors, *states)]
        bad = [f"the {name} loss" for name, value in losses.items() if not math.isfinite(value)]
        if not bad and not all(math.isfinite(number) for row in torch.stack(looks).tolist() for number in row):
            bad = ["a parameter of the networks or of the optimiser"]
        problem = f"iteration {iteration}: {bad[0]} is not finite; {self._cause()}" if bad else None
        problem = distributed.first_problem(problem)
        if problem is not None:
            self._restore()
            raise NonFiniteError(f"{problem}; the update was taken back")

    def _restore(self) -> None:
        with torch.no_grad():
            for tensor, kept in zip(self._tensors, self._kept, strict=True):
                tensor.copy_(kept)
        for optimizer, state in self._kept_states:
            optimizer.state.clear()
            optimizer.state.update(state)
            for group in optimizer.param_groups:
                group["lr"] = self._kept_rate if optimizer is self.alg.optimizer else group["lr"]
        self.alg.learning_rate = self._kept_rate
        if self._kept_iteration is not None:
            self.alg.iteration = self._kept_iteration

    def _optimizers(self) -> Iterator[Any]:
        yield self.alg.optimizer
        if getattr(self.alg, "rnd_optimizer", None) is not None:
            yield self.alg.rnd_optimizer


def _first_bad(values: torch.Tensor) -> list[tuple[int, torch.Tensor]]:
    """The first step with a number that is not finite, and where in it: at most one pair."""
    bad = ~torch.isfinite(values)
    steps = bad.flatten(1).any(1).nonzero().flatten()
    return [(int(steps[0]), bad[int(steps[0])])] if len(steps) else []


def _copied(state: dict[str, Any]) -> dict[str, Any]:
    return {key: value.clone() if isinstance(value, torch.Tensor) else value for key, value in state.items()}


def _tensors(state: Any) -> Iterator[torch.Tensor]:
    for entries in state.values():
        yield from (value for value in entries.values() if isinstance(value, torch.Tensor))

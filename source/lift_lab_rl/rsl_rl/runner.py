"""The training loop: rsl_rl's runner with checkpoints that survive a crash and runs that can be continued.

``model_N.pt`` is the model after N iterations: networks, optimiser, and the few counters that a curriculum needs.
Beside it ``resume_state_N.pt`` holds everything else (environments, random numbers), so that a run continued from
iteration N ends with the same bytes in its last file as a run that never stopped. The newest few are kept.
"""

from __future__ import annotations

import contextlib
import io
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import torch
from rsl_rl.env import VecEnv
from rsl_rl.runners import OnPolicyRunner
from rsl_rl.utils import resolve_callable

from lift_lab.app import output
from lift_lab.utils.errors import ConfigError, FileError
from lift_lab_rl import distributed
from lift_lab_rl.counters import counters, load_counters, manager_env
from lift_lab_rl.files import canonical, save_torch
from lift_lab_rl.nonfinite import NonFiniteError
from lift_lab_rl.settings import Settings
from lift_lab_rl.stop_signals import StopSignals
from lift_lab_rl.threads import use_one_torch_thread

from .best_policy import BEST, BestPolicy
from .checkpoint_file import check_fit, read_checkpoint
from .ema import LAST, acting_policy
from .finite import FiniteGuard
from .gaussian import action_std
from .ppo import LiftLabPPO
from .progress import IterationReport, Progress
from .resume import load_resume_state, resume_state
from .run_files import remove_old_states, state_name, trained_with
from .run_logger import RunLogger
from .runner_checks import check_environment
from .saving import CheckpointSaver
from .time_outs import providing_final_obs


class LiftLabRunner(OnPolicyRunner):
    """Runs PPO on an environment.

    Attributes:
        current_learning_iteration: iterations finished (rsl_rl counts one less).
        total_steps: steps of environments, of all processes and all runs that this one continues; None before the
            first iteration.
        continues_exactly: whether the episodes of a checkpoint go on.
        has_stepped: whether the environment was stepped by this runner.
        noted_unsaved: whether a warning named what cannot be saved.
        stopped_by: number of the signal that ended the last :meth:`learn` early; None if none did.
    """

    logger: RunLogger

    def __init__(
        self,
        env: VecEnv,
        train_cfg: dict[str, Any],
        log_dir: str | Path | None = None,
        device: str = "cpu",
        fingerprint: str | Settings = "",
        place: distributed.Place | None = None,
    ):
        """Build algorithm and logger.

        Args:
            env: wrapped environment.
            train_cfg: what :func:`~lift_lab_rl.rsl_rl.cfg_conversion.to_rsl_rl` returns.
            log_dir: folder of the run; None writes nothing.
            device: device of the learner.
            fingerprint: tells whether a saved environment state is of this configuration: a text that has to be the
                same, or the settings.
            place: this process's place among those of the running :func:`~lift_lab_rl.distributed.group`; None alone.
        """
        self.env = env
        self.cfg = train_cfg
        self.device = device
        self.place = place if place is not None else distributed.Place()
        self.fingerprint = fingerprint
        if self.place.is_distributed:
            size = self.place.world_size
            same = isinstance(fingerprint, str)
            self.fingerprint = f"{fingerprint}/{size}" if same else fingerprint.with_value("processes", size)
        self.log_dir = None if log_dir is None else Path(log_dir)
        if torch.device(device).type == "cpu":
            use_one_torch_thread()
        self._configure_multi_gpu()
        check_environment(env, train_cfg, device, saves=log_dir is not None)
        obs = self.env.get_observations()
        algorithm: Any = resolve_callable(self.cfg["algorithm"]["class_name"])
        with contextlib.redirect_stdout(io.StringIO()):  # rsl_rl prints its networks
            self.alg = algorithm.construct_algorithm(obs, self.env, self.cfg, self.device)
        distributed.copy_from_main(self._shared_tensors())
        self.logger = RunLogger(
            log_dir=None if log_dir is None else str(log_dir),
            cfg=self.cfg,
            env_cfg=getattr(self.env, "cfg", {}),
            num_envs=self.env.num_envs,
            is_distributed=self.is_distributed,
            gpu_world_size=self.gpu_world_size,
            gpu_global_rank=self.gpu_global_rank,
            device=self.device,
        )
        self.current_learning_iteration = 0
        self.total_steps: int | None = None
        self.continues_exactly = self.has_stepped = self.noted_unsaved = False
        self.stopped_by: int | None = None
        self._best = BestPolicy(self.cfg.get("success_metric"))
        self._guard = (
            FiniteGuard(env, self.alg, self._shared_tensors()) if self.cfg.get("check_for_nan", True) else None
        )

    def _configure_multi_gpu(self) -> None:
        """Tell rsl_rl of the other processes."""
        place = self.place
        self.gpu_world_size, self.is_distributed = place.world_size, place.is_distributed
        self.gpu_local_rank, self.gpu_global_rank = place.local_rank, place.rank
        self.cfg["multi_gpu"] = None
        if self.is_distributed:
            self.cfg["multi_gpu"] = {
                "global_rank": place.rank,
                "local_rank": place.local_rank,
                "world_size": place.world_size,
            }

    def _shared_tensors(self) -> list[torch.Tensor]:
        """What is the same on every process: the networks' parameters and normalisation."""
        alg: Any = self.alg
        networks = [*self._networks(), *([alg.rnd.predictor, alg.rnd.target] if alg.rnd else [])]
        return [value for network in networks for value in network.state_dict().values()]

    # -- training

    def learn(
        self,
        num_learning_iterations: int,
        init_at_random_ep_len: bool = False,
        progress: Progress | None = None,
        on_iteration: Callable[[int], None] | None = None,
    ) -> bool:
        """Train, ending early but cleanly on Ctrl-C, SIGTERM, SIGHUP, or when output cannot be written any more.

        Args:
            num_learning_iterations: iterations to do.
            init_at_random_ep_len: whether episodes start at random ages, so that they do not all end at once; has no
                effect on a run that continues with its old episodes.
            progress: where to show progress; None shows nothing.
            on_iteration: called with the number of iterations finished after each of them.

        Returns:
            Whether all iterations were done; if not, :attr:`stopped_by` is the signal that ended them.
        """
        env: Any = self.env
        if init_at_random_ep_len and not self.continues_exactly:
            env.episode_length_buf = torch.randint_like(env.episode_length_buf, high=int(env.max_episode_length))
        obs = env.get_observations().to(self.device)
        self.alg.train_mode()
        try:
            self.logger.init_logging_writer()
        except ModuleNotFoundError as error:
            raise ConfigError(f"agent.logger: {error}") from error
        total = self.current_learning_iteration + num_learning_iterations
        shown = progress if progress is not None else contextlib.nullcontext()
        signals, stops, may_end = StopSignals(self.place), None, False
        saver = CheckpointSaver(self._save_checkpoint, self.cfg["save_interval"], self.place.is_main)
        note = progress.note if progress is not None else None
        final_obs = providing_final_obs(env, isinstance(self.alg, LiftLabPPO) and self.alg.time_outs.needs_final_obs)
        with output.guarded(), signals.caught(note), shown, final_obs:
            while self.current_learning_iteration < total and (stops is None or not may_end):
                obs = self._iterate(obs, total, progress)
                stops = signals.agree()
                done = self.current_learning_iteration
                if on_iteration is not None:
                    on_iteration(done)
                may_end = saver.after_iteration(done, total, stops)
        if self.logger.writer is not None:
            self.logger.stop_logging_writer()
            self.logger.writer.close()  # type: ignore[attr-defined]
        finished = self.current_learning_iteration >= total
        self.stopped_by = None if finished else stops
        return finished

    def _iterate(self, obs: Any, total: int, progress: Progress | None) -> Any:
        """One rollout and one update; returns the observations that the next rollout starts from."""
        start = time.perf_counter()
        same_device = torch.device(self.env.device) == torch.device(self.device)
        self.has_stepped = True
        with torch.inference_mode():
            for _ in range(self.cfg["num_steps_per_env"]):
                actions = self.alg.act(obs)
                obs, rewards, dones, extras = self.env.step(actions.to(self.env.device))
                if not same_device:  # asking a TensorDict costs more than it looks
                    obs, rewards, dones = obs.to(self.device), rewards.to(self.device), dones.to(self.device)
                self.alg.process_env_step(obs, rewards, dones, extras)
                intrinsic = self.alg.intrinsic_rewards if self.alg.rnd else None
                self.logger.process_env_step(rewards, dones, extras, intrinsic)
            self._synchronise()
            collected = time.perf_counter()
        losses = self._update(obs)
        self._synchronise()
        learned = time.perf_counter()
        self.current_learning_iteration += 1
        steps = self.cfg["num_steps_per_env"] * self.env.num_envs * self.gpu_world_size
        total_steps = self.total_steps
        if total_steps is None:  # a run that is continued without its count had as many environments
            total_steps = (self.current_learning_iteration - 1) * steps
        self.total_steps = total_steps = total_steps + steps
        report = IterationReport(
            iteration=self.current_learning_iteration,
            total_iterations=total,
            total_steps=total_steps,
            steps=steps,
            collect_s=collected - start,
            learn_s=learned - collected,
            learning_rate=self.alg.learning_rate,
            action_std=action_std(self.alg.get_policy()),
            entropy_coef=self.alg.entropy_coef,
        )
        self.logger.log_iteration(report, losses, self.alg.rnd.weight if self.alg.rnd else None)
        self._keep_best(report)
        if progress is not None:
            progress.show(report)
        return obs

    def _update(self, obs: Any) -> dict[str, float]:
        """Returns and one update, with a look at every number before and after; returns the mean losses."""
        guard, number = self._guard, self.current_learning_iteration + 1
        with torch.inference_mode():
            if guard is not None:
                guard.look_at_rollout(obs)
            self.alg.compute_returns(obs)
        if guard is None:
            return self.alg.update()
        try:
            guard.check_rollout(number, obs, [log for log, *_ in self.logger.ep_extras])
            guard.keep()
            losses = self.alg.update()
            guard.check_update(number, losses)
        except NonFiniteError:
            self.logger.drop_rollout()
            raise
        return losses

    def _synchronise(self) -> None:
        if torch.device(self.device).type == "cuda":
            torch.cuda.synchronize(self.device)

    def _keep_best(self, report: IterationReport) -> None:
        """Find the report's success; write ``model_best.pt`` if there never was a better policy."""
        report.success = self._best.success(report.terms)
        self._best.smooth(report)
        before = self._best.rank
        if self.log_dir is None or not self.place.is_main or not self._best.is_new(report.iteration):
            return
        try:
            self.save(str(self.log_dir / BEST))
        except FileError as error:
            self._best.rank = before  # the next policy that is better than what is on the disk is written
            print(f"warning: {error}; it is tried again with the next better policy", file=sys.stderr)

    # -- checkpoints

    def _save_checkpoint(self) -> None:
        """Write model and state after the present iteration.

        Raises:
            FileError: one of them cannot be written. What can be is written all the same.
        """
        if self.log_dir is None:
            return
        done, failure = self.current_learning_iteration, None
        # The state first: after a kill in between it is litter, and the checkpoint before is continued exactly.
        try:
            save_torch(self.log_dir / state_name(self.place, done), self.resume_state())
        except FileError as error:
            failure = error
        distributed.check_equal(self._shared_tensors(), "the policy")
        if self.place.is_main:
            path = self.log_dir / f"model_{done}.pt"
            self.save(str(path))
            self.logger.save_model(str(path), done)
        if failure is not None:
            raise failure
        remove_old_states(self.log_dir, self.place, keep=max(1, self.cfg.get("keep_resume_states", 3)))

    def save(self, path: str, infos: dict | None = None) -> None:
        """Write networks, optimiser and counters, atomically.

        Args:
            path: file.
            infos: more to keep; tensors and plain values.
        """
        env = manager_env(self.env)
        content = self.alg.save()
        content["iter"] = self.current_learning_iteration
        content["infos"] = {"env_state": counters(env), **(infos or {})}
        if self.alg.rnd:
            content["infos"]["rnd"] = {"update_counter": self.alg.rnd.update_counter, "weight": self.alg.rnd.weight}
        save_torch(path, canonical(content))

    def resume_state(self) -> dict[str, Any]:
        """Everything besides the model that the next iteration depends on."""
        return resume_state(self)

    def _networks(self) -> list[Any]:
        alg: Any = self.alg
        return [alg._raw_actor, alg._raw_critic]

    def load(
        self, path: str, load_cfg: dict | None = None, strict: bool = True, map_location: str | None = None
    ) -> dict:
        """Load a checkpoint's model, optimiser and counters.

        Args:
            path: ``model_N.pt``.
            load_cfg: parts to load; None for all.
            strict: whether the networks' parameters must match exactly.
            map_location: device to load to; None for the learner's.

        Returns:
            The checkpoint's ``infos``.

        Raises:
            FileError: there is no such file, or it is damaged.
            ConfigError: it is no checkpoint, holds a number that is not finite, or is of other networks or another
                optimizer. Nothing was loaded then.
        """
        content = read_checkpoint(path, map_location or self.device)
        with_iteration = self._load_networks(path, content, load_cfg, strict)
        if self.alg.schedule == "fixed":  # an adapted rate is part of the state, a fixed one is a setting
            self.alg.learning_rate = self.cfg["algorithm"]["learning_rate"]
            for group in self.alg.optimizer.param_groups:
                group["lr"] = self.alg.learning_rate
        if with_iteration:
            self.current_learning_iteration = content["iter"]
        return self._load_infos(content)

    def load_policy(self, path: str) -> dict:
        """Load the policy to act with: the averaged one where the checkpoint holds one, else the last.

        Args:
            path: ``model_N.pt``.

        Returns:
            The checkpoint's ``infos``.

        Raises:
            FileError: there is no such file, or it is damaged.
            ConfigError: it is no checkpoint, holds no policy or a number that is not finite, or is of other networks.
                Nothing was loaded then.
        """
        content = read_checkpoint(path, self.device)
        content[LAST] = acting_policy(content, path)
        parts = {"actor": True, "critic": "critic_state_dict" in content}  # a policy that ships has no critic
        self._load_networks(path, content, parts, strict=True)
        return self._load_infos(content)

    def _load_networks(self, path: str, content: dict[str, Any], parts: dict | None, strict: bool) -> bool:
        try:
            check_fit(self.alg, content, parts, strict)
            return self.alg.load(content, parts, strict)
        except (RuntimeError, KeyError, ValueError, TypeError) as error:
            reason = " ".join(str(error).split())[:200].rstrip(" .")
            made_with = trained_with(path)
            hint = f"; it was trained with {made_with}" if made_with else ""
            raise ConfigError(f"checkpoint '{path}' does not fit this task's networks: {reason}{hint}") from error

    def _load_infos(self, content: dict[str, Any]) -> dict:
        infos = content.get("infos") or {}
        env = manager_env(self.env)
        if env is not None:
            load_counters(env, infos.get("env_state", {}))
        if self.alg.rnd:
            for name, value in infos.get("rnd", {}).items():
                setattr(self.alg.rnd, name, value)
        return infos

    def load_resume_state(self, checkpoint: str | Path) -> str:
        """Continue the very episodes that ran when ``checkpoint`` was written, if their state is beside it.

        Call after :meth:`load`, in a new process or in the one that trained. A setting that is newer than the saved
        run may have its default value; every other difference of the configurations means fresh episodes, as does a
        state that is missing, damaged or of something else.

        Args:
            checkpoint: the file that was loaded.

        Returns:
            What was done, in words for the user.
        """
        return load_resume_state(self, checkpoint)

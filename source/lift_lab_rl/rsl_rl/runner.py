"""The training loop: roll out, update, log, save.

:class:`LiftLabRunner` has the methods of rsl_rl's ``OnPolicyRunner``. Its checkpoints survive a crash, and its runs can
be continued. ``model_N.pt`` is the model after N iterations: networks, optimiser, and the few counters that a
curriculum needs. Beside it ``resume_state_N.pt`` holds everything else (environments, random numbers). So a run that is
continued from iteration N ends with the same bytes in its last file as a run that never stopped.
"""

from __future__ import annotations

import contextlib
import io
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import torch
from rsl_rl.algorithms import PPO
from rsl_rl.env import VecEnv
from rsl_rl.models import MLPModel
from rsl_rl.utils import resolve_callable

from lift_lab.app import output
from lift_lab.utils.errors import ConfigError, FileError
from lift_lab_rl import distributed
from lift_lab_rl.files import canonical, save_torch
from lift_lab_rl.fingerprint import Fingerprint
from lift_lab_rl.stop_signals import StopSignals
from lift_lab_rl.threads import use_one_torch_thread

from .best_policy import BEST, BestPolicy
from .checkpoint_file import read_checkpoint
from .ema import LAST, acting_policy
from .export_metadata import policy_metadata
from .exporter import export_policy_as_jit, export_policy_as_onnx
from .finite_guard import FiniteGuard
from .gaussian import action_std
from .model_file import load_infos, load_networks, model_content, take_symmetry
from .ppo import LiftLabPPO
from .progress import IterationReport, Progress
from .resume import load_resume_state, resume_state
from .run_files import remove_old_states, state_name
from .run_logger import RunLogger
from .runner_checks import check_environment
from .saving import CheckpointSaver
from .time_outs import providing_final_obs
from .training_evaluation import TrainingEvaluation, evaluation_env_cfg
from .vecenv_wrapper import RslRlVecEnvWrapper


class LiftLabRunner:
    """Trains rsl_rl's PPO, or ours, on an environment.

    Attributes:
        env: wrapped environment.
        cfg: configuration, as :func:`~lift_lab_rl.rsl_rl.cfg_conversion.to_rsl_rl` returns it.
        device: device of the learner.
        log_dir: folder of the run; None writes nothing.
        place: this process's place among those of the training.
        fingerprint: settings with which a saved environment state is compared.
        alg: the algorithm.
        logger: curves.
        best: ranks policies for ``model_best.pt``.
        evaluation: evaluates the policy during the training; None without ``agent.evaluation``. With several processes
            only the main one evaluates.
        solved: whether evaluations have found the task to be solved; this ends :meth:`learn`.
        guard: check for NaN and infinity; None if the configuration turns it off.
        current_learning_iteration: iterations finished (rsl_rl counts one less).
        total_steps: steps of environments, of all processes and all runs that this one continues; None before the
            first iteration.
        continues_exactly: whether the episodes of a checkpoint continue.
        has_stepped: whether the environment was stepped by this runner.
        noted_unsaved: whether a warning named what cannot be saved.
        stopped_by: number of the signal that ended the last :meth:`learn` early; None if none did.
    """

    alg: PPO

    def __init__(
        self,
        env: VecEnv,
        train_cfg: dict[str, Any],
        log_dir: str | Path | None = None,
        device: str = "cpu",
        fingerprint: str | Fingerprint = "",
        place: distributed.Place | None = None,
    ):
        """Build algorithm and logger.

        Args:
            env: wrapped environment.
            train_cfg: what :func:`~lift_lab_rl.rsl_rl.cfg_conversion.to_rsl_rl` returns.
            log_dir: folder of the run; None writes nothing.
            device: device of the learner.
            fingerprint: a text that has to be the same for a run to continue with the same episodes, or the settings.
            place: this process's place among those of the running :func:`~lift_lab_rl.distributed.group`; None alone.

        Raises:
            ConfigError: the configuration does not fit the environment.
        """
        self.env, self.cfg, self.device = env, train_cfg, device
        self.log_dir = None if log_dir is None else Path(log_dir)
        self.place = place if place is not None else distributed.Place()
        self.fingerprint = _with_processes(fingerprint, self.place)
        self.cfg["multi_gpu"] = self.place.multi_gpu_cfg()
        if torch.device(device).type == "cpu":
            use_one_torch_thread()
        check_environment(env, train_cfg, device, saves=log_dir is not None)
        algorithm: Any = resolve_callable(self.cfg["algorithm"]["class_name"])
        with contextlib.redirect_stdout(io.StringIO()):  # rsl_rl prints its networks
            self.alg = algorithm.construct_algorithm(env.get_observations(), env, self.cfg, device)
        distributed.copy_from_main(self.shared_tensors())
        self.logger = RunLogger(self.cfg, getattr(env, "cfg", {}), env.num_envs, device, self._written_dir)
        self.best = BestPolicy(self.cfg.get("success_metric"))
        checked = self.cfg.get("check_for_nan", True)
        self.evaluation = None if log_dir is None else self._make_evaluation()  # without a folder: when it trains
        self.solved = False
        self.guard = FiniteGuard(env, self.alg, self.shared_tensors()) if checked else None
        self.current_learning_iteration = 0
        self.total_steps: int | None = None
        self.continues_exactly = self.has_stepped = self.noted_unsaved = False
        self.stopped_by: int | None = None

    def _make_evaluation(self) -> TrainingEvaluation | None:
        cfg = self.cfg.get("evaluation")
        if cfg is None:
            return None
        if not isinstance(self.env, RslRlVecEnvWrapper):
            raise ConfigError(
                "agent.evaluation needs a manager-based environment in an RslRlVecEnvWrapper; set it to null"
            )
        steps = self.cfg["num_steps_per_env"] * self.env.num_envs * self.place.world_size
        env_cfg = evaluation_env_cfg(self.env, cfg)
        return TrainingEvaluation(cfg, self.alg, self.env, env_cfg, self.cfg["max_iterations"] * steps)

    @property
    def _written_dir(self) -> Path | None:
        """Folder that this process writes curves and models to; None for none."""
        return self.log_dir if self.place.is_main else None

    def shared_tensors(self) -> list[torch.Tensor]:
        """Return the state that is the same on every process: the networks' parameters and normalisation."""
        rnd: Any = self.alg.rnd
        networks = [self.alg.actor, self.alg.critic, *([rnd.predictor, rnd.target] if rnd else [])]
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

        With ``agent.evaluation``, training also ends once the task is solved (:attr:`solved`).

        Args:
            num_learning_iterations: iterations to do, at most.
            init_at_random_ep_len: whether episodes start at random ages, so that they do not all end at once; has no
                effect on a run that continues with its old episodes.
            progress: where to show progress; None shows nothing.
            on_iteration: called with the number of iterations finished after each of them.

        Returns:
            Whether all iterations were done or the task is solved; if not, :attr:`stopped_by` is the signal that ended
            them.

        Raises:
            ConfigError: ``agent.evaluation`` asks for evaluations of a task that does not say what success is, or of an
                environment that is not manager-based.
        """
        total = self.current_learning_iteration + num_learning_iterations
        saver = CheckpointSaver(self._save_checkpoint, self.cfg["save_interval"], self.place.is_main)
        signals, signal, ended = StopSignals(self.place), None, False
        if self.evaluation is None:
            self.evaluation = self._make_evaluation()
        self.solved = self.evaluation is not None and distributed.from_main(self.evaluation.solved)
        obs = self._start(init_at_random_ep_len)
        with self._running(signals, progress):
            while self.current_learning_iteration < total and not ended and not self.solved:
                start = self._now()
                obs = self._roll_out(obs)
                rolled_out = self._now()
                losses = self._update(obs)
                report = self._log(total, rolled_out - start, self._now() - rolled_out, losses)
                if progress is not None:
                    progress.show(report)
                signal = signals.agree()
                if on_iteration is not None:
                    on_iteration(report.iteration)
                is_saved = saver.after_iteration(report.iteration, report.iteration if self.solved else total, signal)
                ended = is_saved and signal is not None
        self.logger.close()
        finished = self.solved or self.current_learning_iteration >= total
        self.stopped_by = None if finished else signal
        return finished

    def _start(self, init_at_random_ep_len: bool) -> Any:
        """Open the curves; returns the first observations."""
        env: Any = self.env
        if init_at_random_ep_len and not self.continues_exactly:
            env.episode_length_buf = torch.randint_like(env.episode_length_buf, high=int(env.max_episode_length))
        self.alg.train_mode()
        self.logger.open()
        return env.get_observations().to(self.device)

    @contextlib.contextmanager
    def _running(self, signals: StopSignals, progress: Progress | None):
        """What holds while the loop runs: output and signals are caught, progress is shown."""
        wants_final_obs = isinstance(self.alg, LiftLabPPO) and self.alg.time_outs.needs_final_obs
        with (
            output.guarded(),
            signals.caught(progress.note if progress is not None else None),
            progress if progress is not None else contextlib.nullcontext(),
            providing_final_obs(self.env, wants_final_obs),
        ):
            try:
                yield
            finally:
                if self.evaluation is not None:
                    self.evaluation.close()

    def _roll_out(self, obs: Any) -> Any:
        """Step the environment with the policy; returns the observations that the next rollout starts from."""
        same_device = torch.device(self.env.device) == torch.device(self.device)
        self.has_stepped = True
        self.logger.start_rollout()
        with torch.inference_mode():
            for _ in range(self.cfg["num_steps_per_env"]):
                actions = self.alg.act(obs)
                obs, rewards, dones, extras = self.env.step(actions.to(self.env.device))
                if not same_device:  # asking a TensorDict costs more than it looks
                    obs, rewards, dones = obs.to(self.device), rewards.to(self.device), dones.to(self.device)
                self.alg.process_env_step(obs, rewards, dones, extras)
                self.logger.process_env_step(
                    rewards, dones, extras, self.alg.intrinsic_rewards if self.alg.rnd else None
                )
        return obs

    def _update(self, obs: Any) -> dict[str, float]:
        """Returns and one update; returns the mean losses."""
        if self.guard is not None:
            return self.guard.update(self.current_learning_iteration + 1, obs, self.logger.logs())
        with torch.inference_mode():
            self.alg.compute_returns(obs)
        return self.alg.update()

    def _log(self, total: int, collect_s: float, learn_s: float, losses: dict[str, float]) -> IterationReport:
        """Count the iteration, write its curves, and ``model_best.pt`` if there never was a better policy."""
        steps = self.cfg["num_steps_per_env"] * self.env.num_envs * self.place.world_size
        before = self.total_steps
        if before is None:  # a run that is continued without its count had as many environments
            before = self.current_learning_iteration * steps
        self.current_learning_iteration += 1
        self.total_steps = total_steps = before + steps
        report = IterationReport(
            iteration=self.current_learning_iteration,
            total_iterations=total,
            total_steps=total_steps,
            steps=steps,
            collect_s=collect_s,
            learn_s=learn_s,
            learning_rate=self.alg.learning_rate,
            action_std=action_std(self.alg.get_policy()),
            entropy_coef=self.alg.entropy_coef,
        )
        self.logger.log_iteration(report, losses, self.alg.rnd.weight if self.alg.rnd else None)
        self.best.observe(report)
        self._begin_schedules(report)
        folder = self._written_dir
        save_best = None if folder is None else lambda: self.save(str(folder / BEST))
        self.best.update(report, save_best)
        self._evaluate(report, save_best)
        return report

    def _evaluate(self, report: IterationReport, save_best: Callable[[], None] | None) -> None:
        """Evaluate the policy if it is time: curves, ``model_best.pt``, and whether the task is solved."""
        if self.evaluation is None:
            return
        if self.place.is_main:
            result = self.evaluation.after_iteration(report.iteration, report.total_steps, self.best.smoothed_success)
            if result is not None:
                self.logger.log_scalars(result.scalars, report.iteration)
                report.notes.append(result.note)
                self.best.update_evaluated(result.rank, save_best)
        self.solved = distributed.from_main(self.evaluation.solved)
        if self.solved:
            report.notes.append(f"the task is solved: training ends after {report.iteration} iterations")

    def _begin_schedules(self, report: IterationReport) -> None:
        """Begin the algorithm's schedules where they wait for a success rate, with several processes the main one's."""
        alg = self.alg
        if not isinstance(alg, LiftLabPPO) or alg.anneal_at_success is None or alg.anneal_from is not None:
            return
        if alg.note_success(distributed.from_main(self.best.smoothed_success)):
            report.notes.append(
                f"the success rate has reached {alg.anneal_at_success:g} at iteration {report.iteration}: "
                f"the schedules begin"
            )

    def _now(self) -> float:
        """Time in s, once the device has done its work."""
        if torch.device(self.device).type == "cuda":
            torch.cuda.synchronize(self.device)
        return time.perf_counter()

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
        distributed.check_equal(self.shared_tensors(), "the policy")
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
        if self.evaluation is not None and self.evaluation.solved:
            infos = {"solved": self.evaluation.criteria(), **(infos or {})}
        content = model_content(self.alg, self.env, self.current_learning_iteration, infos)
        save_torch(path, canonical(content))

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
        with_iteration = load_networks(self.alg, path, content, load_cfg, strict)
        if self.alg.schedule == "fixed":  # an adapted rate is part of the state, a fixed one is a setting
            self.alg.learning_rate = self.cfg["algorithm"]["learning_rate"]
            for group in self.alg.optimizer.param_groups:
                group["lr"] = self.alg.learning_rate
        if with_iteration:
            self.current_learning_iteration = content["iter"]
        return load_infos(self.alg, self.env, content)

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
        take_symmetry(self.alg, path, content[LAST])
        parts = {"actor": True, "critic": "critic_state_dict" in content}  # a policy that ships has no critic
        load_networks(self.alg, path, content, parts, strict=True)
        return load_infos(self.alg, self.env, content)

    def resume_state(self) -> dict[str, Any]:
        """Return all data except the model on which the next iteration depends."""
        return resume_state(self)

    def load_resume_state(self, checkpoint: str | Path) -> str:
        """Continue the same episodes that ran when ``checkpoint`` was written, if their state is beside it.

        Call after :meth:`load`, in a new process or in the one that trained. A setting that is newer than the saved run
        may have its default value. Every other difference of the configurations starts new episodes. So does a state
        that is missing, damaged or of something else.

        Args:
            checkpoint: the file that was loaded.

        Returns:
            What was done, in words for the user.
        """
        return load_resume_state(self, checkpoint)

    # -- the policy

    def get_inference_policy(self, device: str | None = None) -> MLPModel:
        """The policy for acting without noise, on a device (None: where it is)."""
        self.alg.eval_mode()
        return self.alg.get_policy().to(device)

    def export_policy_to_jit(self, path: str, filename: str = "policy.pt") -> None:
        """Write the policy as TorchScript; :func:`~lift_lab_rl.rsl_rl.export_policy_as_jit`."""
        export_policy_as_jit(self.alg.get_policy(), None, path, filename, self.policy_metadata())

    def export_policy_to_onnx(self, path: str, filename: str = "policy.onnx", verbose: bool = False) -> None:
        """Write the policy as ONNX; :func:`~lift_lab_rl.rsl_rl.export_policy_as_onnx`."""
        export_policy_as_onnx(self.alg.get_policy(), path, None, filename, verbose, self.policy_metadata())

    def policy_metadata(self, checkpoint: str | Path | None = None) -> dict[str, str] | None:
        """Return the metadata of an exported policy, see docs/deploy.md.

        Args:
            checkpoint: the file that the policy is from; None if it is from none.

        Returns:
            Texts by key; None where the environment is not manager-based.

        Raises:
            FileError: the checkpoint cannot be read.
        """
        env: Any = self.env
        return policy_metadata(env, self.alg.get_policy(), checkpoint) if isinstance(env, RslRlVecEnvWrapper) else None


def _with_processes(fingerprint: str | Fingerprint, place: distributed.Place) -> str | Fingerprint:
    """A fingerprint that also tells how many processes train."""
    if not place.is_distributed:
        return fingerprint
    if isinstance(fingerprint, str):
        return f"{fingerprint}/{place.world_size}"
    return fingerprint.with_value("processes", place.world_size)

"""Train baseline and curriculum over seeds, evaluate each policy, and write a report.

lift-lab study [--seeds 1 2 3] [--max_iterations N] [--processes 1] [flags] [overrides]

Everything goes to logs/rsl_rl/<name>/: runs, evaluations, results.json, and report/report.html. Run the same command
again to continue after an interruption: finished trainings and evaluations are kept, the others continue from their
newest checkpoint. A task may be a variant in quotes: "linear=Lift-Cube-Franka-CL env/curriculum=linear". With from= a
variant starts from another one's checkpoint of the same seed. Curriculum and baseline are the same until iteration 750,
so "Lift-Cube-Franka from=Lift-Cube-Franka-CL@750" saves three quarters of a training.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shlex
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from lift_lab.app import children, cli, endings, program

from .arguments import COMMON_SETTINGS, positive, split_overrides

_STOPPED = [endings.exit_status(number) for number in endings.STOPPING]
"""Exit statuses of a child that was asked to end."""

_DECIDED = {
    **dict.fromkeys(("agent.seed", "env.seed"), "--seeds and --eval_seed"),
    "agent.experiment_name": "--name",
    "agent.run_name": "the tasks' labels",
    **dict.fromkeys(("agent.resume", "agent.load_run", "agent.load_checkpoint"), "the study"),
}
"""Settings that an override cannot set, and what decides them."""


def parse():
    parser = cli.Parser(__doc__, multirun=False)  # a variant is a task in quotes
    parser.add_argument("--tasks", nargs="+", default=None, help="TASK, or 'LABEL=TASK from=LABEL@N override ...'")
    parser.add_argument(
        "--seeds", nargs="+", type=seed, default=[1, 2, 3], help="seeds of the trainings (default: 1 2 3)"
    )
    parser.add_argument("--name", type=folder_name, default="study", help="folder under logs/rsl_rl (default: study)")
    parser.add_argument("--max_iterations", type=positive, default=None, help="iterations of each training")
    parser.add_argument("--num_envs", type=positive, default=None, help="environments of each training")
    parser.add_argument("--processes", type=positive, default=1, help="trainings at the same time (default: 1)")
    parser.add_argument(
        "--num_threads", type=positive, default=None, help="CPU threads of each training (default: an equal share)"
    )
    parser.add_argument("--device", type=str, default=None, help="cpu, cuda:N or auto (default: a GPU if there is one)")
    parser.add_argument("--episodes", type=positive, default=1000, help="episodes of each evaluation (default: 1000)")
    parser.add_argument(
        "--eval_seed",
        type=seed,
        default=1000,
        help="seed of every evaluation, so all have the same starts (default: 1000)",
    )
    parser.add_argument(
        "--checkpoint", choices=["latest", "best"], default="latest", help="checkpoint to evaluate (default: latest)"
    )
    parser.add_argument(
        "--perturb", nargs="*", default=[], help="perturbations to evaluate, e.g. mass=2 delay=0.01; 'standard' for all"
    )
    parser.add_argument("--perturb_episodes", type=positive, default=None, help="episodes under each perturbation")
    parser.add_argument("--no_report", action="store_true", help="write no report")
    overrides, words = split_overrides(sys.argv[1:])
    parser.settings |= {name: COMMON_SETTINGS[name] for name in ("num_envs", "device", "num_threads")}
    parser.settings["max_iterations"] = ("agent.max_iterations",)
    args, rest = parser.parse(words)
    if rest:
        parser.error(f"unexpected argument '{rest[0]}'")
    if args.perturb_episodes is not None and not args.perturb:
        parser.error("--perturb_episodes counts the episodes under each perturbation: add --perturb")
    if args.num_threads is None and args.processes > 1:
        args.num_threads = max(1, (os.cpu_count() or 1) // args.processes)
        for path in parser.settings["num_threads"]:
            args.flag_settings.append(cli.FlagSetting("--num_threads", path, args.num_threads))
    return args, overrides


def seed(text: str) -> int:
    """A whole number that a training can be seeded with."""
    if not text.isdecimal() or int(text) >= 2**32:
        raise argparse.ArgumentTypeError(f"expected a whole number from 0 to {2**32 - 1}, got '{text}'")
    return int(text)


def folder_name(text: str) -> str:
    """The name of a folder."""
    if not re.fullmatch(r"[\w.+-]+", text) or text in (".", ".."):
        raise argparse.ArgumentTypeError(f"'{text}' cannot be a folder's name: expected letters, digits and . _ + -")
    return text


class Study:
    """Runs jobs in child processes and keeps the results file up to date."""

    def __init__(self, args: Any, overrides: list[str], jobs: list[Any], perturb: list[str]):
        self.args, self.overrides, self.jobs, self.perturb = args, overrides, jobs, perturb
        self.folder = (Path("logs") / "rsl_rl" / args.name).absolute()
        self.results = self.folder / "results.json"
        self.stopping = threading.Event()
        self.stopped_by: int | None = None
        self.lock: Any = None
        self._lock = threading.Lock()
        self._children: set[subprocess.Popen] = set()
        self._settings = {
            "variants": {job.variant.label: job.variant.settings for job in jobs},
            "num_envs": args.num_envs,
            "overrides": overrides,
        }
        self._lengths: dict[str, int] = {}  # iterations of the trainings, by label
        self._evaluations: dict[str, Any] = {}  # what may end them earlier; None for nothing
        self._common = ["--num_threads", str(args.num_threads)] if args.num_threads else []
        self._common += ["--device", args.device] if args.device else []

    def check(self) -> None:
        """Find a mistake before the first training.

        Raises:
            LiftLabError: names it.
        """
        from lift_lab.sim.simulation_context import resolve_device
        from lift_lab_rl.perturbations import parse_perturbation, perturb
        from lift_lab_rl.study.jobs import check_start, newest_checkpoint
        from lift_lab_tasks.settings import Settings

        for text in self.perturb:
            parse_perturbation(text)
        if self.args.device is not None:
            resolve_device(self.args.device)
        variants = {job.variant.label: job.variant for job in self.jobs}
        agents: dict[str, Any] = {}
        for label, variant in variants.items():
            for text in (None, *self.perturb):
                words = [*variant.overrides, *self.overrides]
                self._check_overrides(words)
                settings = Settings(variant.task, "rsl_rl_cfg_entry_point", words, self.args.flag_settings)
                if text is not None:
                    perturb(settings.env, text)
                    continue
                settings.resolve(training=True)
                agents[label] = settings.agent
        self._lengths = length = {label: agent.max_iterations for label, agent in agents.items()}
        self._evaluations = {label: agent.evaluation for label, agent in agents.items()}
        for job in self.jobs:  # what an earlier call has trained is found when it is needed
            label, origin = job.variant.label, job.variant.start[0] if job.variant.start else None
            if origin in agents and newest_checkpoint(self.folder, job.origin) is None:
                check_start(job.variant, length[label], agents[origin].save_interval, length[origin])

    def _check_overrides(self, words: list[str]) -> None:
        from lift_lab.utils.errors import ConfigError
        from lift_lab_tasks.utils.hydra import given_paths

        for path, decider in _DECIDED.items():
            text = next((word for word in words if path in given_paths([word])), None)
            if text is not None:
                raise ConfigError(f"override '{text}': {path} of a study is set by {decider}; leave it out")

    def prepare(self) -> None:
        """Take over what an earlier call did, once none of its processes is left.

        Raises:
            ConfigError: another study works in the folder, or one with other settings did.
        """
        self._take_over()  # finds a mistake before anything is written
        self.lock = children.FolderLock(self.folder, "lift-lab study")
        self._take_over()
        self.write()

    def _take_over(self) -> None:
        from lift_lab_rl.study.evaluations import load_results
        from lift_lab_rl.study.jobs import check_settings, in_rounds

        old = load_results(self.results) if self.results.is_file() else {}
        check_settings(old.get("settings", {}), self._settings, self.results)
        self._settings["variants"] = {**old.get("settings", {}).get("variants", {}), **self._settings["variants"]}
        known = {(run["label"], run["seed"]): run for run in old.get("runs", [])}
        for job in self.jobs:
            identity = {"label": job.variant.label, "task": job.variant.task, "seed": job.seed}
            job.record.update(known.pop((job.variant.label, job.seed), {}) | identity)
        self._others = list(known.values())
        self._rounds = in_rounds(self.jobs, [run["label"] for run in self._others if "checkpoint" in run])

    def run(self) -> int:
        """Do all jobs; returns how many are not finished."""
        with ThreadPoolExecutor(self.args.processes) as pool:
            for jobs in self._rounds:
                list(pool.map(self._do, jobs))
        return sum(job.record.get("status") != "done" for job in self.jobs)

    def stop(self, number: int = signal.SIGINT, _: Any = None) -> None:
        """Have the running children save and end, and start no more. Can be a signal's handler.

        A second Ctrl-C or SIGTERM has them end at once.
        """
        if self.stopping.is_set() and number == endings.HANGUP:
            return
        self.stopping.set()
        self.stopped_by = number if self.stopped_by is None else self.stopped_by
        for child in list(self._children):
            child.send_signal(signal.SIGTERM)

    def write(self) -> None:
        """Write the results file."""
        from lift_lab_rl.files import write_atomically

        with self._lock:
            content = {
                "command": f"{program.current().command} {shlex.join(sys.argv[1:])}".strip(),
                "settings": self._settings,
                "runs": [*self._others, *(job.record for job in self.jobs)],
            }
            write_atomically(self.results, (json.dumps(content, indent=2) + "\n").encode())

    # -- one job

    def _do(self, job: Any) -> None:
        steps = [lambda: self._train(job), lambda: self._evaluate(job, [])]
        steps += [lambda name=name: self._evaluate(job, [name]) for name in self.perturb]
        for step in steps:
            if self.stopping.is_set():
                job.record["status"] = "stopped"
                break
            if not step():
                break
        else:
            job.record["status"] = "done"
        self.write()
        print(f"{job.name}: {job.record['status']}", flush=True)

    def _train(self, job: Any) -> bool:
        from lift_lab.utils.errors import FileError
        from lift_lab_rl.study.jobs import best_checkpoint, checkpoint_at, newest_checkpoint

        wanted = self._lengths[job.variant.label]
        found = newest_checkpoint(self.folder, job.name, self._readable)
        if not self._is_done(job, found):
            flags = ["--task", job.variant.task, "--seed", job.seed, "--max_iterations", wanted]
            flags += ["--experiment_name", self.args.name, "--run_name", job.name, *self._common]
            flags += ["--num_envs", self.args.num_envs] if self.args.num_envs else []
            start = found[0] if found else None
            if start is None and job.origin is not None:
                try:
                    start = checkpoint_at(self.folder, job.origin, job.variant.start[1])
                except FileError as error:
                    job.record["status"] = f"cannot start: {error}"
                    return False
            flags += ["--resume", "--checkpoint", start] if start else []
            begun = time.monotonic()
            status = self._call(job, "train", [*flags, *job.variant.overrides, *self.overrides])
            job.record["train_s"] = job.record.get("train_s", 0.0) + time.monotonic() - begun
            found = newest_checkpoint(self.folder, job.name, self._readable)
            if status or not self._is_done(job, found):
                stopped = self.stopping.is_set() or status in _STOPPED
                ended = "stopped" if stopped or not status else f"training failed ({status})"
                job.record["status"] = ended
                return False
        assert found is not None
        path, job.record["iterations"] = found
        best = self.args.checkpoint == "best"
        checkpoint = best_checkpoint(self.folder, job.name, self._readable) if best else path
        if checkpoint is None:
            job.record["status"] = "no model_best.pt"
            return False
        if job.record.get("checkpoint") != str(checkpoint):  # what was measured is of an earlier one
            job.record.pop("evaluation", None)
            job.record.pop("perturbed", None)
        job.record["checkpoint"] = str(checkpoint)
        job.record["status"] = "trained"
        self.write()
        return True

    def _is_done(self, job: Any, found: tuple[Path, int] | None) -> bool:
        """Whether a training has done all iterations, or has ended because the task is solved."""
        from lift_lab_rl.rsl_rl.run_files import is_solved

        if found is None:
            return False
        (checkpoint, done), label = found, job.variant.label
        return done >= self._lengths[label] or is_solved(checkpoint, self._evaluations[label])

    def _readable(self, checkpoint: Path) -> bool:
        from lift_lab_rl.rsl_rl.run_files import Readable

        return Readable(lambda text: print(text, file=sys.stderr)).checkpoint(checkpoint)

    def _evaluate(self, job: Any, perturb: list[str]) -> bool:
        from lift_lab_rl.study.jobs import read_evaluation

        checkpoint, seed = Path(job.record["checkpoint"]), self.args.eval_seed
        episodes = (self.args.perturb_episodes if perturb else None) or self.args.episodes
        path = self.folder / "evaluations" / f"{'__'.join([job.name, *perturb])}.json"
        content = read_evaluation(path, checkpoint, episodes, seed)
        if content is None:
            flags = ["--task", job.variant.task, "--checkpoint", checkpoint, "--episodes", episodes, "--seed", seed]
            flags += ["--json", path, *(f"--perturb={name}" for name in perturb), *self._common]
            status = self._call(job, "evaluate", [*flags, *job.variant.overrides, *self.overrides])
            content = None if status else read_evaluation(path, checkpoint, episodes, seed)
            if content is None:
                stopped = self.stopping.is_set() or status in _STOPPED
                job.record["status"] = "stopped" if stopped else f"evaluation failed ({status})"
                return False
        if perturb:
            job.record.setdefault("perturbed", {})["+".join(perturb)] = content
        else:
            job.record["evaluation"] = content
        self.write()
        return True

    def _call(self, job: Any, script: str, flags: list[Any]) -> int:
        """Run a script in a child process whose output goes to a file; returns its exit status."""
        log = self.folder / "output" / f"{job.name}.txt"
        log.parent.mkdir(parents=True, exist_ok=True)
        command = [sys.executable, "-m", f"lift_lab_cli.{script}", *map(str, flags)]
        print(f"{job.name}: {shlex.join([script, *command[3:]])}", flush=True)
        with open(log, "a", encoding="utf-8") as output:
            # In a group of its own: Ctrl-C reaches it through stop() only, once.
            child = subprocess.Popen(
                command,
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
                env=children.child_environment(),
                pass_fds=[self.lock.handle],  # the folder stays locked as long as a child works in it
            )
            self._children.add(child)
            if self.stopping.is_set():
                child.send_signal(signal.SIGTERM)
            status = child.wait()
            self._children.discard(child)
        if status and not self.stopping.is_set():
            lines = log.read_text(encoding="utf-8", errors="replace").strip().splitlines()
            print(f"{job.name}: {script} failed: {lines[-1] if lines else status} (see {log})", file=sys.stderr)
        return status


def main() -> int:
    args, overrides = parse()

    import lift_lab_tasks  # noqa: F401
    from lift_lab_rl.perturbations import STANDARD
    from lift_lab_rl.study.comparison import Roles
    from lift_lab_rl.study.curves import find_runs, group_runs, remarks
    from lift_lab_rl.study.evaluations import load_results
    from lift_lab_rl.study.figures import require_matplotlib
    from lift_lab_rl.study.jobs import Variant, make_jobs
    from lift_lab_rl.study.missing import missing_scalars
    from lift_lab_rl.study.page import write_report
    from lift_lab_tasks.manager_based.manipulation.lift.paper import PAPER

    if not args.no_report:
        require_matplotlib()
    perturb = [name for text in args.perturb for name in (STANDARD if text == "standard" else (text,))]
    tasks = args.tasks or (PAPER.baseline_task, PAPER.curriculum_task)
    jobs = make_jobs([Variant.parse(text) for text in tasks], args.seeds)
    study = Study(args, overrides, jobs, perturb)
    study.check()
    study.prepare()
    try:
        with endings.handled(study.stop):
            unfinished = study.run()
    finally:
        study.lock.release()
    print(f"written: {study.results}")
    if study.stopped_by is not None:
        print("stopped: run the same command again to continue", file=sys.stderr)
        return endings.exit_status(study.stopped_by)
    if not args.no_report and any("checkpoint" in job.record for job in jobs):
        runs = find_runs([study.folder])
        groups, results = group_runs(runs), load_results(study.results)
        notes = [*remarks(runs), *missing_scalars(groups, results, PAPER)]
        roles, folder = Roles.guess(groups, PAPER), study.folder / "report"
        page = write_report(roles.ordered(groups), results, PAPER, roles, folder, notes=notes)
        for note in notes:
            print(f"note: {note}")
        print(f"written: {page}")
    return 1 if unfinished else 0


if __name__ == "__main__":
    cli.run(main)

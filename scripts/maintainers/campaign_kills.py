"""Kill trainings, exports and studies at random moments, continue them, and compare with what nothing interrupted."""

from __future__ import annotations

import os
import random
import signal
import time
from pathlib import Path

from campaign_runs import (
    ITERATIONS,
    SMALL,
    References,
    Script,
    Tally,
    call,
    checkpoints,
    damaged_files,
    train_args,
)

SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGHUP, signal.SIGINT)
STUDY_ITERATIONS = 6


def kill_trainings(folder: Path, engine: str, kills: int, rng: random.Random, tally: Tally, ref: References) -> None:
    """Kill trainings until so many kills are made; each training is continued until it is done.

    Args:
        folder: where to work.
        engine: physics engine.
        kills: how many.
        rng: chooses signals and moments.
        tally: counts.
        ref: trainings that nothing interrupted.
    """
    wanted, length_s = ref.of(engine)
    kind = f"train, {engine}: killed and continued"
    made, chain = 0, 0
    while made < kills:
        chain += 1
        place = folder / f"{engine}-{chain}"
        while True:
            last = checkpoints(place)
            script = Script("rsl_rl/train.py", train_args(engine, resume=bool(last)), place)
            number = SIGNALS[made % len(SIGNALS)] if made < kills else None
            ended = script.wait(rng.uniform(0.0, length_s)) if number is not None else script.finish()
            if ended is None and number is not None:
                made += 1
                script.send(number)
                if number != signal.SIGKILL and rng.random() < 0.2:
                    time.sleep(rng.uniform(0.0, 0.2))
                    script.send(number)
                ended = script.finish()
                # 0 if it was done by then; without handlers yet it dies of the signal
                problems = ended.problems(-number, 128 + number, 0)
                name = f"{number.name} after {time.monotonic() - script.began:.2f} s in {place.name}"
                tally.note(kind, [*problems, *_not_continued(ended.text, last), *damaged_files(place)], name)
                if ended.status != 0:
                    continue
            else:
                assert ended is not None
                tally.note(f"train, {engine}: went on to the end", ended.problems(0), place.name)
                if ended.status:
                    break
            bits = checkpoints(place)[-1].read_bytes()
            same = None if bits == wanted else f"model_{ITERATIONS}.pt differs from an uninterrupted training's"
            tally.note(f"train, {engine}: same bits as uninterrupted", same, place.name)
            break


def _not_continued(text: str, last: list[Path]) -> list[str]:
    """The line of a resumed training has to say that its episodes go on; it may have been killed before."""
    lines = [line for line in text.splitlines() if line.startswith("resuming ")]
    if not last or not lines or "continuing the episodes of iteration" in lines[0]:
        return []
    return [lines[0]]


def kill_exports(folder: Path, kills: int, rng: random.Random, tally: Tally, ref: References) -> None:
    """Kill play.py while it exports and plays."""
    import mujoco
    import onnx
    import onnxruntime  # noqa: F401 - forks have what play.py needs
    import torch

    readers = {
        ".pt": torch.jit.load,
        ".onnx": onnx.checker.check_model,
        ".xml": mujoco.MjModel.from_xml_path,
    }
    checkpoint = checkpoints(ref.folder("native"))[-1]
    args = ["--task", "Cartpole", "--device", "cpu", "--num_envs", "2", "--steps", "20", "--num_threads", "1"]
    length_s = 1.0
    for number in range(-1, kills):
        place = folder / f"export-{number}"
        run = place / "run"
        run.mkdir(parents=True)
        (run / checkpoint.name).write_bytes(checkpoint.read_bytes())
        began = time.monotonic()
        script = Script("rsl_rl/play.py", [*args, "--checkpoint", run / checkpoint.name], place)
        if number < 0:  # how long it takes
            assert not script.finish().problems(0)
            length_s = time.monotonic() - began
            continue
        ended, sent = script.wait(rng.uniform(0.2, 1.0) * length_s), SIGNALS[number % len(SIGNALS)]
        if ended is None:
            script.send(sent)
        ended = script.finish()
        problems = ended.problems(-sent, 128 + sent, 0)
        for path in (run / "exported").glob("[!.]*"):
            try:
                readers[path.suffix](str(path))
            except Exception as error:  # whatever a reader raises, the file is damaged
                problems.append(f"{path.name}: {error}")
        tally.note("export: killed", problems, f"{sent.name} in {place.name}")


def kill_studies(folder: Path, kills: int, rng: random.Random, tally: Tally) -> None:
    """Kill study.py, start it again at once, and compare with a study that nothing interrupted."""
    if not kills:
        return
    args = [
        "--tasks",
        "Cartpole",
        "--seeds",
        1,
        2,
        "--name",
        "s",
        "--max_iterations",
        STUDY_ITERATIONS,
        "--episodes",
        2,
    ]
    args += ["--no_report", *SMALL[2:]]
    began = time.monotonic()
    ended = call("rsl_rl/study.py", args, folder / "reference")
    length_s = time.monotonic() - began
    tally.note("study: done", ended.problems(0), "reference")
    wanted = _study_result(folder / "reference")
    made, chain = 0, 0
    while made < kills:
        chain += 1
        place = folder / f"study-{chain}"
        while True:
            script = Script("rsl_rl/study.py", args, place)
            number = SIGNALS[0 if rng.random() < 0.5 else made % len(SIGNALS)]
            ended = script.wait(rng.uniform(0.0, length_s)) if made < kills else script.finish()
            if ended is None:
                made += 1
                script.send(number)
                ended = script.finish()
                problems = ended.problems(-number, 128 + number, 0)
                tally.note(
                    "study: killed and started again",
                    [*problems, *damaged_files(place)],
                    f"{number.name}, {place.name}",
                )
                if ended.status != 0:
                    continue
            problems = ended.problems(0)
            if not problems and _study_result(place) != wanted:
                problems = ["another result than an uninterrupted study's"]
            problems += [f"process {pid} is left" for pid in processes_in(place)]
            tally.note("study: same result as uninterrupted, nothing left", problems, place.name)
            break


def _study_result(place: Path) -> list[tuple]:
    """What the trainings of a study ended with, and what their evaluations measured."""
    import json

    file = place / "logs" / "rsl_rl" / "s" / "results.json"
    if not file.is_file():
        return []
    result = []
    for run in json.loads(file.read_text())["runs"]:
        bits = Path(run["checkpoint"]).read_bytes() if "checkpoint" in run else b""
        measured = run.get("evaluation", {})
        result.append((run["label"], run["seed"], run["status"], bits, measured.get("mean_reward")))
    return result


def processes_in(folder: Path) -> list[int]:
    """Processes that work in a folder."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit() and int(entry.name) != os.getpid():
            try:
                place = os.readlink(entry / "cwd")
            except OSError:
                continue
            if place == str(folder) or place.startswith(f"{folder}/"):
                found.append(int(entry.name))
    return found

"""Damage files that a run has left, and files that users bring, and have scripts read them."""

from __future__ import annotations

import io
import pickle
import random
import shutil
from collections.abc import Callable
from pathlib import Path

from campaign_runs import ITERATIONS, SCRIPTS, References, Tally, call, checkpoints, run_folders, train_args

ASSETS = SCRIPTS.parent / "assets" / "usd"

_READ_DATASET = """
import sys
from lift_lab.app import cli
from lift_lab.utils.datasets import HDF5DatasetFileHandler

def main():
    file = HDF5DatasetFileHandler()
    file.open(sys.argv[1])
    for name in file.get_episode_names():
        file.load_episode(name)
    file.close()

cli.run(main)
"""


# -- kinds of damage: content and random numbers -> other content


def cut(content: bytes, rng: random.Random) -> bytes:
    """The end is missing."""
    return content[: rng.randrange(len(content))]


def flip(content: bytes, rng: random.Random) -> bytes:
    """One bit is another."""
    place = rng.randrange(len(content))
    return content[:place] + bytes([content[place] ^ (1 << rng.randrange(8))]) + content[place + 1 :]


def blank(content: bytes, rng: random.Random) -> bytes:
    """A stretch is zeros, as after a power cut."""
    first = rng.randrange(len(content))
    length = min(len(content) - first, rng.choice((16, 512, 4096)))
    changed = content[:first] + bytes(length) + content[first + length :]
    return changed if changed != content else b"\1" + content[1:]


def noise(content: bytes, rng: random.Random) -> bytes:
    """A stretch is random."""
    first = rng.randrange(len(content))
    stretch = rng.randbytes(min(len(content) - first, 64))
    return content[:first] + stretch + content[first + len(stretch) :]


def replace(content: bytes, rng: random.Random) -> bytes:
    """It is a file of another kind."""
    return rng.choice(
        (b"", b"words\n", b"\x89PNG\r\n\x1a\n", b"PK\x03\x04half a zip", b"{}", b"#usda 1.0\n", bytes(999))
    )


DAMAGES = (cut, flip, blank, noise, replace)


def wrong_checkpoint(content: bytes, rng: random.Random) -> bytes:
    """A whole file with wrong contents."""
    import torch

    good = torch.load(io.BytesIO(content), weights_only=True)
    actor = good["actor_state_dict"]
    name = next(key for key, value in actor.items() if value.dim() == 2)
    wrong: list[object] = [
        [1, 2],
        {},
        {**good, "iter": "ten"},
        {**good, "iter": -3},
        {**good, "iter": 1.5},
        {**good, "actor_state_dict": {}},
        {**good, "actor_state_dict": None},
        {**good, "actor_state_dict": {**actor, name: actor[name][:1]}},
        {**good, "actor_state_dict": {**actor, name: actor[name] * float("nan")}},
        {**good, "actor_state_dict": {**actor, name: actor[name].long()}},
        {**good, "optimizer_state_dict": {"state": 1}},
        {**good, "infos": 5},
        torch.zeros(3),
    ]
    buffer = io.BytesIO()
    torch.save(rng.choice(wrong), buffer)
    return rng.choice((buffer.getvalue(), pickle.dumps({"run": print})))


def wrong_settings(_: bytes, rng: random.Random) -> bytes:
    """YAML with wrong contents."""
    texts = (b"- 1\n", b"5\n", b"task: 5\noverrides: 3\n", b"task: [a]\noverrides: {a: 1}\ncontinues: 7\n")
    texts += (
        b"task: null\n",
        b"seed: !!python/object:os.system x\n",
        b"a: &b [*b]\n",
        b"task: Cartpole\ncontinues: ../../x\n",
    )
    return rng.choice(texts)


# -- who reads the file: (how to call, right exit statuses, words that status 0 has to print)


class Damage:
    """A campaign of damaged files."""

    def __init__(self, folder: Path, rng: random.Random, tally: Tally, ref: References):
        """Make the files.

        Args:
            folder: where to work.
            rng: chooses files and damages.
            tally: counts.
            ref: a training whose files are damaged.
        """
        self._folder, self._rng, self._tally = folder, rng, tally
        self._source = ref.folder("native")
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "read_dataset.py").write_text(_READ_DATASET)
        self._dataset = folder / "demos.hdf5"
        _write_dataset(self._dataset)
        self._stages = [path for path in sorted(ASSETS.rglob("*.usd*")) if path.stat().st_size < 200_000]
        self._count = 0

    def run(self, count: int) -> None:
        """Damage so many files, of every kind alike."""
        kinds = [
            self.checkpoint_named,
            self.checkpoint_latest,
            self.state,
            self.settings,
            self.curves,
            self.stage,
            self.dataset,
        ]
        for number in range(count):
            kinds[number % len(kinds)]()

    def _place(self) -> tuple[Path, Path]:
        """A copy of the trained folder, and its run in it."""
        self._count += 1
        place = self._folder / f"case-{self._count}"
        shutil.copytree(self._source, place)
        return place, run_folders(place)[-1]

    def _damage(self, path: Path, *more: Callable[[bytes, random.Random], bytes]) -> str:
        content = path.read_bytes()
        damage = self._rng.choice((*DAMAGES, *more))
        changed = damage(content, self._rng)
        while changed == content:
            changed = damage(content, self._rng)
        path.write_bytes(changed)
        return f"{path.name}, {(damage.__doc__ or '').strip().rstrip('.').lower()}"

    def checkpoint_named(self) -> None:
        """A checkpoint that the user names is refused, whatever the damage."""
        place, _ = self._place()
        path = checkpoints(place)[-1]
        what = self._damage(path, wrong_checkpoint, wrong_checkpoint)
        if self._rng.random() < 0.5:
            args = ["--task", "Cartpole", "--device", "cpu", "--num_envs", 2, "--episodes", 2, "--num_threads", 1]
            ended = call("rsl_rl/evaluate.py", [*args, "--checkpoint", path], place)
        else:
            ended = call("rsl_rl/train.py", [*train_args("native", ITERATIONS + 1, True), "--checkpoint", path], place)
        self._tally.note("checkpoint that is named", ended.problems(2), what)

    def checkpoint_latest(self) -> None:
        """The newest checkpoint is skipped with a line, and the one before is continued."""
        place, _ = self._place()
        what = self._damage(checkpoints(place)[-1], wrong_checkpoint, wrong_checkpoint)
        ended = call("rsl_rl/train.py", train_args("native", ITERATIONS + 1, True), place)
        other = "does not fit this task's networks" in ended.text  # a whole checkpoint, if of other networks
        problems = ended.problems(2 if other else 0)
        if not problems and not other and ended.text.count("warning: skipped") != 1:
            problems = ["no line says that it is skipped"]
        self._tally.note("checkpoint, latest: skipped", problems, what)

    def state(self) -> None:
        """A damaged state ends the continuation of episodes, with a line."""
        place, run = self._place()
        what = self._damage(run / f"resume_state_{ITERATIONS}.pt")
        ended = call("rsl_rl/train.py", train_args("native", ITERATIONS + 1, True), place)
        problems = ended.problems(0)
        if not problems and "starting fresh episodes" not in ended.text:
            problems = ["no line says that episodes start afresh"]
        self._tally.note("state beside a checkpoint", problems, what)

    def settings(self) -> None:
        """Settings of a run: skipped, refused, or still good."""
        place, run = self._place()
        what = self._damage(run / "params" / f"{self._rng.choice(('run', 'run', 'env', 'agent'))}.yaml", wrong_settings)
        if self._rng.random() < 0.5:
            ended = call("rsl_rl/train.py", train_args("native", ITERATIONS + 1, True), place)
        else:
            ended = call("rsl_rl/report.py", [place / "logs", "--out", place / "report"], place)
        self._tally.note("settings of a run (params/*.yaml)", ended.problems(0, 2), what)

    def curves(self) -> None:
        """Event files: read as far as they are good, or refused."""
        place, run = self._place()
        what = self._damage(next(run.glob("events.out.*")))
        ended = call("rsl_rl/report.py", [run, "--out", place / "report"], place)
        problems = ended.problems(0, 2)
        if not problems and ended.status == 0 and " is damaged after " not in ended.text.replace("\n", " "):
            problems = ["no line says that points are missing"]
        self._tally.note("event files", problems, what)

    def stage(self) -> None:
        """USD files: imported or refused."""
        self._count += 1
        place = self._folder / f"case-{self._count}"
        place.mkdir()
        source = self._rng.choice(self._stages)
        shutil.copytree(source.parent, place / "usd")
        path = place / "usd" / source.name
        what = self._damage(path)
        self._tally.note("USD files", call("usd_info.py", [path], place).problems(0, 2), what)

    def dataset(self) -> None:
        """Data sets of episodes: read or refused."""
        self._count += 1
        place = self._folder / f"case-{self._count}"
        place.mkdir()
        path = Path(shutil.copy(self._dataset, place))
        what = self._damage(path)
        ended = call(self._folder / "read_dataset.py", [path], place)
        self._tally.note("data sets (HDF5)", ended.problems(0, 2), what)


def _write_dataset(path: Path) -> None:
    import torch

    from lift_lab.utils.datasets import EpisodeData, HDF5DatasetFileHandler

    file = HDF5DatasetFileHandler()
    file.create(str(path), "Cartpole")
    for _ in range(3):
        episode = EpisodeData()
        for step in range(20):
            episode.add("actions", torch.full((1,), step * 0.1))
            episode.add("obs/policy", torch.rand(4))
        episode.pre_export()
        file.write_episode(episode)
    file.flush()
    file.close()

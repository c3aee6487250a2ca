"""Wrong command lines: those of :mod:`wrong_inputs`, and generated ones."""

from __future__ import annotations

import random
from collections.abc import Iterator
from pathlib import Path

from campaign_runs import Tally, call
from wrong_inputs import WRONG_INPUTS, WrongInput

_TRAIN = "rsl_rl/train.py"
_BASE = ("--task", "Cartpole", "--device", "cpu", "--num_envs", "4", "--max_iterations", "1")


def wrong_inputs(folder: Path, rng: random.Random, count: int, tally: Tally) -> None:
    """Try so many wrong inputs: each has to be refused in one line with status 2, and nothing written.

    Args:
        folder: where to work.
        rng: chooses inputs.
        count: how many.
        tally: counts.
    """
    known = rng.sample(WRONG_INPUTS, min(count, len(WRONG_INPUTS)))
    cases = [("wrong inputs, listed", wrong) for wrong in known]
    cases += [("wrong inputs, generated", wrong) for wrong in _generated(rng, count - len(known))]
    for number, (kind, wrong) in enumerate(cases):
        place = folder / f"case-{number}"
        ended = call(wrong.script, wrong.args, place)
        problems = ended.problems(2)
        if not problems:
            missing = [word for word in wrong.says if word not in ended.errors[0]]
            problems += [f"{missing} not in: {ended.errors[0][:200]}"] if missing else []
        written = sorted(str(path.relative_to(place)) for path in place.rglob("*"))
        problems += [f"written: {', '.join(written[:3])}"] if written else []
        tally.note(kind, problems, str(wrong))


def _generated(rng: random.Random, count: int) -> Iterator[WrongInput]:
    """Misspelt settings, settings of the wrong type, misspelt flags and tasks, made from what there is."""
    if count <= 0:
        return
    numbers = list(_numbers())
    for number in range(count):
        path, value = rng.choice(numbers)
        kind = number % 6
        if kind == 0:
            owner, _, name = path.rpartition(".")
            yield WrongInput(_TRAIN, (*_BASE, f"{owner}.{_misspelt(name, rng)}={value}"), ())
        elif kind == 1:
            yield WrongInput(
                _TRAIN,
                (*_BASE, f"{path}={rng.choice(('abc', '[a,b]', '{a: 1}', 'one', '--'))}"),
                (path.rpartition(".")[2],),
            )
        elif kind == 2:
            flag = rng.choice(("--num_envs", "--seed", "--max_iterations"))
            wrong = rng.choice(("abc", "1.5", "", "1e3", "nan", "-7"))
            yield WrongInput(_TRAIN, (*_BASE, flag, wrong), (flag[2:],))
        elif kind == 3:
            flag = rng.choice(("--num_envs", "--seed", "--run_name", "--experiment_name", "--resume"))
            yield WrongInput(_TRAIN, (*_BASE, f"--{_misspelt(flag[2:], rng)}=1"), ())
        elif kind == 4:
            task = _misspelt(rng.choice(("Cartpole", "Reach-Franka", "Lift-Cube-Franka")), rng)
            script = rng.choice((_TRAIN, "rsl_rl/play.py", "rsl_rl/evaluate.py", "sb3/train.py", "skrl/train.py"))
            yield WrongInput(script, ("--task", task, "--device", "cpu"), (task,))
        else:
            yield WrongInput(_TRAIN, (*_BASE, f"{path}={rng.choice(('[1', '(1', '{1', '1=1'))}"), ())


def _misspelt(name: str, rng: random.Random) -> str:
    """A name with one letter more, less or changed."""
    place = rng.randrange(len(name))
    return rng.choice((name[:place] + "q" + name[place:], name[:place] + "q" + name[place + 1 :], name + "x"))


def _numbers() -> Iterator[tuple[str, float]]:
    """Settings of Cartpole that are a number, and their values."""
    from lift_lab.utils import class_to_dict
    from lift_lab_tasks.utils.hydra import compose

    env_cfg, agent_cfg = compose("Cartpole", "rsl_rl_cfg_entry_point", [])

    def below(path: str, value: object) -> Iterator[tuple[str, float]]:
        if isinstance(value, dict):
            for name, entry in value.items():
                if isinstance(name, str) and name.isidentifier():
                    yield from below(f"{path}.{name}", entry)
        elif type(value) in (int, float):
            yield path, value  # type: ignore[misc]

    yield from below("env", class_to_dict(env_cfg))
    yield from below("agent", class_to_dict(agent_cfg))

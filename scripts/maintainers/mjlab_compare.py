"""Compare the speed of our lift task with that of mjlab's, in one run on one machine, and print the ratio.

python scripts/maintainers/mjlab_compare.py [--device cpu] [--sizes 64,256] [--steps 50] [--json FILE]

mjlab's released package is installed into a virtual environment of its own (.compare/, made on first use, a few
minutes and about 2 GB). Both run their own lift task with random actions: the same kind of scene (a fixed arm, a cube),
5 ms physics steps, 4 of them an environment step. The two take turns, so that a busy machine slows both.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
from importlib import metadata
from pathlib import Path

from rich.console import Console
from rich.table import Table

from lift_lab.app import cli
from lift_lab.utils.errors import LiftLabError
from lift_lab_rl.files import write_atomically

HERE = Path(__file__).parent
MJLAB = "1.6.0"
OUR_TASK, THEIR_TASK = "Lift-Cube-Franka", "Mjlab-Lift-Cube-Yam"


def parse():
    parser = cli.Parser(__doc__, overrides=False)
    parser.add_argument("--device", type=str, default="cpu", help="cpu or cuda:N")
    parser.add_argument("--sizes", type=str, default="64,256", help="numbers of environments, separated by commas")
    parser.add_argument("--steps", type=int, default=50, help="environment steps in a measurement")
    parser.add_argument("--turns", type=int, default=3, help="measurements of each; the median counts")
    parser.add_argument("--folder", type=Path, default=Path(".compare"), help="where mjlab is installed")
    parser.add_argument("--pip", type=str, nargs="*", default=[], help="more for mjlab's pip install")
    parser.add_argument("--json", type=Path, default=None, help="file for the results")
    args, _ = parser.parse()
    try:
        args.sizes = [int(part) for part in args.sizes.split(",")]
    except ValueError:
        parser.error(f"argument --sizes: expected whole numbers separated by commas, got '{args.sizes}'")
    if min(*args.sizes, args.steps, args.turns) < 1:
        parser.error("arguments --sizes, --steps, --turns: expected whole numbers of at least 1")
    return args


def main() -> int:
    args = parse()
    python = peer_python(args.folder, args.pip)
    rows = []
    for size in args.sizes:
        ours, theirs = [], []
        for turn in range(args.turns):
            ours.append(measure_ours(size, args.steps, args.device))
            theirs.append(measure_theirs(python, size, args.steps, args.device))
            speeds = (ours[-1]["env_steps_per_s"], theirs[-1]["env_steps_per_s"])
            print(
                f"{size} environments, turn {turn + 1}: ours {speeds[0]:,.0f}/s, mjlab {speeds[1]:,.0f}/s", flush=True
            )
        rows.append({"num_envs": size, "ours": ours, "mjlab": theirs, "summary": summary(ours, theirs)})
        if args.json is not None:
            content = {"device": args.device, "steps": args.steps, "sizes": rows}
            write_atomically(args.json, (json.dumps(content, indent=2) + "\n").encode())
    show(rows, args.device)
    return 0


def peer_python(folder: Path, more: list[str]) -> Path:
    """The interpreter of mjlab's virtual environment, which is made if need be."""
    place = folder.absolute() / f"mjlab-{MJLAB}"
    python = place / "bin" / "python"
    done = place / "installed"
    if done.is_file():
        return python
    print(f"installing mjlab {MJLAB} into {place}", flush=True)
    # the same torch for both
    torch = f"torch=={metadata.version('torch').partition('+')[0]}"
    run([sys.executable, "-m", "venv", str(place)])
    run([str(python), "-m", "pip", "install", "--quiet", f"mjlab=={MJLAB}", torch, *more])
    done.touch()
    return python


def measure_ours(size: int, steps: int, device: str) -> dict:
    """One run of scripts/benchmark.py."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "result.json"
        script = HERE.parent / "benchmark.py"
        flags = [f"--task={OUR_TASK}", f"--num_envs={size}", f"--steps={steps}", f"--device={device}"]
        run([sys.executable, str(script), *flags, f"--json={file}"])
        return json.loads(file.read_text())


def measure_theirs(python: Path, size: int, steps: int, device: str) -> dict:
    """One run of mjlab's task."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "result.json"
        flags = [f"--task={THEIR_TASK}", f"--num_envs={size}", f"--steps={steps}", f"--device={device}"]
        run([str(python), str(HERE / "mjlab_speed.py"), *flags, f"--json={file}"])
        return json.loads(file.read_text())


def run(command: list[str]) -> None:
    """Run a command; raises LiftLabError with its last line when it fails."""
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        last = ((done.stderr or done.stdout).strip().splitlines() or ["no output"])[-1]
        name = next((Path(part).name for part in command if part.endswith(".py")), " ".join(command[1:4]))
        raise LiftLabError(f"{name} ended with status {done.returncode}: {last}")


def summary(ours: list[dict], theirs: list[dict]) -> dict[str, float]:
    """Medians of the turns, and our multiple of mjlab's."""
    found = {}
    for name in ("env_steps_per_s", "physics_steps_per_s"):
        pair = [statistics.median(result[name] for result in results) for results in (ours, theirs)]
        found |= {f"ours_{name}": pair[0], f"mjlab_{name}": pair[1], f"ratio_{name}": pair[0] / pair[1]}
    return found


def show(rows: list[dict], device: str) -> None:
    """Print the medians as a table."""
    title = f"{OUR_TASK} and mjlab {MJLAB}'s {THEIR_TASK} on {device}"
    names = ("environments", "measure", "ours", "mjlab", "ratio")
    table = Table(*names, title=title, title_justify="left")
    for row in rows:
        for name, text in (("env_steps_per_s", "environment steps/s"), ("physics_steps_per_s", "physics steps/s")):
            values = [row["summary"][f"{kind}_{name}"] for kind in ("ours", "mjlab")]
            ratio = row["summary"][f"ratio_{name}"]
            table.add_row(f"{row['num_envs']:,}", text, *(f"{value:,.0f}" for value in values), f"{ratio:.2f}")
    Console().print(table)


if __name__ == "__main__":
    cli.run(main)

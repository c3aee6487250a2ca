"""Follow a newcomer's first day, outside the checkout, with the wheel in a fresh environment.

    python scripts/maintainers/newcomer_day.py [--keep DIR]

It builds the wheel and installs it with the extra ``all`` in a new virtual environment. In an empty folder it then runs
the demo, trains, evaluates and films the main task, trains and films the task of the tutorial, runs the notebook, and
drives plain MuJoCo with the exported policy. It prints the seconds of each step and ends with 1 at the first failure.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TASK = "Lift-Cube-Franka-CL"
BRIGHT = 60
"""The least mean of a film's pixels, of 255."""


class Day:
    """Runs programs of a fresh environment in an empty folder."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.bin = folder / "env" / "bin"
        self.home = folder / "empty"
        self.home.mkdir()
        kept = {"PATH", "HOME", "LANG", "TMPDIR", "WARP_CACHE_PATH", "SSL_CERT_FILE", "REQUESTS_CA_BUNDLE"}
        self.env = {k: v for k, v in os.environ.items() if k in kept or k.startswith(("PIP_", "OPENBLAS"))}
        self.env["PATH"] = f"{self.bin}:{self.env.get('PATH', '')}"

    def run(self, title: str, *words: str | Path) -> str:
        """Run a program; returns what it printed on its standard output."""
        begun = time.perf_counter()
        command = [str(self.bin / words[0]) if (self.bin / words[0]).exists() else str(words[0]), *map(str, words[1:])]
        done = subprocess.run(command, cwd=self.home, env=self.env, capture_output=True, text=True)
        print(f"{time.perf_counter() - begun:6.1f} s  {title}", flush=True)
        if done.returncode != 0:
            print(f"failed: {' '.join(command)}\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}", file=sys.stderr)
            raise SystemExit(1)
        return done.stdout


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--keep", type=Path, default=None, metavar="DIR", help="work in this new folder and keep it")
    args = parser.parse_args()
    if args.keep is not None:
        args.keep.mkdir(parents=True)
        return follow(Day(args.keep.resolve()))
    with tempfile.TemporaryDirectory() as folder:
        return follow(Day(Path(folder)))


def follow(day: Day) -> int:
    """Do everything, in the order of the pages."""
    install(day)
    version = day.run("lift-lab --version", "lift-lab", "--version").split()[-1]
    expect(version in (ROOT / "pyproject.toml").read_text(), f"pyproject.toml does not name version {version}")
    expect(TASK in day.run("lift-lab list", "lift-lab", "list"), "the main task is not listed")
    day.run("lift-lab demo --video", "lift-lab", "demo", "--video", "demo.mp4", "--num_envs", "1", "--steps", "50")
    is_bright(day, "demo.mp4")
    main_task(day)
    own_task(day)
    notebook(day)
    deploy(day)
    print("the newcomer's day passed")
    return 0


def install(day: Day) -> None:
    """Build the wheel, and install it with what the notebook and the deployed policy need."""
    begun = time.perf_counter()
    venv.create(day.folder / "env", with_pip=True)
    python = day.bin / "python"
    wheels = day.folder / "wheels"
    pip = [python, "-m", "pip", "--quiet", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "wheel", "--no-deps", "--wheel-dir", wheels, ROOT], check=True)
    (wheel,) = wheels.glob("lift_lab-*.whl")
    subprocess.run(
        [*pip, "install", f"lift-lab[all] @ {wheel.as_uri()}", "nbconvert", "ipykernel", "onnxruntime"], check=True
    )
    megabytes = wheel.stat().st_size / 1e6
    print(f"{time.perf_counter() - begun:6.1f} s  wheel of {megabytes:.1f} MB built and installed", flush=True)
    where = day.run("import from the wheel", "python", "-c", "import lift_lab; print(lift_lab.__file__)").strip()
    expect(where.startswith(str(day.folder)), f"lift_lab comes from {where}")


def main_task(day: Day) -> None:
    """Train five iterations, continue, measure the shipped policy, and film."""
    small = ("--task", TASK, "--num_envs", "64")
    day.run("train 5 iterations", "lift-lab", "train", *small, "--max_iterations", "5")
    day.run("continue to 6", "lift-lab", "train", *small, "--max_iterations", "6", "--resume")
    words = ("--checkpoint", "pretrained", "--episodes", "32", "--num_envs", "32", "--json", "success.json")
    day.run("evaluate the shipped policy", "lift-lab", "evaluate", "--task", TASK, *words)
    success = json.loads((day.home / "success.json").read_text())["success_rate"]["32"]
    expect(success > 0.95, f"success of the shipped policy: {success}")
    words = ("--checkpoint", "pretrained", "--steps", "50", "--num_envs", "1", "--video", "lift.mp4")
    day.run("film the shipped policy", "lift-lab", "play", "--task", TASK, *words)
    is_bright(day, "lift.mp4")


def is_bright(day: Day, film: str) -> None:
    """Check the mean of a film's last picture."""
    code = "import av, sys; print(list(av.open(sys.argv[1]).decode(video=0))[-1].to_ndarray(format='rgb24').mean())"
    mean = float(day.run(f"decode {film}", "python", "-c", code, film))
    expect(mean > BRIGHT, f"{film} is too dark: {mean:.0f} of 255")


def expect(condition: bool, text: str) -> None:
    """End with a line unless the condition holds."""
    if not condition:
        print(f"failed: {text}", file=sys.stderr)
        raise SystemExit(1)


def own_task(day: Day) -> None:
    """Write the task of the tutorial, train it for five iterations and film it."""
    page = (ROOT / "docs/tutorials/own_task.md").read_text()
    blocks = re.findall(r'^```python title="(knock/[\w/.]+)"\n(.*?)^```$', page, flags=re.DOTALL | re.MULTILINE)
    for name, text in blocks:
        path = day.home / name
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("a") as file:
            file.write(text + "\n\n")
    task = ("--task", "knock:Knock-Pin", "--num_envs", "64")
    day.run("train the task of the tutorial", "lift-lab", "train", *task, "--max_iterations", "5")
    words = ("--num_envs", "1", "--steps", "25", "--video", "knock.mp4")
    day.run("film it", "lift-lab", "play", *task[:2], *words)
    is_bright(day, "knock.mp4")


def notebook(day: Day) -> None:
    """Run the cells of the notebook."""
    words = ("--to", "notebook", "--execute", "--output-dir", day.home, "--output", "done.ipynb")
    day.run("run the notebook", "jupyter-nbconvert", *words, ROOT / "docs/notebooks/quick_start.ipynb")
    cells = json.loads((day.home / "done.ipynb").read_text())["cells"]
    shown = [data for cell in cells for output in cell.get("outputs", []) for data in output.get("data", {}).values()]
    expect(any("<video" in "".join(data) for data in shown), "the notebook shows no film")


def deploy(day: Day) -> None:
    """Drive plain MuJoCo with the policy that the film's step exported."""
    where = "import lift_lab_assets as a, pathlib; print(pathlib.Path(a.__file__).parent / 'examples/deploy_mujoco.py')"
    script = day.run("find the example in the wheel", "python", "-c", where).strip()
    (exported,) = day.home.glob(f"logs/rsl_rl/*/pretrained/{TASK}/exported")
    printed = day.run("plain MuJoCo with the exported policy", "python", script, exported)
    expect("success: 20 of 20" in printed or "success: 19 of 20" in printed, printed)


if __name__ == "__main__":
    raise SystemExit(main())

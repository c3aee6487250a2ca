"""Every command that README, quick start and tutorials show is run, smaller than it is written."""

import re
import runpy
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import torch

from lift_lab_tasks.utils.hydra import compose

ROOT = Path(__file__).resolve().parents[2]
PAGES = [
    "README.md",
    "docs/index.md",
    *(f"docs/tutorials/{p.name}" for p in (ROOT / "docs" / "tutorials").glob("*.md")),
]

HERE = ["--device", "cpu", "--num_threads", "1"]
SMALLER = {
    "train.py": [*HERE, "--num_envs", "4", "--max_iterations", "1", "agent.num_steps_per_env=2"],
    "evaluate.py": [*HERE, "--num_envs", "2", "--episodes", "2", "env.episode_length_s=0.1"],
    "benchmark.py": [*HERE, "--num_envs", "4", "--steps", "2"],
    "play.py --viewer": [*HERE, "--num_envs", "2", "--steps", "2", "--port", "0"],
    "play.py --replay": [*HERE, "--num_envs", "1", "--steps", "2"],
    "play.py --video": [*HERE, "--num_envs", "1", "--steps", "2", "env.viewer.resolution=[64,48]"],
    "play.py": [*HERE, "--num_envs", "1", "--steps", "2"],
    "list_envs.py": [],
}
"""Script, with the flag that changes what it does -> what is added to make it small. A later flag wins."""
ELSEWHERE = {
    'pip install -e ".[dev]"': "how the tests' own environment is made",
    "python -m pytest": "this",
}
"""Commands that are not run here, and why."""


def commands(page: str) -> list[str]:
    """Commands of a page: indented blocks of README, blocks marked as bash elsewhere."""
    text = (ROOT / page).read_text().replace("\\\n", " ")
    if page == "README.md":
        lines = [line for line in text.splitlines() if line.startswith("    ")]
    else:
        lines = "".join(re.findall(r"^```bash\n(.*?)^```$", text, flags=re.DOTALL | re.MULTILINE)).splitlines()
    return [" ".join(re.sub(r"\s#\s.*$", "", line).split()) for line in lines if line.strip()]


ALL = list(dict.fromkeys((page, command) for page in PAGES for command in commands(page)))
FIRST = {}
"""Each command once, at the first page that shows it."""
for _page, _command in ALL:
    FIRST.setdefault(_command, _page)


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with the file that the first tutorial asks to write."""
    folder = tmp_path_factory.mktemp("checkout")
    first = (ROOT / "docs" / "tutorials" / "first_task.md").read_text()
    blocks = re.findall(r"^```python\n(.*?)^```$", first, flags=re.DOTALL | re.MULTILINE)
    (folder / "balance.py").write_text("\n\n".join(blocks))
    return folder


@pytest.fixture
def run_script(place, monkeypatch, capsys):
    """Runs a script of the checkout in this process; returns its exit status and what it printed."""
    threads = torch.get_num_threads()
    monkeypatch.chdir(place)
    monkeypatch.syspath_prepend(str(place))

    def call(script: str, *args: str):
        monkeypatch.syspath_prepend(str((ROOT / script).parent))
        monkeypatch.setattr(sys, "argv", [script, *args])
        try:
            runpy.run_path(str(ROOT / script), run_name="__main__")
            status = 0
        except SystemExit as ended:
            status = ended.code
        captured = capsys.readouterr()
        return status, captured.out + captured.err

    yield call
    torch.set_num_threads(threads)


def trained(run_script, task: str, place: Path) -> None:
    """Make sure that there is a run of a task to play."""
    if task.startswith("Lift-Cube-Franka-CL") and not list(place.glob("logs/rsl_rl/*/*/model_1.pt")):
        status, printed = run_script("scripts/rsl_rl/train.py", "--task", "Lift-Cube-Franka-CL", *SMALLER["train.py"])
        assert status == 0, printed


@pytest.mark.parametrize("command", [text for text in FIRST if text not in ELSEWHERE])
def test_a_command_does_what_it_says(command, place, run_script):
    words = [word for word in shlex.split(command) if not re.match(r"[A-Z]+=", word)]
    if words[0] == "tensorboard":
        trained(run_script, "Lift-Cube-Franka-CL", place)
        command = [sys.executable, "-m", "tensorboard.main", "--inspect", *words[1:]]
        done = subprocess.run(command, cwd=place, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr[-2000:]
        assert "Event statistics for" in done.stdout
        return
    assert words[0] == "python", f"a new kind of command: {command}"
    if words[1] == "balance.py":
        done = subprocess.run([sys.executable, *words[1:]], cwd=place, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr[-2000:]
        return
    script, *args = words[1:]
    kinds = [kind for kind in SMALLER if kind.split()[0] == Path(script).name and set(kind.split()[1:]) <= set(args)]
    assert kinds, f"say in SMALLER how to run {script} in little time"
    if Path(script).name in ("evaluate.py", "play.py") and "--agent" not in args:
        trained(run_script, args[args.index("--task") + 1], place)
    status, printed = run_script(script, *args, *SMALLER[kinds[0]])
    if "--video" in args and "no OpenGL library was found" in printed:
        pytest.skip("no OpenGL library")
    assert status == 0, printed[-2000:]


def test_python_on_the_page_of_backends_runs(place):
    page = (ROOT / "docs" / "backends.md").read_text()
    (block,) = re.findall(r"^```python\n(.*?)^```$", page, flags=re.DOTALL | re.MULTILINE)
    done = subprocess.run([sys.executable, "-c", block], cwd=place, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.startswith("native torch.Size([4, ")


def test_overrides_on_the_page_of_backends_are_understood():
    for command in commands("docs/backends.md"):
        words = shlex.split(command)
        assert (ROOT / words[1]).is_file()
        cfg, _ = compose(
            words[words.index("--task") + 1], "rsl_rl_cfg_entry_point", [word for word in words if "=" in word]
        )
        assert cfg.sim.physics == ("warp" if "env.sim.physics=warp" in words else None)


def test_every_page_shows_commands_and_each_is_run_or_accounted_for():
    assert {page for page, _ in ALL} == set(PAGES)
    assert set(ELSEWHERE) <= set(FIRST) | {"python -m pytest"}
    assert len(FIRST) > 12

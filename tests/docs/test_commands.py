"""Every command that README, quick start and tutorials show is run, smaller than it is written."""

import re
import runpy
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import torch
from page_files import forget_own_task, write_files

from lift_lab_cli.main import COMMANDS, console
from lift_lab_tasks.utils.hydra import compose

ROOT = Path(__file__).resolve().parents[2]
PAGES = [
    "README.md",
    "docs/index.md",
    *(f"docs/tutorials/{p.name}" for p in (ROOT / "docs" / "tutorials").glob("*.md")),
    "docs/films.md",
    "docs/viewing.md",
]
"""Pages whose commands are run."""

HERE = ["--device", "cpu", "--num_threads", "1"]
SMALLER = {
    "train.py": [*HERE, "--num_envs", "4", "--max_iterations", "1", "agent.num_steps_per_env=2"],
    "evaluate.py": [*HERE, "--num_envs", "2", "--episodes", "2", "env.episode_length_s=0.1"],
    "benchmark.py": [*HERE, "--num_envs", "4", "--steps", "2"],
    "play.py --viewer": [*HERE, "--num_envs", "2", "--steps", "2", "--port", "0"],
    "play.py --replay": [*HERE, "--num_envs", "1", "--steps", "2"],
    "play.py --video --video_envs": [*HERE, "--num_envs", "9", "--steps", "2", "env.viewer.resolution=[64,48]"],
    "play.py --video": [*HERE, "--num_envs", "1", "--steps", "2", "env.viewer.resolution=[64,48]"],
    "play.py": [*HERE, "--num_envs", "1", "--steps", "2"],
    "list_envs.py": [],
    "describe": [],
    "viewer_rate.py": ["--num_envs", "1", "--updates", "2"],
    "video_cost.py": ["--num_envs", "2", "--steps", "2", "--length", "1", "--interval", "2"],
}
"""Script, with the flags that change what it does -> what is added to make it small. A later flag wins."""
ELSEWHERE = {
    'pip install -e ".[test]"': "how the tests' own environment is made",
    'pip install -e ".[all]"': "scripts/maintainers/newcomer_day.py",
    "lift-lab demo": "tests/wheel and scripts/maintainers/newcomer_day.py",
    "python -m pytest": "this",
    "pip install -e '.[viewer]'": "part of the tests' own environment",
    "pip install 'lift-lab[video]'": "part of the tests' own environment",
    "lift-lab train --task Lift-Cube-Franka --video": "tests/scripts/test_video_while_training.py",
    "lift-lab usd assets/usd/franka_panda.usda --view panda.png": "tests/lift_lab/usd/test_usd_tools.py",
    "python -m pytest tests/browser": "a part of this",
}
"""Commands that are not run here, and why."""

PROGRAMS = {
    **{name: f"scripts/rsl_rl/{name}.py" for name in ("train", "play", "evaluate", "study", "report")},
    "list": "scripts/list_envs.py",
    "benchmark": "scripts/benchmark.py",
    "usd": "scripts/usd_info.py",
}
"""Commands of ``lift-lab`` that are also scripts."""


def commands(page: str) -> list[str]:
    """Commands of a page: indented blocks, or blocks marked as bash where a page has those."""
    text = (ROOT / page).read_text().replace("\\\n", " ")
    if "```bash" not in text:
        starts = ("    python ", "    pip ", "    tensorboard ", "    lift-lab ")
        lines = [line for line in text.splitlines() if line.startswith(starts)]
    else:
        lines = "".join(re.findall(r"^```bash\n(.*?)^```$", text, flags=re.DOTALL | re.MULTILINE)).splitlines()
    parts = [part for line in lines for part in re.sub(r"\s#\s.*$", "", line).split(" && ")]
    return [" ".join(part.split()) for part in parts if part.strip()]


ALL = list(dict.fromkeys((page, command) for page in PAGES for command in commands(page)))
FIRST = {}
"""Each command once, at the first page that shows it."""
for _page, _command in ALL:
    FIRST.setdefault(_command, _page)


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with the files that the tutorials ask to write."""
    folder = tmp_path_factory.mktemp("checkout")
    write_files(ROOT / "docs" / "tutorials" / "own_task.md", folder)
    first = (ROOT / "docs" / "tutorials" / "first_task.md").read_text()
    blocks = re.findall(r"^```python\n(.*?)^```$", first, flags=re.DOTALL | re.MULTILINE)
    (folder / "balance.py").write_text("\n\n".join(blocks))
    return folder


@pytest.fixture
def run_script(place, monkeypatch, capsys):
    """Runs a script of the checkout, or a command of ``lift-lab``, in this process: exit status and what it printed."""
    threads = torch.get_num_threads()
    monkeypatch.chdir(place)
    monkeypatch.syspath_prepend(str(place))

    def call(script: str, *args: str):
        is_script = script.endswith(".py")
        monkeypatch.setattr(sys, "argv", [script, *args] if is_script else ["lift-lab", script, *args])
        try:
            if is_script:
                monkeypatch.syspath_prepend(str((ROOT / script).parent))
                runpy.run_path(str(ROOT / script), run_name="__main__")
            else:
                console()
            status = 0
        except SystemExit as ended:
            status = ended.code
        captured = capsys.readouterr()
        return status, captured.out + captured.err

    yield call
    torch.set_num_threads(threads)
    forget_own_task()


def trained(run_script, task: str, place: Path) -> None:
    """Make sure that there is a run of a task to play."""
    if task.startswith("Lift-Cube-Franka"):
        task, experiment = "Lift-Cube-Franka-CL", "franka_lift"
    elif task == "knock:Knock-Pin":
        experiment = "knock_pin"
    else:
        return
    if not list(place.glob(f"logs/rsl_rl/{experiment}/*/model_1.pt")):
        status, printed = run_script("train", "--task", task, *SMALLER["train.py"])
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
    assert words[0] in ("python", "lift-lab"), f"a new kind of command: {command}"
    if words[1] == "balance.py":
        done = subprocess.run([sys.executable, *words[1:]], cwd=place, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr[-2000:]
        return
    script, *args = words[1:]
    name = Path(PROGRAMS.get(script, script)).name
    kinds = [kind for kind in SMALLER if kind.split()[0] == name and set(kind.split()[1:]) <= set(args)]
    assert kinds, f"say in SMALLER how to run {script} in little time"
    if name in ("evaluate.py", "play.py") and "--agent" not in args:
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
        assert (ROOT / PROGRAMS.get(words[1], words[1])).is_file()
        cfg, _ = compose(
            words[words.index("--task") + 1], "rsl_rl_cfg_entry_point", [word for word in words if "=" in word]
        )
        assert cfg.sim.physics == ("warp" if "env.sim.physics=warp" in words else None)


OTHERS = sorted(
    str(path.relative_to(ROOT)) for path in (ROOT / "docs").rglob("*.md") if str(path.relative_to(ROOT)) not in PAGES
)
"""Pages whose commands take too long to be run: that scripts, flags, tasks and overrides exist is looked at."""


def mentions(page: str) -> list[tuple[str, str]]:
    """Scripts and commands that a page tells to run, in a block or in a line of text, each with its arguments."""
    text = (ROOT / page).read_text().replace("\\\n", " ")
    found = re.finditer(
        r"(?:(scripts/[\w/]+\.py)|(?:^    |[`'|(] ?)lift-lab ([a-z]\w+))((?: +[^\s`#|)]+)*)", text, re.M
    )
    return [(m[1] or m[2], m[3]) for m in found]


@pytest.mark.parametrize("script", sorted({script for page in OTHERS for script, _ in mentions(page)}))
def test_flags_tasks_and_overrides_of_the_other_pages_are_those_of_the_script(script, run_script):
    used = [args for page in OTHERS for name, args in mentions(page) if name == script]
    assert script in COMMANDS or (ROOT / script).is_file()
    flags = {flag for args in used for flag in re.findall(r"(?<!\S)\[?(--[a-z]\w+)", args)}
    if flags:
        status, printed = run_script(script, "--help")
        assert status == 0
        assert flags - set(re.findall(r"--\w+", printed)) == set()
    for args in used:
        task = re.search(r"--task ([A-Z]\w*[a-z][\w-]*)", args)
        overrides = re.findall(r"(?<!\S)'?((?:env|agent)[.\w]*[./]\w+=[^\s,']+)'?(?!\S)", args)
        if task:
            compose(task[1], "rsl_rl_cfg_entry_point", [text for text in overrides if "range(" not in text])


def test_every_page_shows_commands_and_each_is_run_or_accounted_for():
    assert {page for page, _ in ALL} == set(PAGES)
    assert set(ELSEWHERE) <= set(FIRST) | {"python -m pytest"}
    assert {script for page in OTHERS for script, _ in mentions(page)} & {"scripts/usd_info.py", "usd"}
    assert len(FIRST) > 12

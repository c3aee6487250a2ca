"""The wheel alone is enough: commands run from a fresh environment in an empty folder, without this repository.

The fresh environment has the wheel, and takes the packages that it needs from the environment of the tests. An editable
install of lift_lab there does not count, because its ``.pth`` file is not read.
"""

import email
import json
import os
import re
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("lift_lab", "lift_lab_assets", "lift_lab_cli", "lift_lab_rl", "lift_lab_tasks")
PIP = [sys.executable, "-m", "pip", "--quiet", "--no-input", "--disable-pip-version-check"]
CPU = ("--task", "Cartpole", "--device", "cpu", "--num_threads", "1")
LARGEST_BYTES = 6 * 2**20


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel, built from this checkout."""
    folder = tmp_path_factory.mktemp("dist")
    command = [*PIP, "wheel", "--no-deps", f"--wheel-dir={folder}", str(ROOT)]
    done = subprocess.run(command, capture_output=True, text=True)
    if "No matching distribution found for hatch" in done.stderr:
        pytest.skip("the build tools cannot be downloaded")
    assert done.returncode == 0, done.stderr[-2000:]
    (path,) = folder.glob("*.whl")
    return path


@pytest.fixture(scope="module")
def command(wheel, tmp_path_factory):
    """Runs a program of the fresh environment in an empty folder; returns exit status, output and errors."""
    fresh, empty = tmp_path_factory.mktemp("fresh"), tmp_path_factory.mktemp("empty")
    venv.create(fresh, with_pip=False)
    programs = fresh / ("Scripts" if os.name == "nt" else "bin")
    subprocess.run([*PIP, "--python", str(programs / "python"), "install", "--no-deps", str(wheel)], check=True)
    paths = {name: sysconfig.get_path(name) for name in ("purelib", "platlib")}
    (own,) = fresh.rglob("site-packages")
    (own / "of_the_tests.pth").write_text("\n".join(dict.fromkeys(paths.values())) + "\n")
    left_out = ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV", "DISPLAY", "WAYLAND_DISPLAY")
    environment = {name: value for name, value in os.environ.items() if name not in left_out}

    def run(program, *args):
        words = [str(programs / program), *map(str, args)]
        done = subprocess.run(words, cwd=empty, env=environment, capture_output=True, text=True)
        return done.returncode, done.stdout, done.stderr

    run.folder, run.site = empty, own  # type: ignore[attr-defined]
    return run


def test_the_wheel_holds_the_packages_and_their_data_and_nothing_else(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    folders = {name.partition("/")[0] for name in names}
    assert {name for name in folders if not name.endswith(".dist-info")} == set(PACKAGES)
    assert {f"{package}/py.typed" for package in PACKAGES} <= names
    for source in ("assets/usd", "assets/pretrained", "examples"):
        target = f"lift_lab_assets/{Path(source).name}"
        files = [path.relative_to(ROOT / source).as_posix() for path in (ROOT / source).rglob("*") if path.is_file()]
        assert {f"{target}/{name}" for name in files} <= names
    assert {"LICENSE", "NOTICE"} <= {name.rpartition("/")[2] for name in names if ".dist-info/licenses/" in name}
    assert not [name for name in names if re.search(r"(^|/)(tests?|scripts|maintainers|__pycache__)/", name)]
    assert wheel.stat().st_size < LARGEST_BYTES


def test_the_description_stands_alone(wheel):
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        metadata = email.message_from_bytes(archive.read(name))
    text = metadata.get_payload()
    assert metadata["Description-Content-Type"] == "text/markdown"
    assert "# lift_lab" in text
    targets = re.findall(r"\]\(([^)]*)\)", text) + re.findall(r"""(?:src|href)=["']([^"']*)""", text)
    assert not [target for target in targets if not target.startswith(("https://", "http://", "#"))]
    needed = {extra: set() for extra in metadata.get_all("Provides-Extra")}
    for line in metadata.get_all("Requires-Dist"):
        package, _, extra = line.partition("; extra == ")
        if extra:
            needed[extra.strip("'\"")].add(package)
    assert needed["all"] == set().union(
        *(needed[extra] for extra in ("viewer", "video", "report", "wandb", "datasets"))
    )


def test_the_modules_are_those_of_the_wheel(command):
    code = f"import lift_lab, importlib.util as u; [print(u.find_spec(name).origin) for name in {PACKAGES}]"
    status, out, err = command("python", "-c", code)
    assert status == 0, err
    assert [Path(line).parent for line in out.splitlines()] == [command.site / name for name in PACKAGES]


def test_the_commands_train_play_evaluate_and_export(command):
    status, out, err = command("lift-lab", "--version")
    assert (status, err) == (0, "")
    assert re.fullmatch(r"lift-lab \d+\.\d+\S*\n", out)

    status, out, err = command("lift-lab", "train", *CPU, "--num_envs", 16, "--max_iterations", 2)
    assert status == 0, err[-2000:]
    (run,) = command.folder.glob("logs/rsl_rl/*/*")
    assert (run / "model_2.pt").is_file()
    assert f"finished after 2 iterations: {run / 'model_2.pt'}" in out

    status, out, err = command("lift-lab", "play", *CPU, "--num_envs", 2, "--steps", 3)
    assert status == 0, err[-2000:]
    assert (run / "exported" / "policy.onnx").stat().st_size > 1000
    assert (run / "exported" / "policy.pt").is_file()

    flags = ("--num_envs", 2, "--episodes", 2, "--json", "result.json", "env.episode_length_s=0.1")
    status, out, err = command("lift-lab", "evaluate", *CPU, *flags)
    assert status == 0, err[-2000:]
    assert json.loads((command.folder / "result.json").read_text())["episodes"] == 2


def test_the_commands_list_tasks_and_import_usd_files(command):
    status, out, err = command("lift-lab", "list", "--keyword", "lift-cube")
    assert status == 0, err
    assert {"Lift-Cube-Franka-CL", "Lift-Cube-Franka-Play"} <= set(re.findall(r"[\w-]+", out))

    status, out, err = command("lift-lab", "usd", command.site / "lift_lab_assets" / "usd" / "cube.usda")
    assert status == 0, err
    assert "6 degrees of freedom" in out


def test_the_demo_films_a_policy_of_the_wheel(command):
    flags = ("--task", "Lift-Cube-Franka-CL-Play", "--steps", 2, "--num_envs", 1, "env.viewer.resolution=[64,48]")
    status, out, err = command("lift-lab", "demo", *flags, "--video")
    if "no OpenGL library was found" in err:
        pytest.skip("no OpenGL library")
    assert status == 0, err[-2000:]
    assert f"policy: {command.site}" in out
    assert (command.folder / "lift_demo.mp4").stat().st_size > 500

"""Scripts written for Isaac Lab's launcher run without one."""

import subprocess
import sys

from lift_lab.app import AppLauncher
from lift_lab.app.cli import Parser


def test_the_app_runs_until_it_is_closed():
    parser = Parser("Test.")
    AppLauncher.add_app_launcher_args(parser)
    args, overrides = parser.parse(["--device", "cpu", "env.decimation=2"])
    launcher = AppLauncher(args)
    assert launcher.device == "cpu"
    assert overrides == ["env.decimation=2"]
    assert launcher.app.is_running()
    launcher.app.close()
    assert not launcher.app.is_running()


def test_only_flags_without_a_meaning_are_named_as_ignored(capsys):
    AppLauncher(headless=True, device="cpu")
    assert capsys.readouterr().err == "ignored: --headless (there is no simulator window here)\n"
    AppLauncher(device="cpu")
    assert capsys.readouterr().err == ""


def test_the_launcher_does_not_import_torch_or_mujoco():
    code = "import lift_lab.app, lift_lab.app.cli, sys; print([m for m in ('torch', 'mujoco') if m in sys.modules])"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"

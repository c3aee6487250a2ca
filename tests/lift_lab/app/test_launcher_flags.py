"""Scripts written for Isaac Lab's launcher run without one."""

import subprocess
import sys

import pytest

from lift_lab.app import AppLauncher
from lift_lab.app.cli import Parser
from lift_lab.utils.errors import ConfigError


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


@pytest.mark.parametrize(
    ("flags", "line"),
    [
        (["--headless"], ""),
        (["--livestream", "0", "--device", "cpu", "--info"], ""),
        (["--enable_cameras"], "no effect here: --enable_cameras (there is no Omniverse)\n"),
        (
            ["--headless", "--livestream", "2", "--kit_args=--foo", "--rendering_mode", "quality"],
            "no effect here: --livestream, --rendering_mode, --kit_args (there is no Omniverse); "
            "play --viewer shows the simulation in a browser\n",
        ),
        (
            ["--disable_fabric", "--ray-proc-id", "3"],
            "no effect here: --disable_fabric, --ray-proc-id (there is no Omniverse)\n",
        ),
    ],
)
def test_flags_without_effect_are_named_in_one_line(capsys, flags, line):
    parser = Parser("Test.")
    AppLauncher.add_app_launcher_args(parser)
    parser.add_argument("--disable_fabric", action="store_true")  # as Isaac Lab's scripts add them
    parser.add_argument("--ray-proc-id", "-rid", type=int, default=None)
    AppLauncher(parser.parse(flags)[0])
    assert capsys.readouterr().err == line


@pytest.mark.parametrize(
    ("flag", "advice"),
    [("--cpu", "--device cpu"), ("--xr", "XR"), ("--anim_recording_enabled", "--replay FILE.html")],
)
def test_flags_that_ask_for_what_does_not_exist_are_errors(flag, advice):
    parser = Parser("Test.")
    AppLauncher.add_app_launcher_args(parser)
    with pytest.raises(ConfigError, match=f"^{flag}: .*{advice}"):
        AppLauncher(parser.parse([flag])[0])


def test_help_and_hints_show_no_flag_without_effect(capsys):
    parser = Parser("Test.")
    AppLauncher.add_app_launcher_args(parser)
    text = parser.format_help()
    assert "--device" in text
    assert not [flag for flag in ("--headless", "--livestream", "--kit_args", "--cpu") if flag in text]
    with pytest.raises(SystemExit):
        parser.parse(["--headles"])
    assert "--headless" not in capsys.readouterr().err


def test_the_launcher_does_not_import_torch_or_mujoco():
    code = "import lift_lab.app, lift_lab.app.cli, sys; print([m for m in ('torch', 'mujoco') if m in sys.modules])"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"

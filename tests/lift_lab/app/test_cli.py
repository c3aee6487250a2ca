"""How a program starts and ends."""

import sys

import pytest

from lift_lab.app import cli


def test_windows_is_refused_in_one_line(monkeypatch, capsys):
    monkeypatch.setattr(sys, "platform", "win32")
    with pytest.raises(SystemExit) as ended:
        cli.run(lambda: pytest.fail("it ran"))
    assert ended.value.code == cli.USAGE_ERROR
    assert capsys.readouterr().err == "error: lift_lab does not run on Windows itself: use WSL 2 (docs/install.md)\n"

"""What the tests of the scripts share."""

import runpy
import sys
from pathlib import Path

import pytest
import torch

SCRIPTS = Path(__file__).parents[2] / "scripts"


@pytest.fixture
def script(monkeypatch, capsys):
    """Runs a script in this process; returns exit status, output and errors."""
    threads = torch.get_num_threads()

    def call(name, *args):
        monkeypatch.setattr(sys, "argv", [name, *map(str, args)])
        with pytest.raises(SystemExit) as ended:
            runpy.run_path(str(SCRIPTS / name), run_name="__main__")
        captured = capsys.readouterr()
        return ended.value.code, captured.out, captured.err

    yield call
    torch.set_num_threads(threads)

"""What the page on other libraries shows runs as it is written."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "libraries.md").read_text()
BLOCKS = re.findall(r"^```python\n(.*?)^```$", PAGE, flags=re.DOTALL | re.MULTILINE)
BLOCKS = [block for block in BLOCKS if "(Library)" not in block]  # tests/lift_lab_cli/test_library.py runs that one


@pytest.mark.parametrize("code", BLOCKS, ids=["sb3", "gymnasium"])
def test_a_block_of_python_runs(code, tmp_path):
    if "stable_baselines3" in code:
        pytest.importorskip("stable_baselines3", reason="Stable-Baselines3 is not installed (the extra 'sb3')")
    (tmp_path / "block.py").write_text(code)
    env = {**os.environ, "OMP_NUM_THREADS": "1"}
    done = subprocess.run([sys.executable, "block.py"], cwd=tmp_path, env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    if "length_queue" in code:
        lengths = re.findall(r"\d+", done.stdout.splitlines()[-1])
        assert len(lengths) == 8
        assert all(1 <= int(length) <= 300 for length in lengths)


def test_every_script_that_is_named_exists():
    named = set(re.findall(r"scripts/\w+/?\w*\.py", PAGE))
    assert named
    assert [name for name in named if not (ROOT / name).is_file()] == []

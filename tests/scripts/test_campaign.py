"""A small part of the campaign: whoever breaks what it checks learns of it before the whole campaign runs."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

CAMPAIGN = Path(__file__).parents[2] / "scripts" / "maintainers" / "campaign.py"
NONE = {"kills": 0, "wrong": 0, "damaged": 0, "disks": 0, "terminals": 0}


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the campaign forks")
@pytest.mark.parametrize(
    ("counts", "kinds"),
    [
        ({"wrong": 12}, {"wrong inputs, listed": 12}),
        ({"kills": 4, "studies": 0}, {"train, native: same bits as uninterrupted": 1}),
        ({"damaged": 7}, {"checkpoint that is named": 1, "event files": 1, "USD files": 1}),
        ({"disks": 1, "terminals": 3}, {"the reader of a pipe ends": 1}),
    ],
    ids=["wrong inputs", "kills", "damaged files", "disk and terminals"],
)
def test_what_is_broken_on_purpose_holds(tmp_path, counts, kinds):
    flags = [f"--{name}={value}" for name, value in (NONE | counts).items()]
    flags += ["--engines", "native"]
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    command = [sys.executable, str(CAMPAIGN), *flags, "--json", str(tmp_path / "result.json")]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    result = json.loads((tmp_path / "result.json").read_text())
    assert result["failures"] == []
    tried = {kind: count for kind, count, _ in result["rows"]}
    for kind, least in kinds.items():
        assert tried[kind] >= least

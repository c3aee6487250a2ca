"""The file of the arm that tests of assets share."""

from pathlib import Path

import pytest
from arm_and_box import author_arm


@pytest.fixture(scope="module")
def arm_file(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("usd") / "arm.usda"
    author_arm(path)
    return path

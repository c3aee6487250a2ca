"""The file of the arm that tests of assets share."""

from pathlib import Path

import pytest


@pytest.fixture(scope="module")
def arm_file(tmp_path_factory, author_arm) -> Path:
    return author_arm(tmp_path_factory.mktemp("usd") / "arm.usda", drives=True)

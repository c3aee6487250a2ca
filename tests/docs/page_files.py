"""What the tests of pages share."""

import re
import sys
from pathlib import Path

import gymnasium as gym


def write_files(page: Path, folder: Path) -> None:
    """Write the files that the titles of a page's Python blocks name; blocks of one title follow each other."""
    files: dict[str, list[str]] = {}
    for title, block in re.findall(r'^```python title="(.+?)"\n(.*?)^```$', page.read_text(), flags=re.DOTALL | re.M):
        files.setdefault(title, []).append(block)
    for title, parts in files.items():
        (folder / title).parent.mkdir(parents=True, exist_ok=True)
        (folder / title).write_text("\n\n".join(parts))


def forget_own_task() -> None:
    """Undo the import of the package of docs/tutorials/own_task.md, which the next test writes into another folder."""
    gym.registry.pop("Knock-Pin", None)
    for name in [name for name in sys.modules if name.partition(".")[0] == "knock"]:
        del sys.modules[name]

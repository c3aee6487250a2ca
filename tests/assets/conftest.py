"""Make the modules of scripts/maintainers importable, as they are for the script itself."""

import sys
from pathlib import Path

TOOLS = Path(__file__).resolve().parents[2] / "scripts" / "maintainers"
if str(TOOLS) not in sys.path:
    sys.path.insert(0, str(TOOLS))

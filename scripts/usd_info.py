"""``python scripts/usd_info.py ...``: see :mod:`lift_lab_cli.usd_info`."""

from lift_lab.app import cli
from lift_lab_cli import usd_info

if __name__ == "__main__":
    cli.run(usd_info.main)

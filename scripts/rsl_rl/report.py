"""``python scripts/rsl_rl/report.py ...``: see :mod:`lift_lab_cli.report`."""

from lift_lab.app import cli
from lift_lab_cli import report

if __name__ == "__main__":
    cli.run(report.main)

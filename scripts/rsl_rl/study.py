"""``python scripts/rsl_rl/study.py ...``: see :mod:`lift_lab_cli.study`."""

from lift_lab.app import cli
from lift_lab_cli import study

if __name__ == "__main__":
    cli.run(study.main)

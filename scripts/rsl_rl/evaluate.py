"""``python scripts/rsl_rl/evaluate.py ...``: see :mod:`lift_lab_cli.evaluate`."""

from lift_lab.app import cli
from lift_lab_cli import evaluate

if __name__ == "__main__":
    cli.run(evaluate.main)

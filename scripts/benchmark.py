"""``python scripts/benchmark.py ...``: see :mod:`lift_lab_cli.benchmark`."""

from lift_lab.app import cli
from lift_lab_cli import benchmark

if __name__ == "__main__":
    cli.run(benchmark.main)

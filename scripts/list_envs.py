"""``python scripts/list_envs.py ...``: see :mod:`lift_lab_cli.list_envs`."""

from lift_lab.app import cli
from lift_lab_cli import list_envs

if __name__ == "__main__":
    cli.run(list_envs.main)

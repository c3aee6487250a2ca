"""Train a policy with skrl: ``python scripts/skrl/train.py --task TASK [flags] [overrides]``."""

from lift_lab.app import cli
from lift_lab_cli import train
from lift_lab_cli.skrl_library import Skrl

if __name__ == "__main__":
    cli.run(lambda: train.main(Skrl()))

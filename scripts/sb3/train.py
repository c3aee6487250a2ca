"""Train a policy with Stable-Baselines3's PPO: ``python scripts/sb3/train.py --task TASK [flags] [overrides]``."""

from lift_lab.app import cli
from lift_lab_cli import train
from lift_lab_cli.sb3_library import Sb3

if __name__ == "__main__":
    cli.run(lambda: train.main(Sb3()))

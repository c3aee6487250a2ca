"""Train a policy with rsl_rl's PPO: ``python scripts/rsl_rl/train.py --task TASK [flags] [overrides]``."""

from lift_lab.app import cli
from lift_lab_cli import train
from lift_lab_cli.rsl_rl_library import RslRl

if __name__ == "__main__":
    cli.run(lambda: train.main(RslRl()))

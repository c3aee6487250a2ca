"""Run a policy that Stable-Baselines3's PPO trained: ``python scripts/sb3/play.py --task TASK [flags] [overrides]``."""

from lift_lab.app import cli
from lift_lab_cli import play
from lift_lab_cli.sb3_library import Sb3

if __name__ == "__main__":
    cli.run(lambda: play.main(Sb3()))

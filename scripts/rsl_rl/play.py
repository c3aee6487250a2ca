"""Run a policy that rsl_rl's PPO trained: ``python scripts/rsl_rl/play.py --task TASK [flags] [overrides]``."""

from lift_lab.app import cli
from lift_lab_cli import play
from lift_lab_cli.rsl_rl_library import RslRl

if __name__ == "__main__":
    cli.run(lambda: play.main(RslRl()))

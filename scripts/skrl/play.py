"""Run a policy that skrl trained: ``python scripts/skrl/play.py --task TASK [flags] [overrides]``."""

from lift_lab.app import cli
from lift_lab_cli import play
from lift_lab_cli.skrl_library import Skrl

if __name__ == "__main__":
    cli.run(lambda: play.main(Skrl()))

"""``python -m lift_lab_cli COMMAND ...``: the console command ``lift-lab`` by Python's ``-m``."""

from lift_lab.app import cli

from . import main

if __name__ == "__main__":
    cli.run(lambda: main.main("python -m lift_lab_cli"))

"""Run in an environment with mujoco-usd-converter and urdf-usd-converter: robot descriptions to USD.

Arguments: a JSON file with a list of (description, output folder, ROS packages), and the file to write the stages to.
"""

import json
import sys
from pathlib import Path


def convert(source, folder, packages):
    """Path of the stage that the converter for this kind of description writes."""
    if source.endswith(".urdf"):
        from urdf_usd_converter import Converter

        return Converter(ros_packages=packages).convert(source, folder).path
    from mujoco_usd_converter import Converter

    return Converter().convert(source, folder).path


def main():
    asked, answered = sys.argv[1:]
    Path(answered).write_text(json.dumps([convert(*task) for task in json.loads(Path(asked).read_text())]))


if __name__ == "__main__":
    main()

"""Compare importers of USD physics, feature by feature, by running each on the same generated stages.

python scripts/maintainers/usd_compare.py [--newton PYTHON] [--mujoco-usd PYTHON] [--write docs/usd.md] [--details]

The two options name interpreters that have the packages newton and mujoco-usd; their pins clash with each other's and
with this project's, so each wants a virtual environment of its own. A column without an interpreter is left out.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from usd_compare_cases import FEATURES, Feature

from lift_lab.app import cli
from lift_lab.utils.errors import PhysicsError

LIMIT_S = 1200
BEGIN, END = "<!-- usd_compare: begin -->", "<!-- usd_compare: end -->"


def main() -> int:
    parser = cli.Parser(__doc__, overrides=False)
    parser.add_argument("--newton", type=Path, default=None, metavar="PYTHON", help="an interpreter with newton")
    parser.add_argument("--mujoco-usd", type=Path, default=None, metavar="PYTHON", help="one with mujoco-usd")
    parser.add_argument("--write", type=Path, default=None, metavar="FILE", help="replace the table in this document")
    parser.add_argument("--details", action="store_true", help="print every number that differs")
    args, _ = parser.parse()
    pythons = {"lift_lab": Path(sys.executable), "mujoco-usd": args.mujoco_usd, "newton": args.newton}
    with tempfile.TemporaryDirectory() as folder:
        files = write_stages(Path(folder))
        answers = {name: run(name, python, files) for name, python in pythons.items() if python}
    table = as_table(answers)
    print(table)
    if args.details:
        for feature in FEATURES:
            for name, found in answers.items():
                for line in differences(feature, found[feature.name]):
                    print(f"{feature.name} | {name} | {line}")
    if args.write:
        text = args.write.read_text()
        before, rest = text.split(BEGIN, 1)
        after = rest.split(END, 1)[1]
        args.write.write_text(f"{before}{BEGIN}\n\n{table}\n{END}{after}")
    return 0


def write_stages(folder: Path) -> dict[str, str]:
    """One file a feature: name -> path."""
    files = {}
    for i, feature in enumerate(FEATURES):
        path = folder / f"feature_{i:02d}.usda"
        path.write_text(feature.stage)
        files[feature.name] = str(path)
    return files


def run(importer: str, python: Path, files: dict[str, str]) -> dict[str, dict]:
    """Answers by feature; a stage that ends the interpreter is answered with an error."""
    script = Path(__file__).with_name("usd_compare_run.py")
    names = {path: name for name, path in files.items()}
    answers: dict[str, dict] = {}
    waiting = list(names)
    variables = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    with tempfile.TemporaryDirectory() as folder:
        asked, answered = Path(folder) / "asked.json", Path(folder) / "answered.jsonl"
        while waiting:
            asked.write_text(json.dumps(waiting))
            answered.write_text("")
            command = [str(python), str(script), importer, str(asked), str(answered)]
            done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S, check=False, env=variables)
            lines = [json.loads(line) for line in answered.read_text().splitlines()]
            answers |= {names[path]: answer for path, answer in lines}
            waiting = waiting[len(lines) :]
            if waiting:
                if "Traceback" in done.stderr:  # an importer's own errors are answers
                    raise PhysicsError(f"{importer}: {done.stderr.strip().splitlines()[-1]}")
                answers[names[waiting.pop(0)]] = {"error": f"ends the interpreter (exit status {done.returncode})"}
    return answers


def look_up(answer: dict, path: str):
    """Value at a dotted path, None if there is none."""
    value = answer
    for key in path.split("."):
        if key == "length":
            return len(value)
        if isinstance(value, list):
            value = value[int(key)] if int(key) < len(value) else None
        else:
            value = value.get(key)
        if value is None:
            return None
    return value


def agrees(found, expected, tolerance: float) -> bool:
    """Equal, numbers to a relative tolerance (absolute below one)."""
    if isinstance(expected, (bool, str)) or found is None:
        return found == expected
    if isinstance(expected, list):
        return (
            isinstance(found, list)
            and len(found) == len(expected)
            and all(agrees(f, e, tolerance) for f, e in zip(found, expected, strict=True))
        )
    return not isinstance(found, str) and abs(found - expected) <= tolerance * max(1.0, abs(expected))


def differences(feature: Feature, answer: dict) -> list[str]:
    """What is not as expected, one line each."""
    if "error" in answer:
        return [answer["error"]]
    wrong = []
    for path, expected in feature.expected.items():
        found = look_up(answer, path)
        if not agrees(found, expected, feature.tolerance):
            wrong.append(f"{path} is {found}, not {expected}")
    return wrong


def verdict(feature: Feature, answer: dict) -> str:
    """yes, partly (what is wrong), no, or refused."""
    if "error" in answer:
        return "refused"
    wrong = [line.split(" is ", 1)[0] for line in differences(feature, answer)]
    if not wrong:
        return "yes"
    if len(wrong) == len(feature.expected):
        return "no"
    return f"partly, not `{', '.join(wrong)}`"


def as_table(answers: dict[str, dict[str, dict]]) -> str:
    """The table in Markdown, with a line of totals."""
    rows = [["feature", *answers], ["---"] * (1 + len(answers))]
    for feature in FEATURES:
        rows.append([feature.name, *(verdict(feature, found[feature.name]) for found in answers.values())])
    totals = [sum(row[i] == "yes" for row in rows) for i in range(1, len(rows[0]))]
    rows.append([f"**of {len(FEATURES)}**", *(f"**{total}**" for total in totals)])
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


if __name__ == "__main__":
    cli.run(main)

"""Break the project on purpose and count what holds: kills, wrong inputs, damaged files, full disks, lost terminals.

python scripts/maintainers/campaign.py [--kills 100] [--wrong 400] [--damaged 100] [--disks 6] [--terminals 12]
    [--seed 0]

Every attempt is of a small Cartpole training in a process of its own. What has to hold is printed with each row of the
table; docs/reliability.md has the numbers of a whole run. The exit status is 1 if anything does not hold. A number of 0
leaves a part out. The seed fixes signals, moments, files and damages; moments depend on the machine's speed, too.
"""

from __future__ import annotations

import json
import random
import sys
import tempfile
import time
from pathlib import Path

SCRIPTS = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(Path(__file__).parent))

from campaign_runs import ENGINES, References, Tally, preload  # noqa: E402

from lift_lab.app import cli  # noqa: E402


def main() -> int:
    parser = cli.Parser(__doc__, overrides=False)
    parser.add_argument("--kills", type=count, default=100, help="processes to kill, most of them trainings")
    parser.add_argument("--wrong", type=count, default=400, help="wrong command lines")
    parser.add_argument("--damaged", type=count, default=100, help="damaged files")
    parser.add_argument("--disks", type=count, default=6, help="trainings on a disk that is full for a while")
    parser.add_argument("--terminals", type=count, default=12, help="trainings that lose their terminal or reader")
    parser.add_argument("--engines", nargs="+", choices=list(ENGINES), default=list(ENGINES), help="engines that train")
    parser.add_argument("--studies", type=share, default=0.1, help="share of the kills that study.py gets")
    parser.add_argument("--seed", type=int, default=0, help="of signals, moments, files and damages")
    parser.add_argument("--folder", type=Path, default=None, help="where to work, kept (default: a temporary folder)")
    parser.add_argument("--json", type=Path, default=None, help="file for the numbers")
    args, _ = parser.parse()

    from campaign_damage import Damage
    from campaign_kills import kill_exports, kill_studies, kill_trainings
    from campaign_surroundings import full_disks, lost_terminals
    from campaign_wrong import wrong_inputs

    began = time.monotonic()
    preload("warp" in args.engines)
    tally = Tally()
    with tempfile.TemporaryDirectory() as temporary:
        folder = (args.folder or Path(temporary)).absolute()
        ref = References(folder / "reference")

        def part(name: str) -> tuple[Path, random.Random]:
            """Folder and random numbers of a part, whatever the other parts do."""
            print(f"-- {name}, after {time.monotonic() - began:.0f} s", flush=True)
            return folder / name, random.Random(f"{args.seed} {name}")

        studies = round(args.kills * args.studies)
        exports = round((args.kills - studies) / 6)
        trainings = args.kills - studies - exports
        wrong_inputs(*part("wrong"), args.wrong, tally)
        Damage(*part("damaged"), tally, ref).run(args.damaged) if args.damaged else None
        for number, engine in enumerate(args.engines):
            kills = trainings * (number + 1) // len(args.engines) - trainings * number // len(args.engines)
            place, rng = part(f"kills-{engine}")
            kill_trainings(place, engine, kills, rng, tally, ref) if kills else None
        place, rng = part("exports")
        kill_exports(place, exports, rng, tally, ref) if exports else None
        kill_studies(*part("studies")[:1], studies, random.Random(f"{args.seed} studies"), tally)
        place, rng = part("disks")
        full_disks(place, args.disks, rng, tally, ref) if args.disks else None
        place, rng = part("terminals")
        lost_terminals(place, args.terminals, rng, tally, ref) if args.terminals else None
    seconds = time.monotonic() - began
    print("| what | tried | held |\n|---|---|---|")
    for kind, tried, held in tally.rows():
        print(f"| {kind} | {tried} | {held} |")
    print(f"{sum(tally.tried.values())} checks in {seconds:.0f} s, {len(tally.failures)} failed")
    if args.json is not None:
        from lift_lab_rl.files import write_atomically

        content = {"seed": args.seed, "seconds": seconds, "rows": tally.rows(), "failures": tally.failures}
        write_atomically(args.json, (json.dumps(content, indent=2) + "\n").encode())
    return 1 if tally.failures else 0


def count(text: str) -> int:
    """A whole number from 0."""
    import argparse

    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"expected a whole number from 0, got '{text}'")
    return int(text)


def share(text: str) -> float:
    """A number from 0 to 1."""
    import argparse

    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0.0 <= value <= 1.0:
        raise argparse.ArgumentTypeError(f"expected a number from 0 to 1, got '{text}'")
    return value


if __name__ == "__main__":
    cli.run(main)

"""Draw the paper's figures and tables from training runs, our numbers beside the paper's.

lift-lab report RUNS... --out DIR

RUNS are folders of runs, or folders that hold some (logs/rsl_rl/<experiment>), each possibly with LABEL= in front. Runs
are grouped by what was trained (task and overrides, or a study's labels) and averaged over seeds. Evaluations come from
the results.json beside the runs, which ``lift-lab study`` writes. Makes DIR/report.html, which needs no other
file, and DIR/figures/*.png and *.pdf.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from lift_lab.app import cli


def parse():
    parser = cli.Parser(__doc__, overrides=False)
    parser.add_argument("runs", nargs="+", metavar="RUNS", help="folders of runs, each as FOLDER or LABEL=FOLDER")
    parser.add_argument("--out", type=Path, required=True, help="folder for the report")
    parser.add_argument(
        "--results", type=Path, default=None, help="file of evaluations (default: results.json beside the runs)"
    )
    parser.add_argument("--baseline", type=str, default=None, help="label that corresponds to the paper's baseline")
    parser.add_argument("--curriculum", type=str, default=None, help="label that corresponds to the paper's curriculum")
    parser.add_argument(
        "--tail", type=share, default=0.05, help="share of the last iterations in the means (default: 0.05)"
    )
    parser.add_argument(
        "--smoothing", type=share, default=0.9, help="smoothing of the curves, from 0 to below 1 (default: 0.9)"
    )
    parser.add_argument("--title", type=str, default="Curriculum against baseline", help="heading of the page")
    return parser.parse()[0]


def share(text: str) -> float:
    """A number from 0 to below 1."""
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0.0 <= value < 1.0:
        raise argparse.ArgumentTypeError(f"expected a number from 0 to below 1, got '{text}'")
    return value


def main() -> int:
    args = parse()

    from lift_lab_rl.study.comparison import Roles
    from lift_lab_rl.study.curves import find_runs, group_runs, remarks
    from lift_lab_rl.study.evaluations import collect, find_results
    from lift_lab_rl.study.missing import missing_scalars
    from lift_lab_rl.study.page import tables, write_report
    from lift_lab_tasks.manager_based.manipulation.lift.paper import PAPER

    runs = find_runs(args.runs)
    groups = group_runs(runs)
    results, left_out = collect([args.results] if args.results is not None else find_results(runs), runs)
    roles = Roles.guess(groups, PAPER, args.baseline, args.curriculum)
    groups = roles.ordered(groups)
    notes = [*remarks(runs), *left_out, *missing_scalars(groups, results, PAPER)]
    page = write_report(groups, results, PAPER, roles, args.out, args.title, args.tail, args.smoothing, notes)
    show(tables(groups, results, PAPER, roles, args.tail))
    for note in notes:
        print(f"note: {note}")
    print(f"written: {page}")
    return 0


def show(made: list) -> None:
    """Print the tables."""
    from rich.console import Console
    from rich.table import Table

    for table in made:
        shown = Table(title=table.title, title_justify="left")
        for name in table.header:
            shown.add_column(name, overflow="fold")
        for row in table.rows:
            shown.add_row(*row)
        Console().print(shown)


if __name__ == "__main__":
    cli.run(main)

"""List the registered tasks.

lift-lab list [--keyword TEXT] [--module MODULE]
lift-lab list --describe ID [overrides]
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from lift_lab.app import cli

if TYPE_CHECKING:
    from rich.console import Console

NO_LIMIT = 10_000
"""Width in columns of output that is not for a terminal."""

_TITLES = ("task", "environment", "agents", "pretrained")
_COLUMNS = ((0, 1, 2, 3), (0, 2, 3), (0, 3), (0,))
"""Which columns are shown: the first set that fits."""


def main() -> int:
    parser = cli.Parser(__doc__, multirun=False)
    parser.add_argument(
        "--keyword", type=str, default=None, help="show only ids that contain this text; case is ignored"
    )
    parser.add_argument("--describe", type=str, default=None, metavar="ID", help="show what a task is made of")
    parser.add_argument("--module", type=str, default=None, help="also show the tasks that your module registers")
    args, overrides = parser.parse()
    if args.describe is not None and args.module is not None:
        parser.error(f"--describe takes the module, too: --describe {args.module}:ID")
    if args.describe is not None and args.keyword is not None:
        parser.error("--keyword filters the list of tasks, which --describe does not show: leave one out")
    if overrides and args.describe is None:
        parser.error(f"unexpected argument '{overrides[0]}'")
    if args.describe is not None:
        from .describe import show_task

        return show_task(args.describe, overrides)

    import lift_lab_tasks  # noqa: F401
    from lift_lab.utils.errors import NotFoundError, suggest
    from lift_lab_tasks.utils import registered_tasks, task_kwargs
    from lift_lab_tasks.utils.runs import pretrained_name, pretrained_tasks

    tasks = registered_tasks() if args.module is None else tasks_of(args.module)
    names = [n for n in tasks if args.keyword is None or args.keyword.lower() in n.lower()]
    if not names:
        raise NotFoundError(f"no task contains '{args.keyword}'; {suggest(args.keyword or '', tasks)}")
    shipped = pretrained_tasks()
    rows = []
    for name in names:
        kwargs = task_kwargs(name)
        agents = [
            k.removesuffix("_cfg_entry_point") for k in kwargs if k.endswith("_cfg_entry_point") and k[:4] != "env_"
        ]
        pretrained = "yes" if pretrained_name(name) in shipped else ""
        rows.append((name, str(kwargs["env_cfg_entry_point"]), ", ".join(agents), pretrained))
    show(make_console(), rows)
    return 0


def tasks_of(module: str) -> list[str]:
    """Import a module and return the tasks that it registers, as ``MODULE:ID``.

    Raises:
        NotFoundError: there is no such module, or it registers no task.
    """
    from lift_lab.utils.errors import NotFoundError
    from lift_lab_tasks.utils import import_user_module, registered_tasks

    before = registered_tasks()
    import_user_module(module)
    own = [f"{module}:{name}" for name in registered_tasks() if name not in before]
    if not own:
        raise NotFoundError(f"the module '{module}' registers no task: call gymnasium.register in it")
    return own


def make_console() -> Console:
    """The output, for tables. If it is piped into another program, it is not cut to the width of a terminal."""
    from rich.console import Console

    console = Console()
    return console if console.is_terminal else Console(width=NO_LIMIT)


def show(console: Console, rows: Sequence[tuple[str, str, str, str]]) -> None:
    """Print a table of tasks. No id is cut: columns that do not fit are left out and named below the table.

    Args:
        console: where to.
        rows: id, environment, agents and ``yes`` or nothing for a pretrained policy, of each task.
    """
    from rich.table import Table

    for shown in _COLUMNS:
        table = Table(title="Tasks", title_justify="left")
        for index in shown:
            table.add_column(_TITLES[index], no_wrap=True)
        for row in rows:
            table.add_row(*(row[index] for index in shown))
        if console.measure(table, options=console.options.update(max_width=NO_LIMIT)).maximum <= console.width:
            console.print(table)
            break
    else:
        shown = (0,)
        for row in rows:
            console.print(row[0], soft_wrap=True, markup=False, highlight=False)
    left_out = [title for index, title in enumerate(_TITLES) if index not in shown]
    if left_out:
        text = f"not shown, because the terminal is narrow: {', '.join(left_out)} (pipe the output to see all)"
        console.print(text, markup=False, highlight=False)


if __name__ == "__main__":
    cli.run(main)

"""List the registered tasks.

python scripts/list_envs.py [--keyword TEXT]
python scripts/list_envs.py --describe ID [overrides]
"""

from __future__ import annotations

from lift_lab.app import cli


def main() -> int:
    parser = cli.Parser(__doc__, multirun=False)
    parser.add_argument("--keyword", type=str, default=None, help="show only ids that contain this, in any case")
    parser.add_argument("--describe", type=str, default=None, metavar="ID", help="show what a task is made of")
    args, overrides = parser.parse()
    if args.describe is not None and args.keyword is not None:
        parser.error("--keyword filters the list of tasks, which --describe does not show: leave one out")
    if overrides and args.describe is None:
        parser.error(f"unexpected argument '{overrides[0]}'")

    from rich.console import Console
    from rich.table import Table

    import lift_lab_tasks  # noqa: F401
    from lift_lab.utils.errors import NotFoundError, suggest
    from lift_lab_tasks.utils import registered_tasks, task_kwargs
    from lift_lab_tasks.utils.runs import pretrained_name, pretrained_tasks

    console = Console()
    # A table that is piped into another program is not cut to the width of a terminal.
    console = console if console.is_terminal else Console(width=220)
    if args.describe is not None:
        from lift_lab_tasks.utils.describe import describe

        for part in describe(args.describe, overrides):
            console.print(part)
        return 0
    names = [n for n in registered_tasks() if args.keyword is None or args.keyword.lower() in n.lower()]
    if not names:
        raise NotFoundError(f"no task contains '{args.keyword}'; {suggest(args.keyword or '', registered_tasks())}")
    shipped = pretrained_tasks()
    table = Table("task", "environment", "agents", "pretrained", title="Tasks", title_justify="left")
    for name in names:
        kwargs = task_kwargs(name)
        agents = [
            k.removesuffix("_cfg_entry_point") for k in kwargs if k.endswith("_cfg_entry_point") and k[:4] != "env_"
        ]
        pretrained = "yes" if pretrained_name(name) in shipped else ""
        table.add_row(name, str(kwargs["env_cfg_entry_point"]), ", ".join(agents), pretrained)
    console.print(table)
    return 0


if __name__ == "__main__":
    cli.run(main)

"""Show what a task is made of.

lift-lab describe ID [overrides]
"""

from __future__ import annotations

from collections.abc import Sequence

from lift_lab.app import cli


def main() -> int:
    parser = cli.Parser(__doc__, multirun=False)
    parser.add_argument("task", metavar="ID", help="id of the task (lift-lab list shows all)")
    args, overrides = parser.parse()
    return show_task(args.task, overrides)


def show_task(task: str, overrides: Sequence[str]) -> int:
    """Print the tables that describe a task.

    Args:
        task: id of the task.
        overrides: in hydra's grammar.

    Raises:
        LiftLabError: there is no such task, or an override is wrong.
    """
    import lift_lab_tasks  # noqa: F401
    from lift_lab_tasks.utils.describe import describe

    from .list_envs import make_console

    console = make_console()
    for part in describe(task, overrides):
        console.print(part)
    return 0


if __name__ == "__main__":
    cli.run(main)

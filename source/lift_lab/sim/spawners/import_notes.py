"""Notes of the USD importer, for the user of a scene."""

from __future__ import annotations

import logging

from lift_lab.usd import ImportReport

logger = logging.getLogger(__name__)

_logged: set[str] = set()


def log_import(prim_path: str, report: ImportReport, ignored: bool = True) -> None:
    """Log the losses of a spawned asset at WARNING, one line per kind, each once in a process.

    Args:
        prim_path: path of the asset in the scene.
        report: of the import. Notes that are tuning of another engine's solver, or pictures, are left out.
        ignored: whether notes of what was ignored are logged too. Spawners that write the stage themselves report the
            settings of their configs instead (:func:`lift_lab.sim.note_ignored`).
    """
    asset = f"'{prim_path}' ({report.path})" if not report.path.startswith("anon:") else f"'{prim_path}'"
    for line in report.summary(ignored):
        key = f"{report.path if not report.path.startswith('anon:') else prim_path}: {line}"
        if key not in _logged:
            _logged.add(key)
            logger.warning("%s: %s", asset, line)

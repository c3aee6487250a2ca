"""The entry point of the importer."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import mujoco
from pxr import Tf, Usd, UsdUtils

from lift_lab.usd.audit import raise_on_ignored, reject_nan
from lift_lab.usd.build import Builder
from lift_lab.usd.inherited import add_built_in_schemas, inherit_colliders
from lift_lab.usd.parse import ParsedStage, parse
from lift_lab.usd.report import ImportReport, UsdImportError
from lift_lab.usd.sandbox import import_in_sandbox
from lift_lab.usd.stage import first_line, note_diagnostics, open_stage, prototypes


def load(
    path: str | Path | Usd.Stage,
    *,
    variants: Mapping[str, str] | None = None,
    scale: float | Sequence[float] | None = None,
    strict: bool = False,
    restitution: bool = False,
) -> tuple[mujoco.MjSpec, ImportReport]:
    """Import a USD stage.

    Args:
        path: A .usd, .usda, .usdc or .usdz file, or a stage in memory (which is not changed).
        variants: Selection by variant set name, as ``{"Physics": "physx"}``.
        scale: Factor on the default prim, one number or three. Authored masses stay as they are.
        strict: Raise if any authored physics would be ignored.
        restitution: Let contacts of materials with a restitution bounce, approximately.

    Returns:
        The spec, in metres, kilograms, radians and Z-up, bodies under its world body, and the report.

    Raises:
        UsdImportError: The stage cannot be imported; the message names file, prim and attribute.
    """
    diagnostics = UsdUtils.CoalescingDiagnosticDelegate()  # holds USD's own warnings back from stderr
    name = path.GetRootLayer().identifier if isinstance(path, Usd.Stage) else str(path)
    with errors_of_usd(name):
        layers = [] if isinstance(path, Usd.Stage) else import_in_sandbox(path, variants, scale)
        stage = open_stage(path, name, variants, scale)
        del layers
        parsed, spec = import_stage(stage, name, restitution)
    note_diagnostics(diagnostics, parsed.report)
    if strict:
        raise_on_ignored(parsed)
    return spec, parsed.report


@contextmanager
def errors_of_usd(name: str) -> Iterator[None]:
    """Turn what usd-core raises into the importer's own error."""
    try:
        yield
    except Tf.ErrorException as error:
        raise UsdImportError(name, reason=first_line(error)) from None
    except UnicodeDecodeError:
        raise UsdImportError(name, reason="a name or text in it is not UTF-8") from None


def import_stage(stage: Usd.Stage, name: str, restitution: bool = False) -> tuple[ParsedStage, mujoco.MjSpec]:
    """Read a stage opened by :func:`~lift_lab.usd.stage.open_stage`; for arguments and errors see :func:`load`."""
    default = stage.GetDefaultPrim()
    report = ImportReport(name, default.GetName() if default else "")
    reject_nan(stage, name)
    parts = prototypes(stage)
    add_built_in_schemas(stage)
    inherited = inherit_colliders(stage, report, parts)
    parsed = parse(stage, name, report, parts)
    parsed.inherited = inherited
    return parsed, Builder(parsed, restitution).build()

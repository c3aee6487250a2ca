"""Opening a stage for import: composition errors, variant choices, uniform scale, point instancers.

Every edit goes to an anonymous session layer, so that neither the file nor a stage of the caller's changes.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdPhysics, UsdShade, UsdUtils

from lift_lab.usd.report import ImportReport, UsdImportError
from lift_lab.utils.errors import suggest

MAX_INSTANCES = 20_000
"""Most point instances that a stage may be expanded into."""

_COMPOSITION = {
    "ErrorInvalidAssetPath": "references",
    "ErrorUnresolvedPrimPath": "references",
    "ErrorArcCycle": "references",
    "ErrorInvalidReferenceOffset": "references",
    "ErrorInvalidSublayerPath": "subLayers",
    "ErrorSublayerCycle": "subLayers",
    "ErrorInvalidPrimPath": "references",
}
"""Composition errors without which the stage is incomplete, and the field that causes them."""


def open_stage(
    source: str | Path | Usd.Stage,
    name: str,
    variants: Mapping[str, str] | None = None,
    scale: float | Sequence[float] | None = None,
) -> Usd.Stage:
    """Open `source` on a session layer of its own and apply the caller's choices there.

    Args:
        source: A .usd, .usda, .usdc or .usdz file, or a stage in memory.
        name: What to call it in messages.
        variants: Selection by variant set name, made on every prim that has the set.
        scale: Factor on the default prim, one number or three.

    Raises:
        UsdImportError: The file is missing or broken, a reference does not resolve, or a variant does not exist.
    """
    session = Sdf.Layer.CreateAnonymous("lift_lab_import")
    if isinstance(source, Usd.Stage):
        layer = source.GetRootLayer()
        session.subLayerPaths.append(source.GetSessionLayer().identifier)
    else:
        layer = _open_layer(Path(source))
    stage = Usd.Stage.Open(layer, session)
    stage.SetEditTarget(session)
    _raise_composition_errors(stage, name)
    for variant_set, selection in (variants or {}).items():
        _select_variant(stage, name, variant_set, selection)
    if variants:
        _raise_composition_errors(stage, name)
    if scale is not None:
        _scale(stage, name, scale)
    _take_first_samples(stage)
    _expand_point_instancers(stage, name)
    return stage


def note_diagnostics(delegate: UsdUtils.CoalescingDiagnosticDelegate, report: ImportReport) -> None:
    """Put what USD itself warned about into the report."""
    for diagnostic in delegate.TakeUncoalescedDiagnostics():
        text = diagnostic.commentary.split("(")[0].strip()
        if text.startswith("CollisionAPI applied to an unknown"):
            continue  # the colliders' own note says so
        prim = next((word.strip("<>,.'\"") for word in text.split() if word.startswith(("/", "</"))), "")
        physical = re.search(r"joint|rigid|collision|physics|mass|inertia", text, re.IGNORECASE)
        report.ignore(prim, "", f"usd-core: {' '.join(text.split())[:200]}", tuning=not physical)


_OTHER_FORMATS = {".urdf": "URDF", ".xacro": "xacro", ".xml": "XML (MJCF)", ".mjcf": "MJCF", ".sdf": "SDF"}
"""Other formats of robots, by the end of a file's name."""


def _open_layer(path: Path) -> Sdf.Layer:
    if not path.is_file():
        raise UsdImportError(str(path), reason="no such file")
    kind = _OTHER_FORMATS.get(path.suffix.lower())
    if kind is not None:
        raise UsdImportError(str(path), reason=f"{kind} is not read: convert the file to USD first (docs/own_robot.md)")
    try:
        layer = Sdf.Layer.FindOrOpen(str(path))
    except Tf.ErrorException as error:
        raise UsdImportError(str(path), reason=first_line(error)) from None
    if layer is None:
        raise UsdImportError(str(path), reason="cannot be read as USD")
    return layer


def first_line(error: Tf.ErrorException) -> str:
    """Message of a USD error, without its place in USD's sources."""
    try:
        text = str(error)
    except UnicodeDecodeError:  # the message quotes bytes of the file
        return "cannot be read as USD: the text is not UTF-8"
    lines = [line.split(" : ", 1)[-1].strip(" '\n") for line in text.splitlines() if " : " in line]
    return lines[0] if lines else "cannot be read as USD"


def _raise_composition_errors(stage: Usd.Stage, name: str) -> None:
    for error in stage.GetCompositionErrors():
        attribute = _COMPOSITION.get(type(error).__name__)
        if attribute:
            path = error.rootSite.path if error.rootSite else ""
            raise UsdImportError(name, str(path), attribute, " ".join(str(error).split()))


def _select_variant(stage: Usd.Stage, name: str, variant_set: str, selection: str) -> None:
    known: set[str] = set()
    found = False
    # A selection can bring in prims with further variant sets, so each change starts the walk again.
    pending = True
    while pending:
        pending = False
        for prim in stage.Traverse(Usd.PrimAllPrimsPredicate):
            if not prim.HasVariantSets():
                continue
            sets = prim.GetVariantSets()
            known.update(sets.GetNames())
            if variant_set not in sets.GetNames():
                continue
            choices = sets.GetVariantSet(variant_set).GetVariantNames()
            if selection not in choices:
                reason = f"variant set '{variant_set}' has no '{selection}'; {suggest(selection, choices)}"
                raise UsdImportError(name, str(prim.GetPath()), variant_set, reason)
            found = True
            if sets.GetVariantSelection(variant_set) != selection:
                if not sets.GetVariantSet(variant_set).SetVariantSelection(selection):
                    raise UsdImportError(name, str(prim.GetPath()), variant_set, "cannot be selected here")
                if sets.GetVariantSelection(variant_set) == selection:
                    pending = True
                    break
    if not found:
        hint = suggest(variant_set, sorted(known)) if known else "the stage has none"
        raise UsdImportError(name, reason=f"no variant set '{variant_set}'; {hint}")


def _scale(stage: Usd.Stage, name: str, scale: float | Sequence[float]) -> None:
    factors = [float(scale)] * 3 if isinstance(scale, (int, float)) else [float(v) for v in scale]
    if len(factors) != 3 or not all(abs(v) > 0 and abs(v) < float("inf") for v in factors):
        raise UsdImportError(name, reason=f"scale must be one or three finite factors other than zero, not {scale}")
    default = stage.GetDefaultPrim()
    for prim in [default] if default else stage.GetPseudoRoot().GetChildren():
        if not prim.IsA(UsdGeom.Xformable) and (prim == default or not prim.GetTypeName()):
            prim.SetTypeName("Xform")  # a prim without type, or a Scope: it has no transform of its own
        if prim.IsA(UsdGeom.Xformable):
            op = UsdGeom.Xformable(prim).AddScaleOp(UsdGeom.XformOp.PrecisionDouble, "import")
            op.Set(Gf.Vec3d(*factors))


def prototypes(stage: Usd.Stage) -> list[Sdf.Path]:
    """Prims outside the default prim that it refers to: parts of it, and no things of their own.

    Isaac Sim's importers keep the shapes of a robot so, under `/colliders` and `/visuals` beside the robot. A prim with
    rigid bodies is a thing of its own.
    """
    default = stage.GetDefaultPrim()
    roots = stage.GetPseudoRoot().GetChildren()
    if not default or all(prim == default for prim in roots):
        return []
    arcs: list[tuple[Sdf.Path, Sdf.Path]] = []
    for layer in stage.GetLayerStack():

        def visit(path: Sdf.Path, layer: Sdf.Layer = layer) -> None:
            spec = layer.GetPrimAtPath(path) if path.IsPrimPath() or path.IsPrimVariantSelectionPath() else None
            if not spec:
                return
            own = path.StripAllVariantSelections()
            for files in (spec.referenceList, spec.payloadList):
                arcs.extend((own, arc.primPath) for arc in files.GetAppliedItems() if not arc.assetPath)
            for classes in (spec.inheritPathList, spec.specializesList):
                arcs.extend((own, target) for target in classes.GetAppliedItems())

        layer.Traverse(Sdf.Path.absoluteRootPath, visit)
    found: dict[Sdf.Path, None] = {}
    parts = [default.GetPath()]
    while parts:
        part = parts.pop()
        for source, target in arcs:
            outside = target and not target.HasPrefix(default.GetPath())
            if outside and source.HasPrefix(part) and target not in found:
                found[target] = None
                parts.append(target)
    return [path for path in found if not _holds_bodies(stage.GetPrimAtPath(path))]


def _holds_bodies(prim: Usd.Prim) -> bool:
    return any(part.HasAPI(UsdPhysics.RigidBodyAPI) for part in Usd.PrimRange(prim, _EVERYTHING)) if prim else False


def is_below(path: Sdf.Path | str, tops: list[Sdf.Path]) -> bool:
    """Whether a path is one of `tops` or below one."""
    return bool(tops) and any(Sdf.Path(str(path)).HasPrefix(top) for top in tops)


_EVERYTHING = Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)


def _own(prim: Usd.Prim) -> bool:
    """Make a prim that instances share editable by ending the instancing around it.

    Returns:
        Whether it was shared: prims found before are no longer valid then.
    """
    shared = prim.IsInstanceProxy()
    while prim.IsInstanceProxy():
        prim = prim.GetParent()
    if shared:
        prim.SetInstanceable(False)
    return shared


def has_time_samples(stage: Usd.Stage) -> bool:
    """Whether any layer that the stage is composed of animates anything."""
    return any(layer.ListAllTimeSamples() for layer in stage.GetUsedLayers())


def _has_default(attribute: Usd.Attribute) -> bool:
    return attribute.GetResolveInfo(Usd.TimeCode.Default()).GetSource() == Usd.ResolveInfoSourceDefault


def _take_first_samples(stage: Usd.Stage) -> None:
    """Give attributes that have nothing but time samples the earliest of them as their value."""
    if not has_time_samples(stage):
        return
    pending = True
    while pending:
        pending = False
        for prim in Usd.PrimRange(stage.GetPseudoRoot(), _EVERYTHING):
            sampled = [a for a in prim.GetAuthoredAttributes() if a.GetNumTimeSamples() and not _has_default(a)]
            if sampled and _own(prim):
                pending = True
                break
            for attribute in sampled:
                attribute.Set(attribute.Get(attribute.GetTimeSamples()[0]))


def _expand_point_instancers(stage: Usd.Stage, name: str) -> None:
    """Author one prim per point instance beside the instancer: the physics parser does not look inside one.

    A prototype may hold instancers, which its copies then show.
    """
    left = MAX_INSTANCES
    while True:
        found: list[Usd.Prim] = []
        walk = iter(Usd.PrimRange(stage.GetPseudoRoot(), _EVERYTHING))
        for prim in walk:
            if prim.IsA(UsdGeom.PointInstancer):
                found.append(prim)
                walk.PruneChildren()
        if not found:
            return
        if any(_own(prim) for prim in found):
            continue
        for prim in found:
            left -= _expand(stage, name, prim, left)


def _expand(stage: Usd.Stage, name: str, prim: Usd.Prim, most: int) -> int:
    """Put copies of the prototypes in an instancer's place; returns how many."""
    instancer = UsdGeom.PointInstancer(prim)
    indices = instancer.GetProtoIndicesAttr().Get() or []
    prototypes = instancer.GetPrototypesRel().GetForwardedTargets()
    matrices = instancer.ComputeInstanceTransformsAtTime(
        Usd.TimeCode.Default(),
        Usd.TimeCode.Default(),
        UsdGeom.PointInstancer.ExcludeProtoXform,
        UsdGeom.PointInstancer.IgnoreMask,
    )
    mask = instancer.ComputeMaskAtTime(Usd.TimeCode.Default())
    path = str(prim.GetPath())
    if len(indices) > most:
        raise UsdImportError(name, path, "protoIndices", f"more than {MAX_INSTANCES} point instances on the stage")
    if len(matrices) != len(indices):
        raise UsdImportError(name, path, "positions", "positions and protoIndices differ in length")
    frame = UsdGeom.Xformable(prim).GetLocalTransformation()
    bindings = [r for r in prim.GetRelationships() if r.GetName().startswith("material:binding") and r.GetTargets()]
    for i, (index, matrix) in enumerate(zip(indices, matrices, strict=True)):
        if mask and not mask[i]:
            continue
        if not 0 <= index < len(prototypes):
            raise UsdImportError(name, path, "protoIndices", f"no prototype {index}")
        holder = UsdGeom.Xform.Define(stage, prim.GetParent().GetPath().AppendChild(f"{prim.GetName()}_{i}"))
        holder.AddTransformOp().Set(matrix * frame)
        for binding in bindings:
            UsdShade.MaterialBindingAPI.Apply(holder.GetPrim())
            copy = holder.GetPrim().CreateRelationship(binding.GetName())
            copy.SetTargets(binding.GetTargets())
            for key, value in binding.GetAllAuthoredMetadata().items():
                if key == "bindMaterialAs":
                    copy.SetMetadata(key, value)
        instance = stage.DefinePrim(holder.GetPath().AppendChild(prototypes[index].name))
        instance.GetReferences().AddInternalReference(prototypes[index])
    prim.SetActive(False)
    return len(indices)

"""Type stubs of OpenUSD's Python modules.

The modules carry no signatures, so names and base classes are read from them, and results are looked up in the tables
below. Arguments are not checked. A test compares the tables with what a stage returns.
"""

from __future__ import annotations

import importlib
import inspect
import keyword
import re

MODULES = ("Ar", "Gf", "Kind", "Sdf", "Tf", "Usd", "UsdGeom", "UsdLux", "UsdPhysics", "UsdShade", "UsdUtils", "Vt")
_HEADER = """# Made by scripts/maintainers/make_stubs.py from usd-core {version}. Do not edit.
from typing import Any, ClassVar

{imports}
"""
# Results by the method's name, where its class has no entry of its own below
PATTERNS = (
    (r"(Get|Create)\w*Attr", "Usd.Attribute"),
    (r"(Get|Create)\w*Rel", "Usd.Relationship"),
    (r"(Get|Create)\w*Input", "UsdShade.Input"),
    (r"(Get|Create)\w*Output", "UsdShade.Output"),
    (r"(Get|Create)\w*Primvar", "UsdGeom.Primvar"),
    (r"Add(Translate|Rotate|Scale|Orient|Transform)\w*Op", "UsdGeom.XformOp"),
    (r"GetPrim", "Usd.Prim"),
    (r"GetPath", "Sdf.Path"),
    (r"GetStage", "Usd.Stage"),
    (r"GetName|GetBaseName|GetNamespace|GetDisplayName|GetDocumentation", "str"),
    (r"GetTargets|GetForwardedTargets", "list[Sdf.Path]"),
    (r"(Is|Has|Can)[A-Z]\w*", "bool"),
)
RESULTS = {
    "Gf.Matrix4d": {
        "ExtractTranslation": "Gf.Vec3d",
        "ExtractRotationMatrix": "Gf.Matrix3d",
        "ExtractRotationQuat": "Gf.Quatd",
        "GetInverse": "Gf.Matrix4d",
        "GetOrthonormalized": "Gf.Matrix4d",
        "RemoveScaleShear": "Gf.Matrix4d",
        "Transform": "Gf.Vec3d",
        "TransformDir": "Gf.Vec3d",
        "GetDeterminant": "float",
        "__mul__": "Gf.Matrix4d",
    },
    "Gf.Quatd": {"GetReal": "float", "GetImaginary": "Gf.Vec3d", "GetNormalized": "Gf.Quatd"},
    "Gf.Quatf": {"GetReal": "float", "GetImaginary": "Gf.Vec3f", "GetNormalized": "Gf.Quatf"},
    "Gf.Quath": {"GetReal": "float", "GetImaginary": "Gf.Vec3h", "GetNormalized": "Gf.Quath"},
    "Sdf.AssetPath": {"path": "str", "resolvedPath": "str", "authoredPath": "str", "evaluatedPath": "str"},
    "Sdf.Layer": {
        "CreateAnonymous": "Sdf.Layer",
        "FindOrOpen": "Sdf.Layer | None",
        "OpenAsAnonymous": "Sdf.Layer | None",
        "ExportToString": "str",
        "Export": "bool",
        "ImportFromString": "bool",
        "ListAllTimeSamples": "list[float]",
        "ListTimeSamplesForPath": "list[float]",
        "SplitIdentifier": "tuple[str, dict[str, str]]",
        "GetCompositionAssetDependencies": "list[str]",
        "GetExternalReferences": "list[str]",
        "anonymous": "bool",
        "identifier": "str",
        "realPath": "str",
        "subLayerPaths": "Any",
    },
    "Sdf.Path": {
        "AppendChild": "Sdf.Path",
        "AppendPath": "Sdf.Path",
        "AppendProperty": "Sdf.Path",
        "GetParentPath": "Sdf.Path",
        "GetPrimPath": "Sdf.Path",
        "GetPrefixes": "list[Sdf.Path]",
        "MakeAbsolutePath": "Sdf.Path",
        "MakeRelativePath": "Sdf.Path",
        "ReplacePrefix": "Sdf.Path",
        "ReplaceName": "Sdf.Path",
        "StripAllVariantSelections": "Sdf.Path",
        "isEmpty": "bool",
        "name": "str",
        "pathElementCount": "int",
        "pathString": "str",
    },
    "Tf.Type": {"FindByName": "Tf.Type", "GetAllDerivedTypes": "list[Tf.Type]", "typeName": "str"},
    "Usd.Attribute": {
        "GetTypeName": "Sdf.ValueTypeName",
        "GetTimeSamples": "list[float]",
        "GetNumTimeSamples": "int",
        "GetResolveInfo": "Usd.ResolveInfo",
        "Set": "bool",
    },
    "Usd.CollectionAPI": {
        "Get": "Usd.CollectionAPI",
        "GetAll": "list[Usd.CollectionAPI]",
        "ComputeMembershipQuery": "Usd.CollectionMembershipQuery",
    },
    "Usd.CollectionMembershipQuery": {"IsPathIncluded": "bool"},
    "Usd.Prim": {
        "GetAllChildren": "list[Usd.Prim]",
        "GetAppliedSchemas": "list[str]",
        "GetAttribute": "Usd.Attribute",
        "GetAttributes": "list[Usd.Attribute]",
        "GetAuthoredAttributes": "list[Usd.Attribute]",
        "GetAuthoredProperties": "list[Usd.Property]",
        "GetAuthoredPropertiesInNamespace": "list[Usd.Property]",
        "GetAuthoredRelationships": "list[Usd.Relationship]",
        "GetChild": "Usd.Prim",
        "GetChildren": "list[Usd.Prim]",
        "GetChildrenNames": "list[str]",
        "GetFilteredChildren": "list[Usd.Prim]",
        "CreateAttribute": "Usd.Attribute",
        "CreateRelationship": "Usd.Relationship",
        "GetParent": "Usd.Prim",
        "GetProperties": "list[Usd.Property]",
        "GetProperty": "Usd.Property",
        "GetPrototype": "Usd.Prim",
        "GetReferences": "Usd.References",
        "GetRelationship": "Usd.Relationship",
        "GetRelationships": "list[Usd.Relationship]",
        "GetTypeName": "str",
        "GetVariantSet": "Usd.VariantSet",
        "GetVariantSets": "Usd.VariantSets",
    },
    "Usd._Iterator": {"__iter__": "Usd.PrimRange._Iterator", "__next__": "Usd.Prim", "GetCurrentPrim": "Usd.Prim"},
    "Usd.PrimRange": {"__iter__": "Usd.PrimRange._Iterator", "AllPrims": "Usd.PrimRange", "Stage": "Usd.PrimRange"},
    "Usd.SchemaRegistry": {
        "GetAPISchemaTypeName": "str",
        "GetConcreteSchemaTypeName": "str",
        "GetSchemaTypeName": "str",
        "GetTypeFromSchemaTypeName": "Tf.Type",
    },
    "Usd.Stage": {
        "CreateInMemory": "Usd.Stage",
        "CreateNew": "Usd.Stage",
        "CreateClassPrim": "Usd.Prim",
        "DefinePrim": "Usd.Prim",
        "ExportToString": "str",
        "GetDefaultPrim": "Usd.Prim",
        "GetEditTarget": "Usd.EditTarget",
        "GetLayerStack": "list[Sdf.Layer]",
        "GetPrimAtPath": "Usd.Prim",
        "GetPseudoRoot": "Usd.Prim",
        "GetRootLayer": "Sdf.Layer",
        "GetSessionLayer": "Sdf.Layer",
        "GetUsedLayers": "list[Sdf.Layer]",
        "Flatten": "Sdf.Layer",
        "Open": "Usd.Stage",
        "OverridePrim": "Usd.Prim",
        "Traverse": "Usd.PrimRange",
        "TraverseAll": "Usd.PrimRange",
    },
    "Usd.VariantSet": {"GetVariantNames": "list[str]", "GetVariantSelection": "str", "SetVariantSelection": "bool"},
    "Usd.VariantSets": {
        "AddVariantSet": "Usd.VariantSet",
        "GetNames": "list[str]",
        "GetVariantSelection": "str",
        "GetVariantSet": "Usd.VariantSet",
    },
    "UsdGeom.Imageable": {
        "ComputePurpose": "str",
        "ComputeVisibility": "str",
        "ComputeLocalToWorldTransform": "Gf.Matrix4d",
    },
    "UsdGeom.PrimvarsAPI": {
        "FindPrimvarWithInheritance": "UsdGeom.Primvar",
        "GetPrimvarsWithAuthoredValues": "list[UsdGeom.Primvar]",
    },
    "UsdGeom.Subset": {"GetAllGeomSubsets": "list[UsdGeom.Subset]"},
    "UsdGeom.XformCache": {
        "GetLocalToWorldTransform": "Gf.Matrix4d",
        "GetLocalTransformation": "tuple[Gf.Matrix4d, bool]",
    },
    "UsdGeom.Xformable": {"GetLocalTransformation": "Gf.Matrix4d", "GetOrderedXformOps": "list[UsdGeom.XformOp]"},
    "UsdShade.Material": {
        "ComputeSurfaceSource": "tuple[UsdShade.Shader, str, Any]",
        "GetSurfaceOutputs": "list[UsdShade.Output]",
    },
    "UsdShade.MaterialBindingAPI": {"ComputeBoundMaterial": "tuple[UsdShade.Material, Usd.Relationship]"},
    "UsdShade.Shader": {"GetSourceAsset": "Sdf.AssetPath | None"},
}
FUNCTIONS = {
    "Ar.GetResolver": "Ar.Resolver",
    "Sdf.ComputeAssetPathRelativeToLayer": "str",
    "Sdf.CreatePrimInLayer": "Sdf.PrimSpec",
    "UsdGeom.GetStageMetersPerUnit": "float",
    "UsdGeom.GetStageUpAxis": "str",
    "UsdPhysics.GetStageKilogramsPerUnit": "float",
    "UsdUtils.CreateNewUsdzPackage": "bool",
}
_CLASS_RESULTS = ("Apply", "Define", "Get")  # static methods of schema classes that return the class
_NOT_WRITTEN = re.compile(
    r"__(?!init__|getitem__|setitem__|len__|iter__|next__|enter__|exit__|call__|contains__|\w*(add|sub|mul|div|neg)__)"
)


def stubs(used: set[tuple[str, ...]]) -> dict[str, str]:
    """Text of each stub file by its path below the folder of stubs.

    Args:
        used: names of USD's modules that the code uses, e.g. ``("Usd", "Prim")``.
    """
    from pxr import Usd

    version = ".".join(map(str, Usd.GetVersion()[1:]))
    modules = {name: importlib.import_module(f"pxr.{name}") for name in MODULES}
    due = [chain for chain in sorted(used) if chain[1] in vars(modules[chain[0]])]
    texts: dict[tuple[str, ...], str] = {}
    while due:
        module, name = due.pop()
        if (module, name) not in texts:
            texts[module, name] = text = _stub_of(module, name, vars(modules[module])[name])
            due += [
                found for found in re.findall(r"\b(\w+)\.(\w+)", text) if found[1] in vars(modules.get(found[0], re))
            ]
    files = {"pxr-stubs/py.typed": "partial\n"}
    for module in MODULES:
        body = "".join(text for (owner, _), text in sorted(texts.items()) if owner == module)
        others = sorted(set(re.findall(r"\b(\w+)\.\w", body)) & set(MODULES) - {module})
        imports = f"from pxr import {', '.join(others)}\n" if others else ""
        if body:
            text = _HEADER.format(version=version, imports=imports) + re.sub(rf"\b{module}\.(?=\w)", "", body)
            files[f"pxr-stubs/{module}/__init__.pyi"] = text
    return files


def _stub_of(module: str, name: str, value: object) -> str:
    if isinstance(value, type):
        return _class(module, name, value)
    if callable(value):
        return f"def {name}(*args: Any, **kwargs: Any) -> {FUNCTIONS.get(f'{module}.{name}', 'Any')}: ...\n"
    return f"{name}: {_type_of(value)}\n"


def _class(module: str, name: str, cls: type, outer: str = "") -> str:
    own = f"{outer}{name}"
    bases = [f"{_module_of(base)}.{base.__name__}" for base in cls.__bases__ if _module_of(base) in MODULES]
    if not bases and issubclass(cls, Exception):
        bases = ["Exception"]
    table = {key: result for base in reversed(cls.__mro__) for key, result in _table(base).items()}
    lines = []
    for key in sorted(vars(cls)):
        value = inspect.getattr_static(cls, key)
        if keyword.iskeyword(key) or _NOT_WRITTEN.match(key):
            continue
        if isinstance(value, type):
            if value.__module__ == cls.__module__ and value is not cls:
                lines += [f"    {line}\n" for line in _class(module, key, value, f"{own}.").splitlines()]
        elif key.startswith("_") and not key.startswith("__"):
            continue
        elif isinstance(value, property):
            lines.append(f"    {key}: {table.get(key, 'Any')}\n")
        elif isinstance(value, staticmethod):
            result = table.get(key) or (f"{module}.{own}" if key in _CLASS_RESULTS else _by_pattern(key))
            lines.append(f"    @staticmethod\n    def {key}(*args: Any, **kwargs: Any) -> {result}: ...\n")
        elif callable(value):
            result = "None" if key == "__init__" else table.get(key) or _by_pattern(key)
            lines.append(f"    def {key}(self, *args: Any, **kwargs: Any) -> {result}: ...\n")
        else:
            lines.append(f"    {key}: ClassVar[{_type_of(value)}]\n")
    head = f"class {name}({', '.join(bases)}):" if bases else f"class {name}:"
    return f"{head}\n{''.join(lines) or '    ...'}\n"


def _table(cls: type) -> dict[str, str]:
    return RESULTS.get(f"{_module_of(cls)}.{cls.__name__}", {})


def _by_pattern(name: str) -> str:
    return next((result for pattern, result in PATTERNS if re.fullmatch(pattern, name)), "Any")


def _module_of(cls: type) -> str:
    return cls.__module__.removeprefix("pxr.")


def _type_of(value: object) -> str:
    cls = type(value)
    if cls in (str, int, float, bool):
        return cls.__name__
    if _module_of(cls) in MODULES and getattr(importlib.import_module(cls.__module__), cls.__name__, None) is cls:
        return f"{_module_of(cls)}.{cls.__name__}"
    return "Any"

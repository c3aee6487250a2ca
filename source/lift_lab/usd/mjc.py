"""MjcPhysics elements: options, actuators, tendons and keyframes, field by field as in MJCF (SI units, radians)."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from pxr import Usd

from lift_lab.usd.names import Names
from lift_lab.usd.parse import ParsedStage, targets_of, value_of
from lift_lab.usd.report import OptionSource

_LIMITED = {
    "true": mujoco.mjtLimited.mjLIMITED_TRUE,
    "false": mujoco.mjtLimited.mjLIMITED_FALSE,
    "auto": mujoco.mjtLimited.mjLIMITED_AUTO,
}
_ENUMS = {
    "cone": {"pyramidal": mujoco.mjtCone.mjCONE_PYRAMIDAL, "elliptic": mujoco.mjtCone.mjCONE_ELLIPTIC},
    "jacobian": {
        "dense": mujoco.mjtJacobian.mjJAC_DENSE,
        "sparse": mujoco.mjtJacobian.mjJAC_SPARSE,
        "auto": mujoco.mjtJacobian.mjJAC_AUTO,
    },
    "solver": {
        "pgs": mujoco.mjtSolver.mjSOL_PGS,
        "cg": mujoco.mjtSolver.mjSOL_CG,
        "newton": mujoco.mjtSolver.mjSOL_NEWTON,
    },
    "integrator": {
        "euler": mujoco.mjtIntegrator.mjINT_EULER,
        "rk4": mujoco.mjtIntegrator.mjINT_RK4,
        "implicit": mujoco.mjtIntegrator.mjINT_IMPLICIT,
        "implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    },
}
_OPTION_NAMES = """
timestep tolerance ls_tolerance noslip_tolerance ccd_tolerance density viscosity impratio iterations
ls_iterations noslip_iterations ccd_iterations sdf_iterations sdf_initpoints o_margin magnetic wind o_solref
o_solimp o_friction
"""
_OPTIONS = tuple(_OPTION_NAMES.split())
_POSITIVE = {"timestep", "impratio"}
_SIGNED = {"o_margin", "magnetic", "wind", "o_solref", "o_solimp", "o_friction"}
_ENABLED_BY_FLAG = {"override", "energy", "fwdinv", "invdiscrete", "multiccd", "sleep"}
_GAIN = {
    "fixed": mujoco.mjtGain.mjGAIN_FIXED,
    "affine": mujoco.mjtGain.mjGAIN_AFFINE,
    "muscle": mujoco.mjtGain.mjGAIN_MUSCLE,
    "user": mujoco.mjtGain.mjGAIN_USER,
}
_BIAS = {
    "none": mujoco.mjtBias.mjBIAS_NONE,
    "affine": mujoco.mjtBias.mjBIAS_AFFINE,
    "muscle": mujoco.mjtBias.mjBIAS_MUSCLE,
    "user": mujoco.mjtBias.mjBIAS_USER,
}
_DYNAMICS = {
    "none": mujoco.mjtDyn.mjDYN_NONE,
    "integrator": mujoco.mjtDyn.mjDYN_INTEGRATOR,
    "filter": mujoco.mjtDyn.mjDYN_FILTER,
    "filterexact": mujoco.mjtDyn.mjDYN_FILTEREXACT,
    "muscle": mujoco.mjtDyn.mjDYN_MUSCLE,
    "user": mujoco.mjtDyn.mjDYN_USER,
}


def _choice(parsed: ParsedStage, prim: Usd.Prim, name: str, choices: dict[str, Any]) -> Any:
    value = value_of(prim, name)
    if value is None:
        return None
    if str(value) not in choices:
        raise parsed.fail(prim, name, f"'{value}' is none of {', '.join(choices)}")
    return choices[str(value)]


def _merge(current: Any, value: Any) -> Any:
    """`value` in the shape of `current`: a vector keeps its length, a scalar its type."""
    if np.ndim(current) == 0:
        return type(current)(value)
    merged = np.array(current, dtype=float)
    given = np.atleast_1d(np.asarray(value, dtype=float))[: len(merged)]
    merged[: len(given)] = given
    return merged


def _copy(prim: Usd.Prim, element: Any, fields: dict[str, str]) -> None:
    """Copy authored attributes to fields of a spec element."""
    for attribute, name in fields.items():
        value = value_of(prim, attribute)
        if value is not None:
            setattr(element, name, _merge(getattr(element, name), value))


def _range(parsed: ParsedStage, prim: Usd.Prim, key: str, element: Any, field: str, limited: str, flag: str) -> None:
    ends = [value_of(prim, f"mjc:{key}:{end}") for end in ("min", "max")]
    if any(end is not None for end in ends):
        low, high = (float(end or 0.0) for end in ends)
        if low > high:
            raise parsed.fail(prim, f"mjc:{key}:min", f"must not be above mjc:{key}:max, {low:g} > {high:g}")
        setattr(element, field, [low, high])
    choice = _choice(parsed, prim, f"mjc:{limited}", _LIMITED) if limited else None
    if choice is not None and flag:
        setattr(element, flag, choice)


def read_options(parsed: ParsedStage, prim: Usd.Prim, spec: mujoco.MjSpec) -> None:
    """MjcSceneAPI: mjc:option:* and mjc:flag:*."""
    path, options = str(prim.GetPath()), parsed.report.options
    for name in _OPTIONS:
        value = None if name in _SIGNED else value_of(prim, f"mjc:option:{name}")
        if value is not None and (value < 0 or (value == 0 and name in _POSITIVE)):
            wanted = "must be above zero" if name in _POSITIVE else "must not be negative"
            raise parsed.fail(prim, f"mjc:option:{name}", f"{wanted}, is {value:g}")
    _copy(prim, spec.option, {f"mjc:option:{name}": name for name in _OPTIONS})
    for name, choices in _ENUMS.items():
        value = _choice(parsed, prim, f"mjc:option:{name}", choices)
        if value is not None:
            setattr(spec.option, name, value)
    for name in (*_OPTIONS, *_ENUMS):
        if value_of(prim, f"mjc:option:{name}") is not None:
            options.append(OptionSource(path, f"mjc:option:{name}", name))
    for attribute in prim.GetAuthoredPropertiesInNamespace("mjc:flag"):
        name, value = attribute.GetName().split(":")[-1], value_of(prim, attribute.GetName())
        if name == "gravity" or value is None:
            continue
        enables = name in _ENABLED_BY_FLAG
        bits = mujoco.mjtEnableBit if enables else mujoco.mjtDisableBit
        bit = getattr(bits, f"mj{'ENBL' if enables else 'DSBL'}_{name.upper()}", None)
        if bit is None:
            parsed.report.ignore(prim.GetPath(), attribute.GetName(), "no such flag in this MuJoCo")
            continue
        field = "enableflags" if enables else "disableflags"
        current = int(getattr(spec.option, field))
        setattr(spec.option, field, current | int(bit) if bool(value) == enables else current & ~int(bit))
        options.append(OptionSource(path, attribute.GetName(), field, int(bit)))


def add_elements(parsed: ParsedStage, spec: mujoco.MjSpec, names: Names) -> None:
    """MjcTendon and MjcActuator prims."""
    for kind, add in (("MjcTendon", _add_tendon), ("MjcActuator", _add_actuator)):
        for prim in parsed.prims:
            if str(prim.GetTypeName()) == kind:
                add(parsed, spec, names, prim)


def _named(parsed: ParsedStage, names: Names, prim: Usd.Prim, relationship: str, *kinds: str) -> tuple[str, str] | None:
    """Kind and name of the element that a relationship's first target became."""
    targets = targets_of(prim, relationship)
    if not targets:
        return None
    for kind in kinds:
        name = names.find(kind, targets[0])
        if name:
            return kind, name
    raise parsed.fail(prim, relationship, f"<{targets[0]}> is no {' or '.join(kinds)} of the model")


_TRANSMISSION = {
    "joint": mujoco.mjtTrn.mjTRN_JOINT,
    "tendon": mujoco.mjtTrn.mjTRN_TENDON,
    "site": mujoco.mjtTrn.mjTRN_SITE,
    "body": mujoco.mjtTrn.mjTRN_BODY,
}


def _add_actuator(parsed: ParsedStage, spec: mujoco.MjSpec, names: Names, prim: Usd.Prim) -> None:
    found = _named(parsed, names, prim, "mjc:target", *_TRANSMISSION)
    if found is None:
        parsed.report.ignore(prim.GetPath(), "mjc:target", "an actuator without a target")
        return
    if len(targets_of(prim, "mjc:target")) > 1:
        parsed.report.ignore(prim.GetPath(), "mjc:target", "an actuator drives its first target only")
    kind, target = found
    actuator = spec.add_actuator(name=names.of("actuator", str(prim.GetPath())), target=target)
    actuator.trntype = _TRANSMISSION[kind]
    if kind == "joint" and value_of(prim, "mjc:jointInParent"):
        actuator.trntype = mujoco.mjtTrn.mjTRN_JOINTINPARENT
    slider = _named(parsed, names, prim, "mjc:sliderSite", "site")
    if slider:
        actuator.trntype, actuator.slidersite = mujoco.mjtTrn.mjTRN_SLIDERCRANK, slider[1]
    reference = _named(parsed, names, prim, "mjc:refSite", "site")
    if reference:
        actuator.refsite = reference[1]
    for attribute, field, choices in (
        ("mjc:gainType", "gaintype", _GAIN),
        ("mjc:biasType", "biastype", _BIAS),
        ("mjc:dynType", "dyntype", _DYNAMICS),
    ):
        value = _choice(parsed, prim, attribute, choices)
        if value is not None:
            setattr(actuator, field, value)
    _copy(
        prim,
        actuator,
        {
            "mjc:gainPrm": "gainprm",
            "mjc:biasPrm": "biasprm",
            "mjc:dynPrm": "dynprm",
            "mjc:gear": "gear",
            "mjc:crankLength": "cranklength",
            "mjc:actDim": "actdim",
            "mjc:actEarly": "actearly",
            "mjc:group": "group",
            "mjc:inheritRange": "inheritrange",
        },
    )
    for key, field, limited, flag in (
        ("ctrlRange", "ctrlrange", "ctrlLimited", "ctrllimited"),
        ("forceRange", "forcerange", "forceLimited", "forcelimited"),
        ("actRange", "actrange", "actLimited", "actlimited"),
        ("lengthRange", "lengthrange", "", ""),
    ):
        _range(parsed, prim, key, actuator, field, limited, flag)


def _add_tendon(parsed: ParsedStage, spec: mujoco.MjSpec, names: Names, prim: Usd.Prim) -> None:
    path = str(prim.GetPath())
    targets = targets_of(prim, "mjc:path")
    if not targets:
        raise parsed.fail(prim, "mjc:path", "a tendon needs a path")
    tendon = spec.add_tendon(name=names.of("tendon", path))
    order = [int(i) for i in value_of(prim, "mjc:path:indices") or range(len(targets))]
    if any(not 0 <= i < len(targets) for i in order):
        raise parsed.fail(prim, "mjc:path:indices", f"an index is outside 0..{len(targets) - 1}")
    if str(value_of(prim, "mjc:type") or "spatial") == "fixed":
        _wrap_joints(parsed, names, prim, tendon, targets, order)
    else:
        _wrap_sites(parsed, names, prim, tendon, targets, order)
    _copy(
        prim,
        tendon,
        {
            "mjc:stiffness": "stiffness",
            "mjc:damping": "damping",
            "mjc:frictionloss": "frictionloss",
            "mjc:armature": "armature",
            "mjc:margin": "margin",
            "mjc:width": "width",
            "mjc:group": "group",
            "mjc:rgba": "rgba",
            "mjc:springlength": "springlength",
            "mjc:solreflimit": "solref_limit",
            "mjc:solimplimit": "solimp_limit",
            "mjc:solreffriction": "solref_friction",
            "mjc:solimpfriction": "solimp_friction",
        },
    )
    lengths = value_of(prim, "mjc:springlength")
    if lengths is not None and len(lengths) == 1:
        tendon.springlength = [float(lengths[0])] * 2
    _range(parsed, prim, "range", tendon, "range", "limited", "limited")
    _range(parsed, prim, "actuatorfrcrange", tendon, "actfrcrange", "actuatorfrclimited", "actfrclimited")


def _wrap_joints(
    parsed: ParsedStage, names: Names, prim: Usd.Prim, tendon: Any, targets: list[str], order: list[int]
) -> None:
    coefficients = [float(c) for c in value_of(prim, "mjc:path:coef") or []]
    for position, i in enumerate(order):
        name = names.find("joint", targets[i])
        if name is None:
            raise parsed.fail(prim, "mjc:path", f"<{targets[i]}> is no joint of the model")
        tendon.wrap_joint(name, coefficients[position] if position < len(coefficients) else 1.0)


def _wrap_sites(
    parsed: ParsedStage, names: Names, prim: Usd.Prim, tendon: Any, targets: list[str], order: list[int]
) -> None:
    segments = [int(s) for s in value_of(prim, "mjc:path:segments") or []]
    divisors = [float(d) for d in value_of(prim, "mjc:path:divisors") or []]
    sides = targets_of(prim, "mjc:sideSites")
    side_of = [int(i) for i in value_of(prim, "mjc:sideSites:indices") or []]
    segment = segments[0] if segments else 0
    if divisors and divisors[0] != 1.0:
        tendon.wrap_pulley(divisors[0])
    for position, i in enumerate(order):
        now = segments[position] if position < len(segments) else segment
        if now != segment:
            segment = now
            tendon.wrap_pulley(divisors[segment] if 0 <= segment < len(divisors) else 1.0)
        site, geom = names.find("site", targets[i]), names.find("geom", targets[i])
        if site:
            tendon.wrap_site(site)
        elif geom:
            side = side_of[i] if i < len(side_of) else -1
            beside = names.find("site", sides[side]) if 0 <= side < len(sides) else None
            tendon.wrap_geom(geom, beside or "")
        else:
            raise parsed.fail(prim, "mjc:path", f"<{targets[i]}> is neither site nor geom of the model")


def add_keyframes(parsed: ParsedStage, spec: mujoco.MjSpec, names: Names) -> None:
    """MjcKeyframe prims; one whose length does not fit the model is reported and left out."""
    prims = [prim for prim in parsed.prims if str(prim.GetTypeName()) == "MjcKeyframe"]
    if not prims:
        return
    model = spec.compile()
    sizes = {
        "qpos": model.nq,
        "qvel": model.nv,
        "ctrl": model.nu,
        "act": model.na,
        "mpos": 3 * model.nmocap,
        "mquat": 4 * model.nmocap,
    }
    for prim in prims:
        values = {name: value_of(prim, f"mjc:{name}") for name in sizes}
        given: dict[str, Any] = {
            name: [float(v) for v in value] for name, value in values.items() if value is not None and len(value)
        }
        wrong = [name for name, value in given.items() if len(value) != sizes[name]]
        if wrong:
            reason = f"{len(given[wrong[0]])} values where the model has {sizes[wrong[0]]}"
            parsed.report.ignore(prim.GetPath(), f"mjc:{wrong[0]}", reason)
            continue
        name = names.of("key", str(prim.GetPath()))
        spec.add_key(name=name, **given)
        parsed.report.keyframes[name] = str(prim.GetPath())

"""What one importer makes of USD stages, as plain numbers; usd_compare.py runs it where there may be no lift_lab.

Arguments: the importer (lift_lab, mujoco-usd or newton), a JSON file with paths, the file to append answers to. An
answer is written before the next stage begins, so that one that ends the interpreter costs only its own.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path


def _leaf(path):
    return str(path).rsplit("/", 1)[-1]


def _eigenvalues(tensor):
    import numpy as np

    return sorted(float(v) for v in np.linalg.eigvalsh(np.array(tensor, dtype=float).reshape(3, 3)))


def of_mujoco(model):
    """Numbers of a MuJoCo model, names without the path that some importers keep in them."""
    import mujoco
    import numpy as np

    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    kinds = {0: "free", 1: "ball", 2: "slide", 3: "hinge"}
    answer = {"gravity": model.opt.gravity.tolist(), "bodies": {}, "joints": {}, "shapes": {}, "free": []}
    for i in range(1, model.nbody):
        answer["bodies"][_leaf(model.body(i).name)] = {
            "mass": float(model.body_mass[i]),
            "com": model.body_ipos[i].tolist(),
            "inertia": sorted(model.body_inertia[i].tolist()),
            "pos": data.xpos[i].tolist(),
            "parent": _leaf(model.body(model.body_parentid[i]).name),
            "dofs": int(model.body_dofnum[i]),
            "weightless": bool(model.body_gravcomp[i] == 1.0),
            "driven": bool(model.body_mocapid[i] >= 0 or model.body_weldid[i] == 0),
        }
    for j in range(model.njnt):
        name, dof = _leaf(model.joint(j).name), model.jnt_dofadr[j]
        if model.jnt_type[j] == 0:
            answer["free"].append(_leaf(model.body(model.jnt_bodyid[j]).name))
            continue
        acting = [a for a in range(model.nu) if model.actuator_trnid[a, 0] == j and model.actuator_trntype[a] == 0]
        limits = model.jnt_range[j].tolist() if model.jnt_limited[j] else None
        effort = model.jnt_actfrcrange[j, 1] if model.jnt_actfrclimited[j] else None
        if effort is None and acting and model.actuator_forcelimited[acting[0]]:
            effort = model.actuator_forcerange[acting[0], 1]
        answer["joints"][name] = {
            "kind": kinds[int(model.jnt_type[j])],
            "limits": limits,
            "kp": float(-model.actuator_biasprm[acting[0], 1]) if acting else 0.0,
            "kv": float(-sum(model.actuator_biasprm[a, 2] for a in acting)),
            "effort": None if effort is None else float(effort),
            "armature": float(model.dof_armature[dof]),
            "friction": float(model.dof_frictionloss[dof]),
            "damping": float(np.ravel(model.dof_damping[dof])[0]),
        }
    joint_equality = int(mujoco.mjtEq.mjEQ_JOINT)
    answer["mimics"] = {
        _leaf(model.joint(model.eq_obj1id[i]).name): model.eq_data[i, :2].tolist()
        for i in range(model.neq)
        if model.eq_type[i] == joint_equality
    }
    closing = (int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD))
    answer["loops"] = any(int(kind) in closing for kind in model.eq_type)
    colliding = set()
    excluded = {int(s) for s in model.exclude_signature}
    for a in range(model.ngeom):
        for b in range(a + 1, model.ngeom):
            one, two = int(model.geom_bodyid[a]), int(model.geom_bodyid[b])
            types, affinities = model.geom_contype[[a, b]], model.geom_conaffinity[[b, a]]
            masks = bool((types & affinities).any())
            weld = model.body_weldid
            family = (model.body_parentid[weld[one]], model.body_parentid[weld[two]])
            related = weld[one] and weld[two] and (weld[family[0]] == weld[two] or weld[family[1]] == weld[one])
            barred = {(one << 16) + two, (two << 16) + one} & excluded
            if masks and weld[one] != weld[two] and not related and not barred:
                colliding.add("-".join(sorted(_leaf(model.body(k).name) for k in (one, two))))
    answer["colliding"] = sorted(colliding)
    solid = {0: "plane", 2: "sphere", 3: "capsule", 4: "ellipsoid", 5: "cylinder", 6: "box", 7: "mesh"}
    for g in range(model.ngeom):
        answer["shapes"][_leaf(model.geom(g).name)] = {
            "kind": solid.get(int(model.geom_type[g]), "other"),
            "size": model.geom_size[g].tolist(),
            "friction": model.geom_friction[g].tolist(),
            "solid": bool(model.geom_contype[g] or model.geom_conaffinity[g]),
            "color": model.geom_rgba[g, :3].tolist(),
        }
    answer["sites"], answer["cameras"] = int(model.nsite), int(model.ncam)
    answer["tendons"], answer["actuators"] = int(model.ntendon), int(model.nu)
    return answer


def with_lift_lab(path):
    """This project's importer."""
    from lift_lab.usd import load

    spec, report = load(path)
    answer = of_mujoco(spec.compile())
    for name, limit in report.joint_velocity_limits.items():
        answer["joints"][name]["speed"] = limit
    return answer


def with_mujoco_usd(path):
    """MuJoCo's own decoder."""
    import mujoco
    import mujoco._usd  # pyright: ignore[reportMissingImports]  # registers the decoder

    return of_mujoco(mujoco.MjSpec.from_file(path).compile())


def with_newton(path):
    """Newton's builder, before any of its solvers."""
    import newton  # pyright: ignore[reportMissingImports]
    import numpy as np

    builder = newton.ModelBuilder()
    newton.solvers.SolverMuJoCo.register_custom_attributes(builder)
    dialects = (newton.usd.SchemaResolverNewton, newton.usd.SchemaResolverPhysx, newton.usd.SchemaResolverMjc)
    builder.add_usd(path, skip_mesh_approximation=True, schema_resolvers=[dialect() for dialect in dialects])
    kinds = {"REVOLUTE": "hinge", "PRISMATIC": "slide", "BALL": "ball", "FREE": "free", "FIXED": "fixed", "D6": "d6"}
    labels = [_leaf(label) for label in builder.body_label]
    up = np.array(newton.Axis.from_any(builder.up_axis).to_vector(), dtype=float)
    gravity = np.array(builder.gravity, dtype=float)
    answer = {"gravity": (gravity if gravity.ndim else up * gravity).tolist()}
    answer["bodies"] = {
        name: {
            "mass": float(builder.body_mass[i]),
            "com": [float(v) for v in builder.body_com[i]],
            "inertia": _eigenvalues(builder.body_inertia[i]),
            "pos": [float(v) for v in builder.body_q[i][:3]],
            "parent": "world",
            "dofs": 0,
            "weightless": False,
            "driven": bool(builder.body_flags[i] & int(newton.BodyFlags.KINEMATIC)),
        }
        for i, name in enumerate(labels)
    }
    answer.update({"joints": {}, "free": [], "shapes": {}, "loops": False, "mimics": {}})
    starts = [*builder.joint_qd_start, builder.joint_dof_count]
    jointed = set()
    for i in range(builder.joint_count):
        kind = newton.JointType(builder.joint_type[i]).name
        child, parent = builder.joint_child[i], builder.joint_parent[i]
        body, width = answer["bodies"][labels[child]], starts[i + 1] - starts[i]
        if kind == "FREE":
            answer["free"].append(labels[child])
            body["dofs"] += 6
            continue
        if child in jointed:
            answer["loops"] = True
        else:
            body["parent"] = "world" if parent < 0 else labels[parent]
            body["dofs"] += width
        jointed.add(child)
        if not width:
            continue
        d = starts[i]
        limits = [float(builder.joint_limit_lower[d]), float(builder.joint_limit_upper[d])]
        answer["joints"][_leaf(builder.joint_label[i])] = {
            "kind": kinds.get(kind, kind),
            "limits": limits if max(map(abs, limits)) < 1e9 else None,
            "kp": float(builder.joint_target_ke[d]),
            "kv": float(builder.joint_target_kd[d]),
            "effort": float(builder.joint_effort_limit[d]),
            "armature": float(builder.joint_armature[d]),
            "friction": float(builder.joint_friction[d]),
            "damping": float(builder.joint_damping[d]),
            "speed": float(builder.joint_velocity_limit[d]),
        }
    for follower, leader in enumerate(builder.joint_mimic_joint):
        if leader >= 0:
            coefficients = [float(c) for c in builder.joint_mimic_coeffs[follower]]
            answer["mimics"][_leaf(builder.joint_label[follower])] = coefficients
    filtered = {tuple(sorted(pair)) for pair in builder.shape_collision_filter_pairs}
    collides = int(newton.ShapeFlags.COLLIDE_SHAPES)
    colliding = set()
    for a in range(builder.shape_count):
        for b in range(a + 1, builder.shape_count):
            one, two = builder.shape_body[a], builder.shape_body[b]
            ga, gb = builder.shape_collision_group[a], builder.shape_collision_group[b]
            grouped = ga and gb and (ga == gb if ga > 0 and gb > 0 else ga != gb or ga < 0)
            solid = builder.shape_flags[a] & collides and builder.shape_flags[b] & collides
            if solid and grouped and one != two and (a, b) not in filtered:
                colliding.add("-".join(sorted("world" if k < 0 else labels[k] for k in (one, two))))
    answer["colliding"] = sorted(colliding)
    for i in range(builder.shape_count):
        kind = newton.GeoType(builder.shape_type[i]).name.lower()
        answer["shapes"][_leaf(builder.shape_label[i])] = {
            "kind": {"convex_mesh": "mesh"}.get(kind, kind),
            "size": [float(v) for v in builder.shape_scale[i]],
            "friction": [float(builder.shape_material_mu[i])],
            "solid": bool(builder.shape_flags[i] & collides),
            "color": [float(v) for v in (builder.shape_color[i] if hasattr(builder, "shape_color") else (-1, -1, -1))],
        }
    sites = int(newton.ShapeFlags.SITE)
    answer["sites"] = sum(bool(flags & sites) for flags in builder.shape_flags)
    answer["cameras"] = answer["tendons"] = answer["actuators"] = 0
    custom = getattr(builder, "custom_attributes", {})
    for name, key in (("tendons", "tendon_joint_num"), ("actuators", "actuator_trntype")):
        values = next((a.values for k, a in custom.items() if k.endswith(key)), None)
        answer[name] = len(values) if values else 0
    return answer


IMPORTERS = {"lift_lab": with_lift_lab, "mujoco-usd": with_mujoco_usd, "newton": with_newton}


def main():
    importer, asked, answered = sys.argv[1:]
    for path in json.loads(Path(asked).read_text()):
        try:
            answer = IMPORTERS[importer](path)
        except Exception as error:  # whatever an importer raises is its answer
            answer = {"error": f"{type(error).__name__}: {error}".splitlines()[0]}
        with Path(answered).open("a") as out:
            out.write(json.dumps([path, answer]) + "\n")


if __name__ == "__main__":
    main()

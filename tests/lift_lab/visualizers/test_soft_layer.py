"""The surface of a soft body in a browser follows its nodes as MuJoCo's does."""

from types import SimpleNamespace

import mujoco
import numpy as np
import torch

from lift_lab.visualizers.soft_layer import SoftLayer, SoftSurface


def soft_model() -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
    flex = spec.worldbody.make_flex(
        name="jelly", type="grid", dof="trilinear", dim=3, count=[3, 3, 3], spacing=[0.01, 0.02, 0.03], mass=0.1
    )
    flex.young, flex.poisson, flex.damping, flex.rgba = 5e4, 0.3, 0.005, [0.1, 0.2, 0.3, 1.0]
    return spec.compile()


def bent(model: mujoco.MjModel, seed: int) -> mujoco.MjData:
    data = mujoco.MjData(model)
    data.qpos[:] = np.random.default_rng(seed).normal(size=model.nq) * 0.003
    mujoco.mj_kinematics(model, data)
    mujoco.mj_flex(model, data)
    return data


def test_points_between_the_nodes_are_where_mujoco_has_them_and_triangles_face_outwards():
    model = soft_model()
    data, surface = bent(model, 1), SoftSurface(model, 0)
    points = surface.weights @ data.xpos[surface.nodes]
    np.testing.assert_allclose(points, data.flexvert_xpos, atol=1e-12)
    corners = points[surface.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("fk,fk->f", normals, corners.mean(axis=1) - points.mean(axis=0)) > 0).all()
    # a closed surface: every edge belongs to two triangles, once in each direction
    edges = {(f[i], f[(i + 1) % 3]) for f in surface.faces.tolist() for i in range(3)}
    assert len(edges) == 3 * len(surface.faces)
    assert all((b, a) in edges for a, b in edges)


def test_one_mesh_shows_every_environment_at_its_origin():
    model = soft_model()
    datas = [bent(model, seed) for seed in (1, 2)]
    origins = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]], dtype=np.float32)
    physics = SimpleNamespace(model=model, field=lambda _: torch.tensor(np.stack([d.xpos for d in datas])))
    sent = {}

    def add_mesh_simple(name, vertices, faces, **_):
        sent[name] = SimpleNamespace(vertices=vertices, faces=faces)
        return sent[name]

    layer = SoftLayer(SimpleNamespace(scene=SimpleNamespace(add_mesh_simple=add_mesh_simple)), physics, origins)
    mesh = sent["/world/soft/jelly"]
    count = model.nflexvert
    assert mesh.faces.max() == 2 * count - 1
    datas.reverse()
    layer.update()
    for k, data in enumerate(datas):
        expected = data.flexvert_xpos + origins[k]
        np.testing.assert_allclose(mesh.vertices[k * count : (k + 1) * count], expected, atol=1e-6)

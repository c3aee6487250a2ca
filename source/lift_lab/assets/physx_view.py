"""Parts of PhysX's tensor views that Isaac Lab task files use, answered by MuJoCo.

Conventions are PhysX's, not those of ``asset.data``. Quaternions are (x, y, z, w). Masses, inertias, centres of mass
and materials are on the CPU. Their setters take the rows of all environments and write those of ``indices``. Views of
rigid objects have one row for each environment. Those of articulations have bodies in between.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import torch

from lift_lab.sim.ignored import note_ignored
from lift_lab.sim.physics.base import ids_tensor
from lift_lab.utils.attributes import SuggestsAttributes
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.math import convert_quat
from lift_lab.utils.saved_state import Stateless

from .asset_base import as_numbers

if TYPE_CHECKING:
    from .body_asset import BodyAsset

Indices = Sequence[int] | torch.Tensor

_AXES_TOLERANCE = 1e-4
"""Part of a body's largest moment of inertia that its products of inertia may be: what float32 leaves."""


def xyzw_pose(pose: torch.Tensor) -> torch.Tensor:
    """Position and orientation with the real part last, shape (..., 7), of one with the real part first."""
    return torch.cat((pose[..., :3], convert_quat(pose[..., 3:], to="xyzw")), dim=-1)


class RigidBodyView(SuggestsAttributes, Stateless):
    """The view of a rigid object."""

    def __init__(self, asset: BodyAsset):
        """Answer for an asset of a running scene."""
        self._asset = asset
        model = asset.physics.model
        self._shapes = [g for g in asset.engine_geom_ids if model.geom_contype[g] or model.geom_conaffinity[g]]

    def _described(self) -> str:
        return f"root_physx_view of '{self._asset.name}' has"

    @property
    def _bodies_dim(self) -> tuple[int, ...]:
        """Dimensions between environments and numbers: a rigid object has none for its only body."""
        return ()

    def _without_bodies(self, values: torch.Tensor) -> torch.Tensor:
        """Values of shape (num_envs, num_bodies, n) in the view's own shape."""
        return values.reshape(len(values), *self._bodies_dim, values.shape[-1])

    @property
    def count(self) -> int:
        """Number of environments."""
        return self._asset.num_instances

    @property
    def max_shapes(self) -> int:
        """Number of colliders."""
        return len(self._shapes)

    def get_transforms(self) -> torch.Tensor:
        """Pose of the root in the world in m, shape (num_envs, 7)."""
        return xyzw_pose(self._asset.data.root_link_pose_w)

    def get_velocities(self) -> torch.Tensor:
        """Velocity of the root's centre of mass in the world, linear then angular, shape (num_envs, 6)."""
        return self._asset.data.root_com_vel_w.clone()

    def get_masses(self) -> torch.Tensor:
        """Masses in kg, shape (num_envs, 1); of an articulation (num_envs, num_bodies)."""
        return self._asset.get_masses().cpu()

    def set_masses(self, masses: torch.Tensor, indices: Indices) -> None:
        """Set masses in kg, shaped as those of :meth:`get_masses`; inertias stay as they are."""
        rows = self._rows(masses, (self._asset.num_bodies,), indices)
        self._asset.write_body_mass_to_sim(rows, env_ids=self._env_ids(indices), recompute_inertia=False)

    def get_inertias(self) -> torch.Tensor:
        """Inertias about the centres of mass in kg m^2, in the link axes, row by row.

        Shape (num_envs, 9); of an articulation (num_envs, num_bodies, 9).
        """
        asset = self._asset
        principal = asset.physics.randomizable("body_inertia")[:, asset.engine_body_ids].float()
        return self._without_bodies(asset.data.inertia_in_link_axes(principal)).cpu()

    def set_inertias(self, inertias: torch.Tensor, indices: Indices) -> None:
        """Set inertias, shaped as those of :meth:`get_inertias`.

        Raises:
            ConfigError: a matrix that is not positive, or with other principal axes than the body's: those cannot be
                turned.
        """
        asset = self._asset
        rows = self._rows(inertias, (*self._bodies_dim, 9), indices).reshape(-1, asset.num_bodies, 3, 3)
        axes = asset.data.principal_axes_b
        turned = axes.mT @ rows @ axes
        principal = turned.diagonal(dim1=-2, dim2=-1)
        wrong = ~((principal >= 0) & principal.isfinite())
        if wrong.any():
            value = float(principal[wrong][0])
            kind = "negative" if value < 0 else "not finite"
            raise ConfigError(f"{self._owner()}: set_inertias: an inertia is {kind} ({value:g})")
        rest = (turned - torch.diag_embed(principal)).abs().amax(dim=(-2, -1))
        if (rest > _AXES_TOLERANCE * principal.amax(dim=-1)).any():
            raise ConfigError(
                f"{self._owner()}: set_inertias cannot turn principal axes: scale matrices of get_inertias, or give"
                " others that are diagonal in the same axes"
            )
        field = asset.physics.randomizable("body_inertia")
        bodies = torch.tensor(asset.engine_body_ids, device=field.device)
        field[self._env_ids(indices)[:, None], bodies] = principal.to(field)
        asset.physics.recompute_constants()

    def get_coms(self) -> torch.Tensor:
        """Centres of mass and principal axes in the link frames in m.

        Shape (num_envs, 7); of an articulation (num_envs, num_bodies, 7).
        """
        data = self._asset.data
        return self._without_bodies(xyzw_pose(torch.cat((data.body_com_pos_b, data.body_com_quat_b), dim=-1))).cpu()

    def set_coms(self, coms: torch.Tensor, indices: Indices) -> None:
        """Move centres of mass, shaped as those of :meth:`get_coms`; the principal axes stay as they are.

        Raises:
            ConfigError: the axes are turned, or a body's centre of mass cannot move.
        """
        rows = self._rows(coms, (*self._bodies_dim, 7), indices)
        if not torch.allclose(rows[..., 3:], self.get_coms()[0, ..., 3:].to(rows), atol=1e-5):
            raise ConfigError(f"{self._owner()}: set_coms moves centres of mass; it cannot turn principal axes")
        positions = rows[..., :3].reshape(len(rows), self._asset.num_bodies, 3)
        self._asset.write_body_com_to_sim(positions, env_ids=self._env_ids(indices))

    def get_material_properties(self) -> torch.Tensor:
        """Static and dynamic friction, which are one here, and restitution, which is 0, of the colliders.

        Shape (num_envs, max_shapes, 3).
        """
        sliding = self._asset.physics.randomizable("geom_friction")[:, self._shapes, 0].float().cpu()
        return torch.stack((sliding, sliding, torch.zeros_like(sliding)), dim=-1)

    def set_material_properties(self, materials: torch.Tensor, indices: Indices) -> None:
        """Set sliding friction to the static one of shape (num_envs, max_shapes, 3)."""
        rows = self._rows(materials, (self.max_shapes, 3), indices)
        if rows[..., 2].any():
            note_ignored("root_physx_view.set_material_properties: restitution", "MuJoCo has no restitution")
        field = self._asset.physics.randomizable("geom_friction")
        shapes = torch.tensor(self._shapes, device=field.device)
        field[self._env_ids(indices)[:, None], shapes, 0] = rows[..., 0].to(field)

    def _owner(self) -> str:
        return f"'{self._asset.name}'.root_physx_view"

    def _env_ids(self, indices: Indices) -> torch.Tensor:
        return ids_tensor(indices, self._asset.physics.device, self.count).reshape(-1)

    def _rows(self, values: torch.Tensor, shape: tuple[int, ...], indices: Indices) -> torch.Tensor:
        """Rows of ``indices`` of values of all environments, on the device.

        As PhysX asks, the numbers have to fit and not the dimensions, but the first counts the environments or all.
        """
        wanted = (self.count, *shape)
        values = as_numbers(values, self._asset.physics.device, wanted, self._owner())
        if values.numel() != torch.Size(wanted).numel() or (values.ndim > 1 and len(values) != self.count):
            raise ConfigError(
                f"{self._owner()}: expected values of all environments, {wanted}, got {tuple(values.shape)}"
            )
        return values.reshape(wanted)[self._env_ids(indices)]

"""Inertia and gravity of an articulation in joint space."""

from __future__ import annotations

from typing import TYPE_CHECKING

import torch

from lift_lab.utils import math as math_utils
from lift_lab.utils.saved_state import Stateless

if TYPE_CHECKING:
    from .articulation import Articulation


class JointDynamics(Stateless):
    """Inertia and gravity of an articulation in joint space, from the engine's spatial inertias and motion axes."""

    def __init__(self, asset: Articulation, joint_ids: slice | torch.Tensor):
        """Find which joints move which bodies."""
        self._physics = asset.physics
        self._asset = asset
        self._joint_ids = joint_ids
        self._bodies = torch.tensor(asset.engine_body_ids, device=asset.device)
        self._dofs = torch.tensor(asset.engine_dof_ids, device=asset.device)[joint_ids]
        self._moves = asset.physics.moving_dofs[self._bodies[:, None], self._dofs]

    def mass_matrix(self) -> torch.Tensor:
        """Joint-space inertia, shape (num_envs, num_joints, num_joints)."""
        axes = self._axes()
        momentum = torch.einsum("nbfg,nbjg->nbjf", self._spatial_inertia(), axes)
        inertia = torch.einsum("nbif,nbjf->nij", axes, momentum)
        armature = self._asset.data.joint_armature[:, self._joint_ids]
        return inertia + torch.diag_embed(armature)

    def gravity_efforts(self) -> torch.Tensor:
        """Efforts that hold the joints against the gravity that the engine does not compensate itself.

        Shape (num_envs, num_joints).
        """
        inertia = self._physics.current("cinert")[:, self._bodies]
        gravity_w = self._physics.gravity.unsqueeze(1)
        force = inertia[..., 9:10] * gravity_w
        torque = torch.linalg.cross(inertia[..., 6:9], gravity_w.expand_as(force))
        wrench = torch.cat((torque, force), dim=-1)
        pulled = torch.einsum("nbjf,nbf->nj", self._axes(), wrench)
        return -pulled - self._physics.current("qfrc_gravcomp")[:, self._dofs]

    def _axes(self) -> torch.Tensor:
        """Motion (angular, linear) of each body for each joint, shape (num_envs, num_bodies, num_joints, 6)."""
        return self._physics.current("cdof")[:, None, self._dofs] * self._moves[None, :, :, None]

    def _spatial_inertia(self) -> torch.Tensor:
        """Matrices of MuJoCo's ten-number inertias (``mjData.cinert``), shape (num_envs, num_bodies, 6, 6)."""
        packed = self._physics.current("cinert")[:, self._bodies]
        xx, yy, zz, xy, xz, yz = packed[..., :6].unbind(-1)
        rotational = torch.stack((xx, xy, xz, xy, yy, yz, xz, yz, zz), dim=-1).unflatten(-1, (3, 3))
        coupling = math_utils.skew_symmetric_matrix(packed[..., 6:9].reshape(-1, 3)).view_as(rotational)
        mass = packed[..., 9, None, None] * torch.eye(3, device=packed.device)
        top = torch.cat((rotational, coupling), dim=-1)
        bottom = torch.cat((coupling.mT, mass), dim=-1)
        return torch.cat((top, bottom), dim=-2)

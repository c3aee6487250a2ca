"""Those parts of PhysX's articulation view that Isaac Lab task files ask for, answered by MuJoCo."""

from __future__ import annotations

from functools import cached_property
from types import SimpleNamespace
from typing import TYPE_CHECKING

import torch

from lift_lab.utils.errors import ConfigError
from lift_lab.utils.math import skew_symmetric_matrix

from ..physx_view import RigidBodyView, xyzw_pose
from .joint_dynamics import JointDynamics

if TYPE_CHECKING:
    from .articulation import Articulation


class ArticulationView(RigidBodyView):
    """The view of an articulation; conventions are those of :mod:`lift_lab.assets.physx_view`.

    Joints and bodies are in the order of ``asset.joint_names`` and ``asset.body_names``. The root's six degrees of
    freedom, where it is free, come first: linear velocity of its origin, then angular velocity, both in the world.
    """

    _asset: Articulation

    @property
    def _bodies_dim(self) -> tuple[int, ...]:
        return (self._asset.num_bodies,)

    @property
    def max_dofs(self) -> int:
        """Number of joints."""
        return self._asset.num_joints

    @property
    def max_links(self) -> int:
        """Number of bodies."""
        return self._asset.num_bodies

    @property
    def shared_metatype(self) -> SimpleNamespace:
        """Data that all environments share: ``fixed_base``, number and names of links and of degrees of freedom."""
        asset = self._asset
        return SimpleNamespace(
            fixed_base=asset.is_fixed_base,
            link_count=asset.num_bodies,
            link_names=list(asset.body_names),
            dof_count=asset.num_joints,
            dof_names=list(asset.joint_names),
        )

    get_root_transforms = RigidBodyView.get_transforms
    get_root_velocities = RigidBodyView.get_velocities

    def get_link_transforms(self) -> torch.Tensor:
        """Poses of the bodies in the world in m, shape (num_envs, num_bodies, 7)."""
        return xyzw_pose(self._asset.data.body_link_pose_w)

    def get_link_velocities(self) -> torch.Tensor:
        """Velocities of the bodies' centres of mass in the world, shape (num_envs, num_bodies, 6)."""
        return self._asset.data.body_com_vel_w.clone()

    def get_dof_positions(self) -> torch.Tensor:
        """Joint positions in rad or m, shape (num_envs, num_joints)."""
        return self._asset.data.joint_pos.clone()

    def get_dof_velocities(self) -> torch.Tensor:
        """Joint velocities in rad/s or m/s, shape (num_envs, num_joints)."""
        return self._asset.data.joint_vel.clone()

    def get_dof_limits(self) -> torch.Tensor:
        """Lower and upper limits of the joints in rad or m, shape (num_envs, num_joints, 2)."""
        return self._asset.data.joint_pos_limits.cpu().clone()

    def get_dof_max_forces(self) -> torch.Tensor:
        """Effort limits in N m or N, shape (num_envs, num_joints)."""
        return self._asset.data.joint_effort_limits.cpu().clone()

    def get_dof_stiffnesses(self) -> torch.Tensor:
        """Gains on positions, shape (num_envs, num_joints)."""
        return self._asset.data.joint_stiffness.cpu().clone()

    def get_dof_dampings(self) -> torch.Tensor:
        """Gains on velocities, shape (num_envs, num_joints)."""
        return self._asset.data.joint_damping.cpu().clone()

    def get_dof_armatures(self) -> torch.Tensor:
        """Rotor inertias in kg m^2 or kg, shape (num_envs, num_joints)."""
        return self._asset.data.joint_armature.cpu().clone()

    def get_jacobians(self) -> torch.Tensor:
        """Jacobians of the bodies' origins in the world, rows linear then angular.

        Shape (num_envs, num_bodies - 1, 6, num_joints) without the root where that is fixed, else
        (num_envs, num_bodies, 6, 6 + num_joints).
        """
        asset = self._asset
        bodies = range(asset.num_bodies)
        of_joints = torch.stack([asset.get_jacobians(body) for body in bodies], dim=1)
        if asset.is_fixed_base:
            return of_joints[:, 1:]
        arm_w = asset.data.body_link_pos_w - asset.data.root_link_pos_w.unsqueeze(1)
        of_root = torch.eye(6, device=arm_w.device).repeat(*arm_w.shape[:2], 1, 1)
        of_root[..., :3, 3:] = -skew_symmetric_matrix(arm_w)  # a root that turns carries the bodies' origins along
        return torch.cat((of_root, of_joints), dim=-1)

    def get_generalized_mass_matrices(self) -> torch.Tensor:
        """Joint-space inertias, shape (num_envs, num_joints, num_joints).

        Raises:
            ConfigError: the root is free.
        """
        self._check_fixed("get_generalized_mass_matrices")
        return self._dynamics.mass_matrix()

    get_mass_matrices = get_generalized_mass_matrices

    def get_gravity_compensation_forces(self) -> torch.Tensor:
        """Efforts that hold the joints against what gravity the engine does not compensate, (num_envs, num_joints).

        Raises:
            ConfigError: the root is free.
        """
        self._check_fixed("get_gravity_compensation_forces")
        return self._dynamics.gravity_efforts()

    get_generalized_gravity_forces = get_gravity_compensation_forces

    def _check_fixed(self, method: str) -> None:
        if not self._asset.is_fixed_base:
            raise ConfigError(f"{self._owner()}.{method} is for articulations with a fixed root")

    @cached_property
    def _dynamics(self) -> JointDynamics:
        return JointDynamics(self._asset, slice(None))

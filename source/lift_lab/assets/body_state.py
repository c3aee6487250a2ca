"""State of an asset's bodies, read from the engine on demand and kept until the engine moves on.

Poses are of the link frame, velocities of the centre of mass (Isaac Lab's convention); everything in the world
frame (`_w`) includes the environment's origin.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

import torch

from lift_lab.utils import math as math_utils

from .asset_base import as_columns, take_columns
from .asset_data import AssetData, cached

if TYPE_CHECKING:
    from lift_lab.sim.physics.base import Physics


class BodyState(AssetData):
    """Poses and velocities of an asset's root and bodies."""

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset(
        {"_body_cols", "_body_ids", "_body_origins_w", "_iquat_b", "_kept", "_kept_is_aligned", "_mocap"}
        | {"_origins_version", "_origins_w", "_principal_axes_b", "_qadr", "_root_body", "_root_stands"}
        | {"_tree_root", "_vadr", "body_names"}
    )

    def __init__(
        self,
        physics: Physics,
        env_origins_w: torch.Tensor,
        body_ids: list[int],
        body_names: list[str],
        free_qpos_adr: int | None,
        free_dof_adr: int | None,
        mocap_id: int | None,
    ):
        self._physics = physics
        self._origins_w = env_origins_w
        self._body_origins_w = env_origins_w[:, None]
        self._cache = {}
        self._body_ids, self._body_cols = body_ids, as_columns(body_ids, physics.device)
        self._root_body = body_ids[0]
        self._qadr = free_qpos_adr
        self._vadr = free_dof_adr
        self._mocap = mocap_id
        self.body_names = body_names
        device = physics.device
        model = physics.model
        com_b = torch.tensor(model.body_ipos[body_ids], dtype=torch.float32, device=device)
        self.default_body_com_pos_b = com_b.repeat(physics.num_envs, 1, 1)
        """Centres of mass at start in the link frames in m, shape (num_envs, num_bodies, 3)."""
        self._com_b = self.default_body_com_pos_b.clone()
        self._iquat_b = torch.tensor(model.body_iquat[body_ids], dtype=torch.float32, device=device)
        self.root_com_is_origin = bool((com_b[0] == 0).all())
        """Whether the root's centre of mass is known to be its origin."""
        self._tree_root = int(model.body_rootid[body_ids[0]])
        self._root_stands = free_qpos_adr is None and mocap_id is None and model.body_weldid[body_ids[0]] == 0
        self._kept: dict[str, torch.Tensor] = {}  # pose of a root that stands, from state to state
        self._kept_is_aligned = False
        self._origins_version = _version_of(env_origins_w)
        self._origins_may_differ = self._origins_version is None  # from those at construction
        self.default_root_state = torch.zeros(physics.num_envs, 13, device=device)
        """Default root pose and velocity in the environment's frame, shape (num_envs, 13)."""
        self.default_mass = torch.tensor(model.body_mass[body_ids], dtype=torch.float32, device=device).repeat(
            physics.num_envs, 1
        )
        """Masses at start in kg, shape (num_envs, num_bodies)."""
        principal = torch.tensor(model.body_inertia[body_ids], dtype=torch.float32, device=device)
        self.default_principal_inertia = principal.repeat(physics.num_envs, 1, 1)
        """Principal moments of inertia at start in kg m^2, shape (num_envs, num_bodies, 3)."""
        self.principal_axes_b = math_utils.matrix_from_quat(self._iquat_b)
        """Principal axes of inertia in the link frames, as columns, shape (num_bodies, 3, 3)."""
        self.default_inertia = self.inertia_in_link_axes(self.default_principal_inertia)
        """Inertias about the centres of mass at start, in the link axes, in kg m^2, row by row.

        Shape (num_envs, num_bodies, 9); of a rigid object (num_envs, 9).
        """
        gravity = torch.tensor(model.opt.gravity, dtype=torch.float32, device=device)
        norm = gravity.norm()
        down = gravity / norm if norm > 0 else torch.tensor([0.0, 0.0, -1.0], device=device)
        self.GRAVITY_VEC_W = down.repeat(physics.num_envs, 1)
        """Direction of gravity, shape (num_envs, 3)."""
        self.FORWARD_VEC_B = torch.tensor([1.0, 0.0, 0.0], device=device).repeat(physics.num_envs, 1)
        """The root's forward direction, shape (num_envs, 3)."""

    def set_body_com(self, env_ids: torch.Tensor, body_ids: torch.Tensor, coms_b: torch.Tensor) -> None:
        """Take note of centres of mass that were written to the engine.

        Args:
            env_ids: environments, a LongTensor of shape (n,).
            body_ids: indices of bodies, a LongTensor of shape (m,).
            coms_b: in m, in the link frames, shape (n, m, 3).
        """
        self._com_b[env_ids[:, None], body_ids] = coms_b.to(self._com_b.dtype)
        self.root_com_is_origin = False
        self.invalidate()

    def inertia_in_link_axes(self, principal: torch.Tensor) -> torch.Tensor:
        """Inertia matrices of shape (..., num_bodies, 9) from principal ones of shape (..., num_bodies, 3)."""
        axes = self.principal_axes_b
        return ((axes * principal.unsqueeze(-2)) @ axes.mT).flatten(-2)

    def invalidate(self) -> None:
        """Forget cached values, other than the pose of a root that is fixed to the world."""
        super().invalidate()
        if self._kept:
            if self._origins_moved() or any(map(_version_of, self._kept.values())):  # somebody wrote into them
                self._kept.clear()
            self._cache.update(self._kept)

    def _keep_if_standing(self, name: str, compute: Callable[[], torch.Tensor]) -> torch.Tensor:
        """A part of the root's pose; of a root that is fixed to the world it is computed only once."""
        if not self._root_stands or self._origins_moved():
            return compute()
        with torch.inference_mode(False), torch.no_grad():  # so that writes into it are counted
            value = self._kept[name] = compute()
            if name == "root_link_quat_w":
                self._kept_is_aligned = bool((value == value.new_tensor([1.0, 0.0, 0.0, 0.0])).all())
        return value

    @property
    def root_is_aligned(self) -> bool:
        """Whether the root is fixed to the world with the world's axes in every environment. Then no rotation between
        the two frames is needed."""
        if self._root_stands:
            self.root_link_quat_w  # noqa: B018 - is kept now, where it can be
        return self._kept_is_aligned and "root_link_quat_w" in self._kept

    def _origins_moved(self) -> bool:
        """Whether the environments' origins may have been changed."""
        if not self._origins_may_differ and self._origins_version != _version_of(self._origins_w):
            self._origins_may_differ = True
        return self._origins_may_differ

    def on_state_loaded(self) -> None:
        super().on_state_loaded()
        self._kept.clear()
        self._origins_version = _version_of(self._origins_w)

    # -- root pose

    @cached
    def root_link_pos_w(self) -> torch.Tensor:
        """Root position in m, shape (num_envs, 3)."""
        if self._qadr is not None:
            pos = self._physics.field("qpos")[:, self._qadr : self._qadr + 3]
        elif self._mocap is not None:
            pos = self._physics.field("mocap_pos")[:, self._mocap]
        else:
            return self._keep_if_standing(
                "root_link_pos_w", lambda: self._physics.field("xpos")[:, self._root_body] + self._origins_w
            )
        return pos + self._origins_w

    @cached
    def root_link_quat_w(self) -> torch.Tensor:
        """Root orientation (w, x, y, z), shape (num_envs, 4)."""
        if self._qadr is not None:
            return self._physics.field("qpos")[:, self._qadr + 3 : self._qadr + 7].clone()
        if self._mocap is not None:
            return self._physics.field("mocap_quat")[:, self._mocap].clone()
        return self._keep_if_standing(
            "root_link_quat_w", lambda: self._physics.field("xquat")[:, self._root_body].clone()
        )

    @cached
    def root_link_pose_w(self) -> torch.Tensor:
        """Root position and orientation, shape (num_envs, 7)."""
        return torch.cat((self.root_link_pos_w, self.root_link_quat_w), dim=-1)

    # -- root velocity

    @cached
    def root_link_vel_w(self) -> torch.Tensor:
        """Velocity of the root's origin, linear (m/s) then angular (rad/s), shape (num_envs, 6)."""
        if self._vadr is None:
            return torch.zeros(self._physics.num_envs, 6, device=self._physics.device)
        qvel = self._physics.field("qvel")[:, self._vadr : self._vadr + 6]
        ang_w = math_utils.quat_apply(self.root_link_quat_w, qvel[:, 3:6])
        return torch.cat((qvel[:, 0:3], ang_w), dim=-1)

    @cached
    def root_com_vel_w(self) -> torch.Tensor:
        """Velocity of the root's centre of mass, linear (m/s) then angular (rad/s), shape (num_envs, 6)."""
        vel = self.root_link_vel_w
        if self._vadr is None or self.root_com_is_origin:
            return vel
        arm_w = math_utils.quat_apply(self.root_link_quat_w, self._com_b[:, 0])
        return torch.cat((vel[:, :3] + torch.linalg.cross(vel[:, 3:], arm_w), vel[:, 3:]), dim=-1)

    @cached
    def root_com_pose_w(self) -> torch.Tensor:
        """Pose of the root's principal inertia frame, shape (num_envs, 7)."""
        quat = self.root_link_quat_w
        pos = self.root_link_pos_w + math_utils.quat_apply(quat, self._com_b[:, 0])
        return torch.cat((pos, math_utils.quat_mul(quat, self._iquat_b[:1].expand(len(quat), 4))), dim=-1)

    @cached
    def root_lin_vel_b(self) -> torch.Tensor:
        """Linear velocity of the root's centre of mass in its link frame, shape (num_envs, 3)."""
        return math_utils.quat_apply_inverse(self.root_link_quat_w, self.root_com_vel_w[:, :3])

    @cached
    def root_ang_vel_b(self) -> torch.Tensor:
        """Angular velocity of the root in its link frame, shape (num_envs, 3)."""
        return math_utils.quat_apply_inverse(self.root_link_quat_w, self.root_com_vel_w[:, 3:])

    @cached
    def root_link_lin_vel_b(self) -> torch.Tensor:
        """Linear velocity of the root's origin in its link frame, shape (num_envs, 3)."""
        return math_utils.quat_apply_inverse(self.root_link_quat_w, self.root_link_vel_w[:, :3])

    @cached
    def root_state_w(self) -> torch.Tensor:
        """Link pose and centre-of-mass velocity of the root, shape (num_envs, 13)."""
        return torch.cat((self.root_link_pose_w, self.root_com_vel_w), dim=-1)

    @cached
    def root_link_state_w(self) -> torch.Tensor:
        """Link pose and link velocity of the root, shape (num_envs, 13)."""
        return torch.cat((self.root_link_pose_w, self.root_link_vel_w), dim=-1)

    @cached
    def root_com_state_w(self) -> torch.Tensor:
        """Centre-of-mass pose and velocity of the root, shape (num_envs, 13)."""
        return torch.cat((self.root_com_pose_w, self.root_com_vel_w), dim=-1)

    @cached
    def projected_gravity_b(self) -> torch.Tensor:
        """Direction of gravity in the root's frame, shape (num_envs, 3)."""
        return math_utils.quat_apply_inverse(self.root_link_quat_w, self.GRAVITY_VEC_W)

    @cached
    def heading_w(self) -> torch.Tensor:
        """Yaw of the root's forward direction in rad, shape (num_envs,)."""
        forward_w = math_utils.quat_apply(self.root_link_quat_w, self.FORWARD_VEC_B)
        return torch.atan2(forward_w[:, 1], forward_w[:, 0])

    # -- bodies

    def _of_bodies(self, name: str) -> torch.Tensor:
        """A current field of the bodies, in their order: a view where the engine stores them so, else a copy."""
        return take_columns(self._physics.current(name), self._body_cols)

    @cached
    def body_link_pos_w(self) -> torch.Tensor:
        """Positions of the bodies in m, shape (num_envs, num_bodies, 3)."""
        return self._of_bodies("xpos") + self._body_origins_w

    @cached
    def body_link_quat_w(self) -> torch.Tensor:
        """Orientations of the bodies (w, x, y, z), shape (num_envs, num_bodies, 4)."""
        quat = self._of_bodies("xquat")
        return quat.clone() if isinstance(self._body_cols, slice) else quat

    @cached
    def body_link_pose_w(self) -> torch.Tensor:
        """Positions and orientations of the bodies, shape (num_envs, num_bodies, 7)."""
        return torch.cat((self.body_link_pos_w, self.body_link_quat_w), dim=-1)

    def link_pose_of(self, body: int) -> tuple[torch.Tensor, torch.Tensor]:
        """Position (m) and orientation (w, x, y, z) of one body, shapes (num_envs, 3) and (num_envs, 4).

        What :attr:`body_link_pos_w` and :attr:`body_link_quat_w` say of it, at a fraction of their cost.
        """
        index = self._body_ids[body]
        pos_w = self._physics.current("xpos")[:, index] + self._origins_w
        return pos_w, self._physics.current("xquat")[:, index].clone()

    def _velocity_at(self, points: torch.Tensor) -> torch.Tensor:
        """Velocity of the bodies at points given without origins, linear then angular."""
        cvel = self._of_bodies("cvel")
        centre = self._physics.current("subtree_com")[:, self._tree_root, None]
        ang, lin = cvel[..., :3], cvel[..., 3:]
        return torch.cat((lin + torch.linalg.cross(ang, points - centre), ang), dim=-1)

    @cached
    def body_com_vel_w(self) -> torch.Tensor:
        """Velocities of the bodies' centres of mass, shape (num_envs, num_bodies, 6)."""
        return self._velocity_at(self._of_bodies("xipos"))

    @cached
    def body_link_vel_w(self) -> torch.Tensor:
        """Velocities of the bodies' origins, shape (num_envs, num_bodies, 6)."""
        return self._velocity_at(self._of_bodies("xpos"))

    @cached
    def body_com_pos_w(self) -> torch.Tensor:
        """Centres of mass of the bodies in m, shape (num_envs, num_bodies, 3)."""
        return self._of_bodies("xipos") + self._body_origins_w

    @cached
    def body_com_quat_w(self) -> torch.Tensor:
        """Orientations of the principal axes of inertia, shape (num_envs, num_bodies, 4)."""
        quat = self.body_link_quat_w
        return math_utils.quat_mul(quat, self._iquat_b.expand_as(quat))

    @cached
    def body_com_pose_w(self) -> torch.Tensor:
        """Poses of the principal inertia frames, shape (num_envs, num_bodies, 7)."""
        return torch.cat((self.body_com_pos_w, self.body_com_quat_w), dim=-1)

    @cached
    def body_state_w(self) -> torch.Tensor:
        """Link poses and centre-of-mass velocities, shape (num_envs, num_bodies, 13)."""
        return torch.cat((self.body_link_pose_w, self.body_com_vel_w), dim=-1)

    @cached
    def body_link_state_w(self) -> torch.Tensor:
        """Link poses and link velocities, shape (num_envs, num_bodies, 13)."""
        return torch.cat((self.body_link_pose_w, self.body_link_vel_w), dim=-1)

    @cached
    def body_com_state_w(self) -> torch.Tensor:
        """Centre-of-mass poses and velocities, shape (num_envs, num_bodies, 13)."""
        return torch.cat((self.body_com_pose_w, self.body_com_vel_w), dim=-1)

    @cached
    def body_com_acc_w(self) -> torch.Tensor:
        """Accelerations of the bodies' centres of mass without gravity's, shape (num_envs, num_bodies, 6).

        From the change of the velocities over the last physics substep.
        """
        acc = take_columns(self._physics.com_acc(), self._body_cols)
        arm_w = self._of_bodies("xipos")
        arm_w = arm_w - self._physics.current("subtree_com")[:, self._tree_root, None]
        ang, lin = acc[..., :3], acc[..., 3:]
        vel = self.body_com_vel_w
        lin = lin + torch.linalg.cross(ang, arm_w) + torch.linalg.cross(vel[..., 3:], vel[..., :3])
        return torch.cat((lin, ang), dim=-1)

    @property
    def body_com_pos_b(self) -> torch.Tensor:
        """Centres of mass in the link frames, shape (num_envs, num_bodies, 3)."""
        return self._com_b

    @property
    def body_com_quat_b(self) -> torch.Tensor:
        """Principal axes in the link frames (w, x, y, z), shape (num_envs, num_bodies, 4)."""
        return self._iquat_b.expand(self._physics.num_envs, *self._iquat_b.shape)

    @property
    def body_com_pose_b(self) -> torch.Tensor:
        """Principal inertia frames in the link frames, shape (num_envs, num_bodies, 7)."""
        return torch.cat((self.body_com_pos_b, self.body_com_quat_b), dim=-1)


def _version_of(tensor: torch.Tensor) -> int | None:
    """How often a tensor, or what it is a part of, was written into; None where torch does not count it."""
    return None if tensor.is_inference() else tensor._version

"""Camera geometry: depth images, points and the frame conventions of cameras."""

from __future__ import annotations

from typing import Literal

import torch

from .rotations import matrix_from_quat, quat_from_matrix

Convention = Literal["opengl", "ros", "world"]

# Axes of a convention's camera frame, as columns, in the OpenGL camera frame (-z forward, +y up).
_AXES_IN_OPENGL = {
    "opengl": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "ros": ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0)),  # +z forward, -y up
    "world": ((0.0, -1.0, 0.0), (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0)),  # +x forward, +z up
}


def convert_camera_frame_orientation_convention(
    orientation: torch.Tensor, origin: Convention = "opengl", target: Convention = "ros"
) -> torch.Tensor:
    """Orientation of the same camera with its frame in another convention.

    Args:
        orientation: quaternion (w, x, y, z) of the camera frame in convention ``origin``. Shape is (..., 4).
        origin: "opengl" (-z forward, +y up; USD), "ros" (+z forward, -y up) or "world" (+x forward, +z up).
        target: likewise.

    Returns:
        Quaternion of the camera frame in convention ``target``. Shape is (..., 4).

    Raises:
        ValueError: unknown convention.
    """
    for name in (origin, target):
        if name not in _AXES_IN_OPENGL:
            raise ValueError(f"unknown camera convention {name!r}; choose one of {sorted(_AXES_IN_OPENGL)}")
    if origin == target:
        return orientation.clone()
    axes_origin = orientation.new_tensor(_AXES_IN_OPENGL[origin])
    axes_target = orientation.new_tensor(_AXES_IN_OPENGL[target])
    return quat_from_matrix(matrix_from_quat(orientation) @ axes_origin.T @ axes_target)


def create_rotation_matrix_from_view(
    eyes: torch.Tensor, targets: torch.Tensor, up_axis: Literal["Y", "Z"] = "Z", device: torch.device | str = "cpu"
) -> torch.Tensor:
    """Rotation matrices of OpenGL cameras (-z forward, +y up) that look from ``eyes`` at ``targets``.

    Args:
        eyes: Position of the camera. Shape is (N, 3) or (1, 3).
        targets: Position looked at. Shape is (N, 3) or (1, 3).
        up_axis: world axis that points up in the image.
        device: device of the result.

    Returns:
        Columns are the camera's axes in the world frame. Shape is (N, 3, 3). Looking along the up axis leaves the
        image's up direction free; the camera's x axis is then the world's.

    Raises:
        ValueError: another up axis.
    """
    if up_axis not in ("Y", "Z"):
        raise ValueError(f"create_rotation_matrix_from_view: up_axis is 'Y' or 'Z', not {up_axis!r}")
    eyes = torch.as_tensor(eyes, dtype=torch.float32, device=device).reshape(-1, 3)
    targets = torch.as_tensor(targets, dtype=torch.float32, device=device).reshape(-1, 3)
    z_axis = torch.nn.functional.normalize(eyes - targets, dim=-1, eps=1e-5)
    up = z_axis.new_tensor((0.0, 1.0, 0.0) if up_axis == "Y" else (0.0, 0.0, 1.0)).expand_as(z_axis)
    x_axis = torch.linalg.cross(up, z_axis)
    degenerate = torch.linalg.vector_norm(x_axis, dim=-1, keepdim=True) < 5e-3
    x_axis = torch.where(degenerate, z_axis.new_tensor((1.0, 0.0, 0.0)), x_axis)
    x_axis = torch.nn.functional.normalize(x_axis, dim=-1, eps=1e-9)
    y_axis = torch.nn.functional.normalize(torch.linalg.cross(z_axis, x_axis), dim=-1, eps=1e-9)
    x_axis = torch.linalg.cross(y_axis, z_axis)
    return torch.stack((x_axis, y_axis, z_axis), dim=-1)


def orthogonalize_perspective_depth(depth: torch.Tensor, intrinsics: torch.Tensor) -> torch.Tensor:
    """Turn distances from the optical centre into distances from the image plane.

    Args:
        depth: Shape is (H, W), (H, W, 1), (N, H, W) or (N, H, W, 1).
        intrinsics: calibration matrix. Shape is (3, 3) or (N, 3, 3).

    Returns:
        Depth of the same shape.

    Raises:
        ValueError: other shapes.
    """
    images, intrinsics = _as_images(depth, intrinsics)
    u, v = _pixels(images)
    fx, fy, cx, cy = (intrinsics[:, row, col, None, None] for row, col in ((0, 0), (1, 1), (0, 2), (1, 2)))
    ray_length = torch.sqrt(1.0 + ((u - cx) / fx) ** 2 + ((v - cy) / fy) ** 2)
    return (images / ray_length).reshape(depth.shape)


def unproject_depth(depth: torch.Tensor, intrinsics: torch.Tensor, is_ortho: bool = True) -> torch.Tensor:
    """Points in the camera frame (+z forward, +x right, +y down) of a depth image.

    Args:
        depth: Shape is (H, W), (H, W, 1), (N, H, W) or (N, H, W, 1).
        intrinsics: calibration matrix. Shape is (3, 3) or (N, 3, 3).
        is_ortho: whether depth is measured from the image plane, rather than from the optical centre.

    Returns:
        Points, column of pixels by column. Shape is (W * H, 3), or (N, W * H, 3) for a batch.

    Raises:
        ValueError: other shapes.
    """
    batched = depth.dim() == 4 or (depth.dim() == 3 and depth.shape[-1] != 1)
    if not is_ortho:
        depth = orthogonalize_perspective_depth(depth, intrinsics)
    images, intrinsics = _as_images(depth, intrinsics)
    u, v = _pixels(images)
    pixels = torch.stack((u, v, torch.ones_like(u)), dim=0).transpose(1, 2).flatten(1)  # (3, W * H)
    rays = (torch.linalg.inv(intrinsics) @ pixels).transpose(1, 2)
    rays = rays / rays[..., 2:]
    points = rays * images.transpose(1, 2).flatten(1).unsqueeze(-1)
    return points if batched else points.squeeze(0)


def project_points(points: torch.Tensor, intrinsics: torch.Tensor) -> torch.Tensor:
    """Pixels and depth (u, v, d) of points in the camera frame (+z forward).

    Args:
        points: Shape is (P, 3) or (N, P, 3).
        intrinsics: calibration matrix. Shape is (3, 3) or (N, 3, 3).

    Returns:
        Shape is (P, 3), or (N, P, 3) where something is batched.

    Raises:
        ValueError: other shapes.
    """
    if points.dim() not in (2, 3) or intrinsics.dim() not in (2, 3):
        raise ValueError(
            "project_points: expected points (P, 3) or (N, P, 3) and intrinsics (3, 3) or (N, 3, 3), got "
            f"{tuple(points.shape)} and {tuple(intrinsics.shape)}"
        )
    image = points @ intrinsics.transpose(-1, -2)
    depth = points[..., 2:].expand(*image.shape[:-1], 1)
    return torch.cat((image[..., :2] / image[..., 2:], depth), dim=-1)


def _as_images(depth: torch.Tensor, intrinsics: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """Depth as (N, H, W) and intrinsics as (1 or N, 3, 3)."""
    images = depth.squeeze(-1) if depth.dim() in (3, 4) and depth.shape[-1] == 1 else depth
    images = images.unsqueeze(0) if images.dim() == 2 else images
    if images.dim() != 3:
        raise ValueError(f"expected depth of shape (H, W[, 1]) or (N, H, W[, 1]), got {tuple(depth.shape)}")
    if intrinsics.dim() not in (2, 3):
        raise ValueError(f"expected intrinsics of shape (3, 3) or (N, 3, 3), got {tuple(intrinsics.shape)}")
    return images, intrinsics.unsqueeze(0) if intrinsics.dim() == 2 else intrinsics


def _pixels(images: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """Column and row index of every pixel. Shapes are (H, W)."""
    rows = torch.arange(images.shape[-2], device=images.device, dtype=images.dtype)
    columns = torch.arange(images.shape[-1], device=images.device, dtype=images.dtype)
    v, u = torch.meshgrid(rows, columns, indexing="ij")
    return u, v

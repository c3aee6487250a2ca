"""A kitchen cabinet with two drawers and two doors, as tables of numbers. Owns every number of
`assets/usd/cabinet.usda`.

The cabinet is our own: flat panels of chipboard. Its body and joint names are those of Isaac Sim's Sektion cabinet,
and its measures are such that Isaac Lab's drawer task makes sense with it: with the cabinet's origin 0.4 m above the
floor it stands on the floor, and the middle of the top drawer's handle is at (0.305, 0, 0.01) m in the frame of
`drawer_handle_top`.

Frames, all parallel: x to the front, y to the left of one who looks along x, z up; the origin is behind the lower
drawer. A drawer's and its handle's frame coincide; a door's frame is on its hinge. Units are SI and radians.
"""

from __future__ import annotations

from math import pi
from typing import NamedTuple

from panda_description import Box, Joint, Vec3

WIDTH = 0.70
"""Along y, m."""
BACK, FRONT = -0.29, 0.25
"""Along x, from the back to the edge that the fronts close, m."""
FLOOR, TOP = -0.40, 0.30
"""Along z, m."""
KICK = 0.04
"""Height of the plinth below the bottom panel, m."""
SHELF = -0.045
"""Top of the panel between drawers and doors, m."""
BOARD = 0.018
"""Thickness of a panel, m."""
FRONT_BOARD = 0.02
"""Thickness of a drawer's or a door's front, m."""
GAP = 0.004
"""Between two fronts, m."""
DRAWER_Z = {"drawer_top": 0.205, "drawer_bottom": 0.0325}
"""Height of each drawer's frame, m."""
DRAWER_FRONT = 0.1685
"""Height of a drawer's front, m; its middle is as high as its handle."""
HANDLE: Vec3 = (0.305, 0.0, 0.01)
"""Middle of a drawer's handle in its frame, m. Behind the bar are 2.9 cm of air for a finger."""
HANDLE_BAR: Vec3 = (0.012, 0.16, 0.02)
"""Bar of a drawer's handle, m: a finger goes above it and one below."""
DRAWER_STROKE = 0.4
"""How far a drawer comes out, m."""


class Part(NamedTuple):
    """A body: mass (kg, evenly spread over its panels), panels in its own frame, linear RGB, and its frame's place."""

    mass: float
    boxes: tuple[Box, ...]
    color: Vec3
    xyz: Vec3 = (0.0, 0.0, 0.0)


def _carcass() -> tuple[Box, ...]:
    depth, x = FRONT - BACK, (FRONT + BACK) / 2
    height, z = TOP - FLOOR, (TOP + FLOOR) / 2
    side = (WIDTH - BOARD) / 2
    inner = WIDTH - 2 * BOARD
    return (
        Box("back", (BOARD, inner, height), (BACK + BOARD / 2, 0.0, z)),
        Box("left", (depth, BOARD, height), (x, side, z)),
        Box("right", (depth, BOARD, height), (x, -side, z)),
        Box("top", (depth, inner, BOARD), (x, 0.0, TOP - BOARD / 2)),
        Box("shelf", (depth, inner, BOARD), (x, 0.0, SHELF - BOARD / 2)),
        Box("bottom", (depth, inner, BOARD), (x, 0.0, FLOOR + KICK + BOARD / 2)),
        Box("plinth", (BOARD, inner, KICK), (FRONT - 0.05, 0.0, FLOOR + KICK / 2)),
    )


def _drawer() -> tuple[Box, ...]:
    depth, wall, height = 0.5, 0.012, 0.1
    width = WIDTH - 2 * BOARD - 0.026  # 13 mm a side for the runners
    x, low = FRONT - depth / 2, HANDLE[2] - DRAWER_FRONT / 2 + 0.02
    return (
        Box("front", (FRONT_BOARD, WIDTH - GAP, DRAWER_FRONT), (FRONT + FRONT_BOARD / 2, 0.0, HANDLE[2])),
        Box("floor", (depth, width, wall), (x, 0.0, low + wall / 2)),
        Box("left", (depth, wall, height), (x, (width - wall) / 2, low + height / 2)),
        Box("right", (depth, wall, height), (x, (wall - width) / 2, low + height / 2)),
        Box("back", (wall, width, height), (FRONT - depth + wall / 2, 0.0, low + height / 2)),
    )


def _handle() -> tuple[Box, ...]:
    x, y, z = HANDLE
    post = x - HANDLE_BAR[0] / 2 - FRONT - FRONT_BOARD
    at = x - HANDLE_BAR[0] / 2 - post / 2
    reach = HANDLE_BAR[1] / 2 - 0.006
    return (
        Box("bar", HANDLE_BAR, HANDLE),
        Box("post_left", (post, 0.012, 0.012), (at, y + reach, z)),
        Box("post_right", (post, 0.012, 0.012), (at, y - reach, z)),
    )


def _door(side: int) -> tuple[Box, ...]:
    """`side` 1 is the left door; its panel lies to the right of its hinge."""
    width, height = WIDTH / 2 - GAP, SHELF - FLOOR - KICK - GAP
    grip = -side * (width - 0.05)
    return (
        Box("panel", (FRONT_BOARD, width, height), (FRONT_BOARD / 2, -side * width / 2, 0.0)),
        Box("grip", (0.012, 0.016, 0.12), (0.055, grip, 0.06)),
        Box("post_high", (0.029, 0.012, 0.012), (0.0345, grip, 0.114)),
        Box("post_low", (0.029, 0.012, 0.012), (0.0345, grip, 0.006)),
    )


_WOOD: Vec3 = (0.62, 0.52, 0.40)
_FRONT_COLOR: Vec3 = (0.75, 0.75, 0.72)
_METAL: Vec3 = (0.10, 0.10, 0.11)
_HINGE: Vec3 = (FRONT, WIDTH / 2 - GAP / 2, (SHELF + FLOOR + KICK) / 2)

PARTS: dict[str, Part] = {
    "sektion": Part(27.0, _carcass(), _WOOD),
    "drawer_top": Part(5.0, _drawer(), _FRONT_COLOR, (0.0, 0.0, DRAWER_Z["drawer_top"])),
    "drawer_bottom": Part(5.0, _drawer(), _FRONT_COLOR, (0.0, 0.0, DRAWER_Z["drawer_bottom"])),
    "door_left": Part(1.4, _door(1), _FRONT_COLOR, _HINGE),
    "door_right": Part(1.4, _door(-1), _FRONT_COLOR, (_HINGE[0], -_HINGE[1], _HINGE[2])),
    "drawer_handle_top": Part(0.2, _handle(), _METAL, (0.0, 0.0, DRAWER_Z["drawer_top"])),
    "drawer_handle_bottom": Part(0.2, _handle(), _METAL, (0.0, 0.0, DRAWER_Z["drawer_bottom"])),
}
"""Masses are those of chipboard of about 650 kg/m^3, and of steel handles."""

GRASPED = ("drawer_handle_top", "drawer_handle_bottom")
"""Bodies with the contact of the finger pads, which hold."""


def _joint(name: str, child: str, kind: str, axis: str, upper: float, velocity: float) -> Joint:
    return Joint(name, kind, "sektion", child, PARTS[child].xyz, axis=axis, upper=upper, velocity=velocity, effort=87.0)


JOINTS: tuple[Joint, ...] = (
    _joint("drawer_top_joint", "drawer_top", "prismatic", "X", DRAWER_STROKE, 5.0),
    _joint("drawer_bottom_joint", "drawer_bottom", "prismatic", "X", DRAWER_STROKE, 5.0),
    _joint("door_left_joint", "door_left", "revolute", "Z", pi / 2, 10.0),
    _joint("door_right_joint", "door_right", "revolute", "-Z", pi / 2, 10.0),
    Joint("drawer_handle_top_joint", "fixed", "drawer_top", "drawer_handle_top", (0.0, 0.0, 0.0)),
    Joint("drawer_handle_bottom_joint", "fixed", "drawer_bottom", "drawer_handle_bottom", (0.0, 0.0, 0.0)),
)
"""Zero is closed and positive is open, for all four. Effort limits are Isaac Lab's for this cabinet."""

DRIVE = {"prismatic": (0.0, 1.0), "revolute": (0.0, 2.5)}
"""Stiffness and damping of a drive, per m or per rad: damping alone, the runners' and the hinges' (Isaac Lab's)."""

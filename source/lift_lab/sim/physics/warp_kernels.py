"""Small warp kernels beside the engine's own, and a word to the user while kernels compile."""

# Kernels are in warp's language, whose types a checker of Python takes for others.
# pyright: reportArgumentType=false, reportOperatorIssue=false, reportInvalidTypeForm=false
# pyright: reportAssignmentType=false, reportGeneralTypeIssues=false

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import warp as wp

_LOG = logging.getLogger(__name__)


@wp.kernel
def keep_columns(
    keep: wp.array(dtype=bool),
    saved: wp.array2d(dtype=float),
    values: wp.array2d(dtype=float),
):
    """Put saved values back in some columns."""
    env, column = wp.tid()
    if keep[column]:
        values[env, column] = saved[env, column]


@wp.kernel
def zero_rows(
    mask: wp.array(dtype=bool),
    values: wp.array2d(dtype=float),
):
    """Zero the rows of some environments."""
    env, column = wp.tid()
    if mask[env]:
        values[env, column] = 0.0


@wp.func
def _is_bad(values: wp.array2d(dtype=float), env: int, limit: float):
    bad = bool(False)  # noqa: UP018 - a literal would be a constant to warp, which a loop must not change
    for column in range(values.shape[1]):
        # one comparison finds NaN, infinity and huge values alike
        if not (wp.abs(values[env, column]) <= limit):
            bad = True
    return bad


@wp.kernel
def find_failures(
    qpos: wp.array2d(dtype=float),
    qvel: wp.array2d(dtype=float),
    act: wp.array2d(dtype=float),
    warmstart: wp.array2d(dtype=float),
    ctrl: wp.array2d(dtype=float),
    limit: float,
    overflow_mask: int,
    overflow_bits: wp.array(dtype=int),
    failed: wp.array(dtype=bool),
    nonfinite: wp.array(dtype=bool),
    overflow: wp.array(dtype=bool),
):
    """Find the environments that are in a bad state or had an overflow: `failed` is current, the others are latched.

    The engine's overflow bits are cleared.
    """
    env = wp.tid()
    bad = _is_bad(qpos, env, limit) or _is_bad(qvel, env, limit) or _is_bad(act, env, limit)
    bad = bad or _is_bad(warmstart, env, limit) or _is_bad(ctrl, env, limit)
    full = (overflow_bits[env] & overflow_mask) != 0
    overflow_bits[env] = 0
    failed[env] = bad or full
    if bad:
        nonfinite[env] = True
    if full:
        overflow[env] = True


@wp.func
def _rotate(quat: wp.quat, vector: wp.vec3):
    """Turn a vector by a quaternion in MuJoCo's order (w, x, y, z)."""
    axis = wp.vec3(quat[1], quat[2], quat[3])
    return vector + 2.0 * wp.cross(axis, wp.cross(axis, vector) + quat[0] * vector)


@wp.kernel
def place_fixed_geoms(
    geoms: wp.array(dtype=int),
    geom_bodyid: wp.array(dtype=int),
    geom_pos: wp.array2d(dtype=wp.vec3),
    geom_quat: wp.array2d(dtype=wp.quat),
    xpos: wp.array2d(dtype=wp.vec3),
    xquat: wp.array2d(dtype=wp.quat),
    geom_xpos: wp.array2d(dtype=wp.vec3),
    geom_xmat: wp.array2d(dtype=wp.mat33),
):
    """Frames of geoms that are fixed to the world, which the engine's kinematics leave alone."""
    env, i = wp.tid()
    geom = geoms[i]
    body = geom_bodyid[geom]
    quat = geom_quat[env % geom_quat.shape[0], geom]
    frame = xquat[env, body]
    geom_xpos[env, geom] = xpos[env, body] + _rotate(frame, geom_pos[env % geom_pos.shape[0], geom])
    x = _rotate(frame, _rotate(quat, wp.vec3(1.0, 0.0, 0.0)))
    y = _rotate(frame, _rotate(quat, wp.vec3(0.0, 1.0, 0.0)))
    z = _rotate(frame, _rotate(quat, wp.vec3(0.0, 0.0, 1.0)))
    geom_xmat[env, geom] = wp.mat33(x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2])


class _CompileWatcher:
    """A logger for warp that passes warnings on and tells of the first kernel that was not in the cache."""

    def __init__(self, device: wp.Device, passed_on: Any):
        self._device, self._passed_on, self._told = device, passed_on, False

    def info(self, message: str) -> None:
        if "(compiled)" in message and not self._told:
            self._told = True
            cache = wp.config.kernel_cache_dir
            _LOG.warning("compiling MuJoCo-Warp kernels for %s: minutes, once; kept in %s", self._device, cache)

    def debug(self, message: str) -> None:
        """Not shown."""

    def warning(self, message: str, category: Any = None, stacklevel: int = 1) -> None:
        self._passed_on.warning(message, category, stacklevel)

    def error(self, message: str) -> None:
        self._passed_on.error(message)


@contextmanager
def say_when_compiling(device: wp.Device) -> Iterator[None]:
    """Log one line as soon as a kernel had to be compiled: a first run is otherwise silent for minutes."""
    level = wp.config.log_level
    with wp.ScopedLogger(_CompileWatcher(device, wp.get_logger())):
        wp.config.log_level = wp.LOG_INFO
        try:
            yield
        finally:
            wp.config.log_level = level

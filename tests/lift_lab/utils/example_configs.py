"""Two configurations, one within the other, that the tests of ``@configclass`` share."""

from __future__ import annotations

from dataclasses import MISSING
from typing import Any

from lift_lab.utils import configclass


@configclass
class ViewerCfg:
    eye: list = [7.5, 7.5, 7.5]
    resolution = (640, 480)


@configclass
class EnvCfg:
    num_envs: int = MISSING
    decimation = 2
    viewer: ViewerCfg = ViewerCfg()
    params: dict[str, Any] = {"std": 0.1, "names": ["a"]}

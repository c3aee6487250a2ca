"""A page that plays an episode without a server."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import torch

from lift_lab.envs.frame_capture import update_markers
from lift_lab.visualizers import BodyLayer, MarkerLayer, World, open_server
from lift_lab_rl.files import write_atomically

from .camera import look_at
from .policies import ViewedPolicy

MAX_FRAMES_PER_S = 30.0
"""Frames a second of the page; an environment that steps faster is drawn at every second, third, ... step."""


def record_replay(env: Any, policy: ViewedPolicy, path: Path, steps: int) -> int:
    """Run a policy and write what happened as one HTML file with a timeline.

    Args:
        env: wrapped environment.
        policy: acts.
        path: the file.
        steps: environment steps.

    Returns:
        Size of the file in bytes.

    Raises:
        MissingPackageError: viser is not installed.
    """
    inner = env.unwrapped
    every = max(1, round(1.0 / (inner.step_dt * MAX_FRAMES_PER_S)))
    with torch.inference_mode():
        obs, _ = env.reset()
        server = open_server(port=0)
        try:
            World(server)
            bodies = BodyLayer(server, inner.sim.physics, inner.scene.env_origins)
            markers = MarkerLayer(server, inner.sim, inner.scene.env_origins)
            look_at(server, bodies, inner.scene.env_origins, 0)
            update_markers(inner)
            markers.update()
            recording = server.get_scene_serializer()
            for step in range(1, steps + 1):
                obs, _, dones, _ = env.step(policy.act(obs).to(env.device))
                policy.reset(dones)
                recording.insert_sleep(inner.step_dt)
                if step % every == 0 or step == steps:
                    bodies.update()
                    update_markers(inner)
                    markers.update()
            page = recording.as_html().encode()
        finally:
            server.stop()
    write_atomically(path, page)
    return len(page)

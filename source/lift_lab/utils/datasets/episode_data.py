"""One recorded episode."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import torch


class EpisodeData:
    """Time series of one episode, as a tree of names.

    While recording, a leaf is a list with one tensor per step; :meth:`pre_export` stacks each into one tensor whose
    first dimension is time. Isaac Lab's names of the branches: ``initial_state``, ``actions``, ``states``,
    ``joint_targets``, ``obs``.
    """

    def __init__(self) -> None:
        self.data: dict[str, Any] = {}
        """The tree."""
        self.seed: int | None = None
        """Seed of the episode."""
        self.env_id: Any = None
        """The environment it comes from."""
        self.success: bool | None = None
        """Whether it reached the goal."""
        self.next_action_index = 0
        """Step that :meth:`get_next_action` returns."""
        self.next_state_index = 0
        """Step that :meth:`get_next_state` returns."""
        self.next_joint_target_index = 0
        """Step that :meth:`get_next_joint_target` returns."""

    def is_empty(self) -> bool:
        """Whether nothing was recorded."""
        return not self.data

    def add(self, key: str, value: torch.Tensor | dict) -> None:
        """Append the value of one step.

        Args:
            key: name in the tree, e.g. "obs/joint_pos".
            value: tensor, or a tree of tensors to put below ``key``. It is copied.
        """
        if isinstance(value, dict):
            for name, entry in value.items():
                self.add(f"{key}/{name}", entry)
            return
        *branches, leaf = key.split("/")
        node = self.data
        for branch in branches:
            node = node.setdefault(branch, {})
        node.setdefault(leaf, []).append(value.clone())

    def pre_export(self) -> None:
        """Stack the recorded lists into tensors whose first dimension is time."""
        self.data = _map_leaves(lambda leaf: torch.stack(leaf) if isinstance(leaf, list) else leaf, self.data)

    def get_initial_state(self) -> Any | None:
        """The initial state; None if it was not recorded."""
        return self.data.get("initial_state")

    def get_action(self, action_index: int) -> torch.Tensor | None:
        """Action of a step; None if there is none."""
        return _at(self.data.get("actions"), action_index)

    def get_state(self, state_index: int) -> dict | torch.Tensor | None:
        """State of a step, as a tree of tensors with a first dimension of one; None if there is none."""
        state = _at(self.data.get("states"), state_index)
        return None if state is None else _map_leaves(lambda leaf: leaf[None], state)

    def get_joint_target(self, joint_target_index: int) -> dict | torch.Tensor | None:
        """Joint targets of a step; None if there are none."""
        return _at(self.data.get("joint_targets"), joint_target_index)

    def get_next_action(self) -> torch.Tensor | None:
        """Action of the next step; None after the last."""
        action = self.get_action(self.next_action_index)
        self.next_action_index += action is not None
        return action

    def get_next_state(self) -> dict | torch.Tensor | None:
        """State of the next step, as in :meth:`get_state`; None after the last."""
        state = self.get_state(self.next_state_index)
        self.next_state_index += state is not None
        return state

    def get_next_joint_target(self) -> dict | torch.Tensor | None:
        """Joint targets of the next step; None after the last."""
        target = self.get_joint_target(self.next_joint_target_index)
        self.next_joint_target_index += target is not None
        return target


def _map_leaves(function: Callable[[Any], Any], tree: Any) -> Any:
    if isinstance(tree, dict):
        return {key: _map_leaves(function, value) for key, value in tree.items()}
    return function(tree)


def _at(tree: Any, index: int) -> Any | None:
    """The step ``index`` of every leaf; None where one has no such step."""
    if isinstance(tree, dict):
        entries = {key: _at(value, index) for key, value in tree.items()}
        return None if any(entry is None for entry in entries.values()) else entries
    return tree[index] if tree is not None and index < len(tree) else None

"""Names in the model: the prim's own, made unique with its ancestors' names."""

from __future__ import annotations

from itertools import chain, count


class Names:
    """Generator of unique names, one namespace per kind of MuJoCo element."""

    def __init__(self) -> None:
        self._taken: dict[str, set[str]] = {}
        self._by_path: dict[tuple[str, str], str] = {}

    def of(self, kind: str, path: str, suffix: str = "") -> str:
        """Name for the element of `kind` made from the prim at `path`: its leaf name, or with parents prefixed."""
        parts = [part for part in path.replace("{", "_").replace("}", "").replace("=", "_").split("/") if part]
        taken = self._taken.setdefault(kind, {"world"} if kind == "body" else set())
        candidates = chain(
            ("_".join(parts[-n:]) + suffix for n in range(1, len(parts) + 1)),
            (f"{parts[-1]}{suffix}_{n}" for n in count(2)),
        )
        name = next(candidate for candidate in candidates if candidate not in taken)
        taken.add(name)
        self._by_path.setdefault((kind, path), name)
        return name

    def find(self, kind: str, path: str) -> str | None:
        """Name given before to the first element of `kind` from the prim at `path`."""
        return self._by_path.get((kind, path))

"""Names in the model: the prim's own, made unique with its ancestors' names."""

from __future__ import annotations


class Names:
    """Hands out unique names, one namespace per kind of MuJoCo element."""

    def __init__(self) -> None:
        self._taken: dict[str, set[str]] = {}
        self._by_path: dict[tuple[str, str], str] = {}

    def of(self, kind: str, path: str, suffix: str = "") -> str:
        """Name for the element of `kind` made from the prim at `path`: its leaf name, or with parents prefixed."""
        parts = [part.replace("{", "_").replace("}", "").replace("=", "_") for part in path.split("/") if part]
        taken = self._taken.setdefault(kind, {"world"} if kind == "body" else set())
        candidates = ["_".join(parts[-n:]) + suffix for n in range(1, len(parts) + 1)]
        name = next((c for c in candidates if c not in taken), None)
        count = 1
        while name is None:
            count += 1
            name = next((c for c in [f"{candidates[0]}_{count}"] if c not in taken), None)
        taken.add(name)
        self._by_path.setdefault((kind, path), name)
        return name

    def find(self, kind: str, path: str) -> str | None:
        """Name given before to the first element of `kind` from the prim at `path`."""
        return self._by_path.get((kind, path))

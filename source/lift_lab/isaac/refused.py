"""Base of the classes that cannot be made."""

from __future__ import annotations

from typing import Any, ClassVar, NoReturn

from .table import Unsupported


class Refused:
    """A type for imports, annotations and ``isinstance``; making one raises."""

    missing: ClassVar[Unsupported]
    """Its entry in the table."""

    def __new__(cls, *args: Any, **kwargs: Any) -> NoReturn:
        """Refuse.

        Args:
            *args: a config first, where there is one.
            **kwargs: or as ``cfg``.

        Raises:
            ConfigError: always.
        """
        raise cls.missing.error(name=cls.__name__, cfg=args[0] if args else kwargs.get("cfg"))

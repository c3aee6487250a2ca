"""The viewer's server, on the loopback interface and for its own pages only."""

from __future__ import annotations

import contextlib
import importlib.util
import io
import socket
from typing import TYPE_CHECKING

from lift_lab.utils.errors import MissingPackageError

from .origin import ViewerError, check_refuses, own_pages_only

if TYPE_CHECKING:
    import viser

HOST = "127.0.0.1"
"""The only address on which the viewer listens: everyone who can reach it can control it."""

DEFAULT_PORT = 8080
"""Default port of the viewer."""


def require_viser() -> None:
    """Check that the viewer's packages are there.

    Raises:
        MissingPackageError: viser is not installed.
    """
    if importlib.util.find_spec("viser") is None:
        raise MissingPackageError("the viewer needs viser: pip install 'lift-lab[viewer]'")


def open_server(port: int = DEFAULT_PORT, label: str | None = None) -> viser.ViserServer:
    """Start a server. It refuses requests of pages of other sites, and those that are addressed to another machine.

    Args:
        port: where it listens; 0 takes any free one.
        label: title of the page.

    Raises:
        MissingPackageError: viser is not installed.
        ViewerError: the port is taken or no port, or other sites' pages cannot be refused.
    """
    require_viser()
    if not 0 <= port <= 65535:
        raise ViewerError(f"port {port} is no port: choose one from 1 to 65535, or 0 for any free one")
    if port and not is_free(port):  # viser would silently take the next one
        raise ViewerError(_taken(port))

    import viser

    with own_pages_only(), contextlib.redirect_stdout(io.StringIO()):  # it prints a box of its own
        server = viser.ViserServer(host=HOST, port=port, label=label, verbose=False)
    if port and server.get_port() != port:  # somebody was faster; viser then moves on to the next port
        server.stop()
        raise ViewerError(_taken(port))
    try:
        check_refuses(HOST, server.get_port())
    except ViewerError:
        server.stop()
        raise
    server.scene.set_up_direction("+z")
    return server


def is_free(port: int) -> bool:
    """Whether the server could listen on a port of this machine now."""
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((HOST, port))
        except OSError:
            return False
    return True


def _taken(port: int) -> str:
    return f"port {port} of {HOST} cannot be used (taken?): choose another with --port, or --port 0 for any free one"

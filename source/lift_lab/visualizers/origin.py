"""Check of the pages that may connect to the viewer's server: only those that the server itself has sent.

A page of any site that is open in the same browser can open a websocket to 127.0.0.1. The browser only adds the name of
the site in ``Origin``. A site may also point its own name at 127.0.0.1 (DNS rebinding), so ``Host`` is checked too.
"""

from __future__ import annotations

import contextlib
import http
import re
import socket
import threading
from collections.abc import Iterator
from typing import Any

from lift_lab.utils.errors import LiftLabError

_LOCAL = re.compile(r"(127\.0\.0\.1|localhost|\[::1\])(:\d+)?", re.IGNORECASE)
"""Names of this machine's loopback interface, as in the header ``Host``."""

_patching = threading.Lock()


class ViewerError(LiftLabError, RuntimeError):
    """The viewer cannot do what was asked."""


def refusal(host: str | None, origin: str | None, is_websocket: bool) -> str | None:
    """Return the reason why a request is refused; None if it is not.

    Args:
        host: the header ``Host``: where the browser believes the server is.
        origin: the header ``Origin``: the site of the page that asks.
        is_websocket: whether a websocket is to be opened. For these, browsers always send ``Origin``.
    """
    if host is None or not _LOCAL.fullmatch(host):
        return f"Host '{host}' is no name of this machine's loopback interface"
    if not is_websocket and origin is None:
        return None
    if origin is None or origin.lower() not in (f"http://{host.lower()}", f"https://{host.lower()}"):
        return f"a page of '{origin}' may not use the viewer at '{host}'"
    return None


@contextlib.contextmanager
def own_pages_only() -> Iterator[None]:
    """Let the viser servers that are made meanwhile answer their own pages only.

    viser 1.1 has no setting for it. It calls ``websockets.asyncio.server.serve`` while a server is made; here every
    request passes :func:`refusal` first.
    """
    from websockets.asyncio import server as module

    with _patching:
        serve = module.serve

        def checked(*args: Any, process_request: Any = None, **kwargs: Any) -> Any:
            def check(connection: Any, request: Any) -> Any:
                headers = request.headers
                hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
                is_websocket = headers.get("Upgrade", "").lower() == "websocket"
                host = hosts[0] if len(hosts) == 1 else None
                origin = origins[0] if len(origins) == 1 else None if not origins else ", ".join(origins)
                problem = refusal(host, origin, is_websocket)
                if problem is not None:
                    return connection.respond(http.HTTPStatus.FORBIDDEN, problem + "\n")
                return None if process_request is None else process_request(connection, request)

            return serve(*args, process_request=check, **kwargs)

        module.serve = checked
        try:
            yield
        finally:
            module.serve = serve


def check_refuses(host: str, port: int) -> None:
    """Ask a server as a page of another site would, and expect a refusal.

    Raises:
        ViewerError: it does not refuse, as after a change in viser or websockets.
    """
    request = (
        f"GET / HTTP/1.1\r\nHost: {host}:{port}\r\nOrigin: http://example.com\r\nConnection: Upgrade\r\n"
        "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
    )
    try:
        with socket.create_connection((host, port), timeout=10.0) as connection:
            connection.sendall(request.encode())
            answer = connection.makefile("rb").readline()
    except OSError as error:
        raise ViewerError(f"the viewer's server does not answer: {error.strerror or error}") from error
    if b" 403 " not in answer:
        raise ViewerError(
            "the viewer cannot be kept to its own pages with these versions of viser and websockets: "
            "pip install 'viser==1.1.*' 'websockets<17'"
        )

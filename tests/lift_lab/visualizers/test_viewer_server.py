"""The viewer's server answers on this machine only, and says what is wrong in one line."""

import importlib.util
import socket

import pytest

from lift_lab.utils.errors import MissingPackageError
from lift_lab.visualizers import ViewerError, open_server, require_viser


def test_a_server_listens_on_the_loopback_interface_only():
    pytest.importorskip("viser")
    server = open_server(port=0)
    try:
        assert server.get_host() == "127.0.0.1"
        with socket.create_connection(("127.0.0.1", server.get_port()), timeout=5):
            pass
    finally:
        server.stop()


def test_a_port_that_is_taken_is_named():
    pytest.importorskip("viser")
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(ViewerError, match=rf"^port {port} of 127.0.0.1 cannot be used.*--port 0"):
            open_server(port)


def test_a_number_that_is_no_port_is_refused():
    pytest.importorskip("viser")
    with pytest.raises(ViewerError, match="70000 is no port"):
        open_server(70000)


def test_without_viser_the_error_says_what_to_install(monkeypatch):
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "viser" else find(name))
    with pytest.raises(MissingPackageError, match=r"pip install 'lift-lab\[viewer\]'"):
        require_viser()


@pytest.fixture(scope="module")
def server():
    pytest.importorskip("viser")
    server = open_server(port=0)
    yield server
    server.stop()


def handshake(port, host, origin):
    """Ask for a websocket; the status of the answer."""
    lines = [f"Host: {host}", "Connection: Upgrade", "Upgrade: websocket", "Sec-WebSocket-Version: 13"]
    lines += ["Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==", *([f"Origin: {origin}"] if origin is not None else [])]
    with socket.create_connection(("127.0.0.1", port), timeout=5) as connection:
        connection.sendall("\r\n".join(["GET / HTTP/1.1", *lines, "", ""]).encode())
        return int(connection.makefile("rb").readline().split()[1])


@pytest.mark.parametrize("name", ["127.0.0.1", "localhost"])
@pytest.mark.parametrize("port_seen", [None, 9000], ids=["direct", "through a tunnel"])
def test_its_own_page_opens_a_websocket(server, name, port_seen):
    host = f"{name}:{port_seen or server.get_port()}"
    assert handshake(server.get_port(), host, f"http://{host}") == 101


@pytest.mark.parametrize(
    ("host", "origin"),
    [
        ("127.0.0.1:{port}", "http://example.com"),
        ("127.0.0.1:{port}", "http://127.0.0.1:{other}"),  # another server on this machine
        ("127.0.0.1:{port}", "http://127.0.0.1:{port}.example.com"),
        ("127.0.0.1:{port}", "null"),  # a file, or a sandboxed frame
        ("127.0.0.1:{port}", None),
        ("example.com:{port}", "http://example.com:{port}"),  # DNS rebinding
        ("example.com", "http://127.0.0.1:{port}"),
        ("127.0.0.1:{port}\r\nHost: example.com", "http://127.0.0.1:{port}"),
    ],
)
def test_no_other_page_opens_a_websocket(server, host, origin):
    port = server.get_port()
    values = {"port": port, "other": port - 1}
    assert handshake(port, host.format(**values), origin and origin.format(**values)) in (400, 403)


def test_a_server_that_lets_every_page_in_is_not_used(monkeypatch):
    pytest.importorskip("viser")
    monkeypatch.setattr("lift_lab.visualizers.origin.refusal", lambda *_: None)
    with pytest.raises(ViewerError, match="cannot be kept to its own pages"):
        open_server(port=0)

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

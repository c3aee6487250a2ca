"""What a browser shows: a viser server on this machine, the bodies of every environment, and markers.

Importing this package loads neither viser nor trimesh; opening a server does.
"""

from .body_layer import BodyLayer
from .marker_layer import MarkerLayer
from .server import DEFAULT_PORT, ViewerError, is_free, open_server, require_viser

__all__ = ["DEFAULT_PORT", "BodyLayer", "MarkerLayer", "ViewerError", "is_free", "open_server", "require_viser"]

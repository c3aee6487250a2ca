"""Scene in a browser: a viser server on this machine, the bodies of every environment, markers, frames, contacts.

Importing this package loads neither viser nor trimesh; opening a server does.
"""

from .body_layer import BodyLayer
from .contact_layer import ContactLayer
from .contacts import Contact, contacts_of, sum_by_pair
from .frame_layer import FrameLayer
from .marker_layer import MarkerLayer
from .server import DEFAULT_PORT, ViewerError, is_free, open_server, require_viser
from .world import WORLD, World

__all__ = [
    "DEFAULT_PORT",
    "WORLD",
    "BodyLayer",
    "Contact",
    "ContactLayer",
    "FrameLayer",
    "MarkerLayer",
    "ViewerError",
    "World",
    "contacts_of",
    "is_free",
    "open_server",
    "require_viser",
    "sum_by_pair",
]

"""The lift task: pick up an object and bring it to a commanded position."""

"""The lift task, robot by robot."""

"""The reach task, robot by robot."""

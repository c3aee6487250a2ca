"""The cabinet task, robot by robot."""

"""The reach task: bring the end effector to a commanded pose."""

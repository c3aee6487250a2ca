"""Helpers of environments, at Isaac Lab's module paths."""

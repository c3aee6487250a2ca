"""Isaac Lab's module path of helpers of environments."""

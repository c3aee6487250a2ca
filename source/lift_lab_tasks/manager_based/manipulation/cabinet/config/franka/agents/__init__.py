"""Learning settings of the Franka cabinet task."""

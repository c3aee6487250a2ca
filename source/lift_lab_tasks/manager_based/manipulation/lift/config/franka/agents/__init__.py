"""Learning settings of the Franka lift tasks."""

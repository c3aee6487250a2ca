"""Learning settings of the Franka reach tasks."""

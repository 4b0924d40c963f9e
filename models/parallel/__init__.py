"""Parallel machines of Roldan's thesis: kinematics and rigid-body dynamics in actuated coordinates."""

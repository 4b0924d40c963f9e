"""Workspaces of the parallel machines: what they reach, beside what the sources print."""

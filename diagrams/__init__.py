"""Wiring: one module per closed loop, each returning a built Diagram with named ports."""

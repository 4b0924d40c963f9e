"""Mechatronic studies of parallel machines: actuators, control and machine together (Roldan, chapter 4)."""

"""Servo axes, their cascaded loops, and a parallel machine as their load (Roldan, chapter 3)."""

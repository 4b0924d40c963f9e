"""Identification of the dynamic parameters of closed chains (Roldan, chapters 5 and 6)."""

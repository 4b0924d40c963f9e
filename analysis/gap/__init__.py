"""The instrument: where the sim-to-real gap lies, what causes it, how far it shrinks."""

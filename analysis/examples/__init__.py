"""Examples that a reader can learn from; each is run by a test."""

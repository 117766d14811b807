"""Algorithms that decide how the platform moves, and the one module that composes them (`design`)."""

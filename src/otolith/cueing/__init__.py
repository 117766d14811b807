"""Algorithms that decide how the platform moves, and the one place where they are put together."""

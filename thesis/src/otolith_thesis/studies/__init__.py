"""Experiments that decide between readings of the thesis, and examine why our numbers differ from its own."""

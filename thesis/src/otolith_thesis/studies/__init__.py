"""Experiments that decide between readings of the thesis, and test why our numbers differ from its."""

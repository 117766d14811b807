"""Hints: guesses of the working set from offline knowledge. They save time and cannot change an answer."""

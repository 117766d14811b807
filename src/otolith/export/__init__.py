"""Algorithms that leave Python: programs in C, and what is made of them for other hosts."""

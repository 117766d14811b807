"""Clocks and sockets of live operation; everything else is pure."""

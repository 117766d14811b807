"""Drivers of motion platforms: set-points to bytes and bytes to feedback; no socket, no clock."""

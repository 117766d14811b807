"""Packets of telemetry sources: described as data, decoded into `Telemetry`; no socket, no clock, no
state.
"""

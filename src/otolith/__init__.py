"""Otolith: motion cueing for driving simulators.

Turns what a vehicle's driver would feel into what a motion platform should do, and measures how
well. Start with `otolith run` on the command line, or with `docs/` for the Python interface.
"""

__version__ = "0.1.0"

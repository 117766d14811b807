"""Events in a recorded drive that are not driving: found, named with time and size, cut out on request."""

from otolith.scenarios.events.event import Event
from otolith.scenarios.events.find import TREATMENTS, cut, find_events, parse_events, refuse, shortened, told

__all__ = ["TREATMENTS", "Event", "cut", "find_events", "parse_events", "refuse", "shortened", "told"]

"""Events in a recorded drive that are not driving: found, reported with time and size, cut on request."""

from otolith.recordings.events.event import Event
from otolith.recordings.events.find import (
    TREATMENTS,
    after_cut,
    before_cut,
    cut,
    find_events,
    parse_events,
    parted,
    refuse,
    shortened,
    told,
)

__all__ = [
    "TREATMENTS",
    "Event",
    "after_cut",
    "before_cut",
    "cut",
    "find_events",
    "parse_events",
    "parted",
    "refuse",
    "shortened",
    "told",
]

"""Events in a recorded drive that are not driving: found, reported with time and size, cut on request."""

from otolith.recordings.events.event import Event
from otolith.recordings.events.find import (
    TREATMENTS,
    after_cut,
    before_cut,
    cut,
    event_notes,
    find_events,
    parse_events,
    refuse,
    shortened,
    with_holes,
)

__all__ = [
    "TREATMENTS",
    "Event",
    "after_cut",
    "before_cut",
    "cut",
    "event_notes",
    "find_events",
    "parse_events",
    "refuse",
    "shortened",
    "with_holes",
]

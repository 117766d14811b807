"""How a recorded drive was understood, whether or not it is accepted, for `otolith log check`."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from otolith.core.errors import InputError
from otolith.recordings.channels import Recording
from otolith.recordings.checks.drive import all_relations
from otolith.recordings.checks.kinematics import Kinematics
from otolith.recordings.checks.relations import Relation
from otolith.recordings.checks.remedies import spelled
from otolith.recordings.events import Event, cut, find_events, with_holes
from otolith.recordings.logs import Log, played
from otolith.recordings.reading import recording
from otolith.recordings.recorded import Recorded
from otolith.recordings.settings import LogSettings


@dataclass(frozen=True, kw_only=True, eq=False)
class Understanding:
    """A recorded drive as its file states it and, if it is accepted, as it will be played."""

    stated: Recording  # as the file and the mapping state it, before any check
    log: Log | None  # as it will be played; None if the drive is refused
    refusal: str  # why it is refused, with the remedies; empty if it is accepted
    settings: LogSettings
    events: tuple[Event, ...]
    relations: tuple[Relation, ...]

    @property
    def played(self) -> Recording:
        """Return the drive as it will be played or, if it is refused, as the file states it."""
        return self.stated if self.log is None else replace(self.stated, channels=self.log.channels)

    @property
    def turned(self) -> tuple[str, ...]:
        """Return the quantities whose sign was turned in addition to the mapping."""
        return () if self.log is None or self.log.found is None else self.log.found.turned

    def mapping(self) -> LogSettings:
        """Return settings that read this file, and files like it, without further options."""
        columns = {
            key: spelled(one.column) for key, one in self.stated.channels.items() if one.column.index >= 0
        }
        columns = {**self._clock(), **columns, **self.settings.columns}
        sides = {"ay", "yaw_rate"} & set(self.turned)
        return replace(
            self.settings, columns=columns, needs=(), axes=self.settings.axes or ("sae" if sides else None)
        )

    def _clock(self) -> Mapping[str, str]:
        name = self.stated.layout.clock_name
        return {"t": name} if name else {}


def understand(recorded: Recorded, settings: LogSettings) -> Understanding:
    """Read and check a drive; a refusal becomes part of the result.

    Raises
    ------
    InputError : the file has no columns that can be read as a drive.
    """
    stated = recording(recorded, columns=settings.columns, needs=settings.needs)
    try:
        log = played(stated, settings)
    except InputError as error:
        events = find_events(stated)
        driving = Kinematics(cut(stated, with_holes([event for event in events if event.sure])).channels)
        return Understanding(
            stated=stated,
            log=None,
            refusal=str(error),
            settings=settings,
            events=events,
            relations=all_relations(driving),
        )
    found = log.found
    return Understanding(
        stated=stated,
        log=log,
        refusal="",
        settings=settings,
        events=() if found is None else found.events,
        relations=() if found is None else found.relations,
    )

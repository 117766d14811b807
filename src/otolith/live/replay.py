"""Replays a log: new cores, made alike, are told what those of the session were told, at the same times.

What they say has to be equal bit for bit, every plan and every set-point. Where it is not, the cores are not
the same (another version, another machine), or they decide on something that is not in the log. Where ticks
are missing in the log, a core cannot know what it was told in them, and its comparison ends.
"""

import zlib
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from otolith.live.controller import Controller, ControllerInbox
from otolith.live.log import Kind, meaning, set_point
from otolith.live.output import Output, OutputInbox
from otolith.live.packed import pack_plan
from otolith.live.records import Record


@dataclass(slots=True)
class Compared:
    """What became of the answers of one core."""

    what: str  # "plans" or "set-points"
    compared: int = 0
    different: int = 0
    first: str = ""  # the first difference, in words
    lost: int = 0  # ticks that are not in the log …
    after: int = 0  # … and those after the first of them, which are not compared
    seconds: float = 0.0  # from the first tick to the last that was compared

    def differs(self, how: str) -> None:
        """Take note of a difference."""
        self.different += 1
        self.first = self.first or how


class ReplayedController:
    """The controller's core, told what is in the log."""

    def __init__(self, core: Controller) -> None:
        self._core, self._inbox = core, ControllerInbox()
        self.seen = Compared("plans")

    def hear(self, kind: int, value: Any) -> None:
        """Keep what the core will be told in its next tick."""
        if kind == Kind.TELEMETRY:
            self._inbox = replace(self._inbox, packets=(*self._inbox.packets, value))
        elif kind == Kind.REPORT:
            self._inbox = replace(self._inbox, report=value)
        elif kind == Kind.CHANGE:
            self._inbox = replace(self._inbox, change=value)

    def tick(self, ends: Any, _: bytes) -> None:
        """Let the core decide, and compare."""
        plan = self._core.tick(int(ends["time"]), replace(self._inbox, missed=int(ends["missed"])))
        self._inbox = ControllerInbox(report=self._inbox.report)
        if (plan.sequence, zlib.crc32(pack_plan(plan))) != (ends["sequence"], ends["checksum"]):
            self.seen.differs(f"plan {ends['sequence']}")


class ReplayedOutput:
    """The output's core, told what is in the log."""

    def __init__(self, core: Output) -> None:
        self._core, self._inbox = core, OutputInbox()
        self.seen = Compared("set-points")

    def hear(self, kind: int, value: Any) -> None:
        """Keep what the core will be told in its next tick."""
        if kind == Kind.PLAN:
            self._inbox = replace(self._inbox, plan=value)
        elif kind == Kind.MEASURED:
            self._inbox = replace(self._inbox, feedback=value[1])
        elif kind == Kind.WORDS:
            self._inbox = replace(self._inbox, words=value)
        elif kind == Kind.REACTION:
            self._inbox = replace(self._inbox, reaction=value)

    def tick(self, ends: Any, payload: bytes) -> None:
        """Let the core make its set-point, and compare."""
        now_ns, page = int(ends["time"]), int(ends["page"])
        inbox = replace(self._inbox, beats=int(ends["beats"]), page=None if page < 0 else page)
        out = self._core.tick(now_ns, inbox)
        self._inbox = OutputInbox()
        if set_point(now_ns, inbox, out) != payload:
            off = np.abs(out.report.motion - ends["motion"]).max(axis=1)
            which = f"set-point {self.seen.compared + 1}, {self.seen.seconds:.3f} s after the first"
            self.seen.differs(f"{which}: pose, twist and acceleration by up to {off} (SI units)")


class Replay:
    """Both cores, told what is in the log.

    Parameters
    ----------
    controller, output : new cores; None for one that is left out.
    source : the log's name, for errors.
    """

    def __init__(self, controller: Controller | None, output: Output | None, source: str) -> None:
        self._source = source
        self._cores: dict[int, ReplayedController | ReplayedOutput] = {}
        if controller is not None:
            self._cores[Kind.DECISION] = ReplayedController(controller)
        if output is not None:
            self._cores[Kind.SET_POINT] = ReplayedOutput(output)
        self._begun: dict[int, int] = {}  # [ns] the first tick of each core
        self._lost = 0

    @property
    def seen(self) -> tuple[Compared, ...]:
        """Return what was compared until now."""
        return tuple(core.seen for core in self._cores.values())

    def take(self, records: Iterable[Record]) -> None:
        """Take in records.

        Raises
        ------
        CorruptFile : a record is damaged; what was compared until then holds.
        """
        for one in records:
            value = meaning(one, self._source)
            if one.kind == Kind.LOST:
                self._lost = value
            elif one.kind in {Kind.DECISION, Kind.SET_POINT}:
                self._tick(one, value)
            else:
                for core in self._cores.values():
                    core.hear(one.kind, value)

    def _tick(self, one: Record, ends: Any) -> None:
        """End a tick of the core that the record is of; what was lost before it is of the same core."""
        lost, self._lost = self._lost, 0
        core = self._cores.get(one.kind)
        if core is None:
            return
        core.seen.lost += lost
        if core.seen.lost:
            core.seen.after += 1
            return
        begun = self._begun.setdefault(one.kind, int(ends["time"]))
        core.seen.seconds = 1e-9 * (int(ends["time"]) - begun)
        core.tick(ends, one.payload)
        core.seen.compared += 1

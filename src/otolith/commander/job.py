"""What a run is for the worker; the command line makes it, of the same parts as `otolith run`."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

from otolith.loop import ClosedLoop


class Job(Protocol):
    """One run, ready to be advanced: a closed loop, or two of two algorithms on the same reference."""

    @property
    def loops(self) -> Sequence[ClosedLoop]:
        """Return the loops, that of algorithm A first."""

    @property
    def command(self) -> str:
        """Return the command line that makes the same run."""

    @property
    def folder(self) -> Path:
        """Return the folder of the results."""

    @property
    def hexapod(self) -> Mapping[str, Any] | None:
        """Return joints, neutral lengths and stroke of the legs [m]; None without legs."""

    @property
    def map(self) -> Mapping[str, Any] | None:
        """Return the course of the drive, x and y [m]; None if the drive has none."""

    def change(self, name: str, value: float) -> None:
        """Change a parameter from the next decision on.

        Raises
        ------
        InputError : no algorithm of this run has the parameter.
        """

    def finish(self, changes: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
        """Write the results of what was run.

        Returns what pages are told: `summary`, `second` (that of algorithm B, or None), and `false_cues`.

        Parameters
        ----------
        changes : what was changed by hand while it ran, a stop included, each with its time.
        """


# Makes a job of the form's values; what is to be noted on the way, it tells as sentences. The last argument
# names the folder of the results.
Maker = Callable[[Mapping[str, Any], Callable[[str], None], str], Job]

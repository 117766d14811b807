"""What must have been tested before a session may arm: that this host wakes in time, and the device's axes.

Both tests leave a record in the user's folder of state: `otolith live check` one of this host and its system,
`otolith live axis` one of the device as its settings and its platform describe it. A record of another host,
of another system (an update may have replaced a real-time kernel), or of settings that were changed since, is
none.
"""

import hashlib
import json
import os
import platform as machine
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from otolith.core.disk import read_text, write_text
from otolith.core.errors import CorruptFile
from otolith.live.core.times import Times
from otolith.live.session import Session

LATEST: Final = 2e-3  # [s] that 99.9 % of the output's wake-ups may be late at most
_AXES: Final = "axis-tests.json"
_HOST: Final = "self-test.json"
MOST: Final = 1000  # devices whose tests are kept


def state_folder() -> Path:
    """Return the folder where this program keeps what it has to remember."""
    base = os.environ.get("LOCALAPPDATA") or os.environ.get("XDG_STATE_HOME")
    return Path(base or Path.home() / ".local" / "state") / "otolith"


@dataclass(frozen=True, slots=True, kw_only=True)
class SelfTest:
    """How punctual the output was in a test; times in seconds."""

    host: str
    system: str  # name and version of the kernel
    date: str
    seconds: float
    real_time: bool  # whether real-time scheduling was granted
    median: float
    p99: float
    p999: float
    largest: float

    @classmethod
    def of(cls, late: Times, *, seconds: float, real_time: bool) -> "SelfTest":
        """Return the record of a test on this host, made now."""
        share = (1e-9 * late.share(one) for one in (0.5, 0.99, 0.999, 1.0))
        median, p99, p999, largest = share
        return cls(
            host=machine.node(),
            system=f"{machine.system()} {machine.release()}",
            date=time.strftime("%Y-%m-%d %H:%M"),
            seconds=seconds,
            real_time=real_time,
            median=median,
            p99=p99,
            p999=p999,
            largest=largest,
        )

    @property
    def punctual(self) -> bool:
        """Whether the output wakes in time often enough to arm."""
        return self.p999 <= LATEST

    def keep(self) -> Path:
        """Write the record in place of the one before; return where it is."""
        path = state_folder() / _HOST
        path.parent.mkdir(parents=True, exist_ok=True)
        write_text(path, json.dumps(asdict(self), indent=1) + "\n")
        return path


def why_late(*, real_time: bool) -> str:
    """Return why this host may not drive a platform; empty if it may.

    Parameters
    ----------
    real_time : whether real-time scheduling is granted now.
    """
    found = _read(_HOST)
    if not found:
        return "this host has not been tested: run 'otolith live check', or give --allow-jitter"
    try:
        test = SelfTest(**found)
    except TypeError as error:
        raise CorruptFile(f"{state_folder() / _HOST} is no self-test: {error}") from error
    now = SelfTest.of(Times(), seconds=0.0, real_time=real_time)
    for what in ("host", "system", "real_time"):
        if getattr(test, what) != getattr(now, what):
            words = "real-time scheduling granted" if what == "real_time" else what
            changed = f"{words} was {getattr(test, what)}, is {getattr(now, what)}"
            return (
                f"the self-test of {test.date} does not count any more ({changed}): run 'otolith live check'"
            )
    if not test.punctual:
        bound = f"must be at most {1e3 * LATEST:g} ms"
        return (
            f"99.9 % of wake-ups were up to {1e3 * test.p999:.3g} ms late in the self-test of {test.date}, "
            f"{bound}; --allow-jitter overrules this"
        )
    return ""


def digest(session: Session) -> str:
    """Return the mark of all that says how a set-point becomes motion: settings of the device, platform."""
    stated = {
        "device": session.settings.device.model_dump(mode="json"),
        "legs": None
        if session.platform.hexapod is None
        else session.platform.hexapod.model_dump(mode="json"),
        "axes": sorted(session.platform.axes),
    }
    return hashlib.sha256(json.dumps(stated, sort_keys=True).encode()).hexdigest()


def why_untested(session: Session) -> str:
    """Return why the axes of a session's device count as untested; empty if they are tested."""
    if digest(session) in _read(_AXES):
        return ""
    device = session.settings.device
    return (
        f"the axes of {device.kind} at {device.address} are not tested, or its settings have changed: "
        "run 'otolith live axis'"
    )


def keep_axis_test(session: Session, axes: list[str]) -> Path:
    """Write down that a person saw these axes of a session's device move as they should."""
    path = state_folder() / _AXES
    path.parent.mkdir(parents=True, exist_ok=True)
    kept = _read(_AXES)
    kept.pop(digest(session), None)
    kept = dict(list(kept.items())[1 - MOST :])
    device = session.settings.device
    kept[digest(session)] = {
        "date": time.strftime("%Y-%m-%d %H:%M"),
        "device": f"{device.kind} at {device.address}",
        "axes": axes,
    }
    write_text(path, json.dumps(kept, indent=1) + "\n")
    return path


def _read(name: str) -> dict[str, Any]:
    path = state_folder() / name
    if not path.exists():
        return {}
    try:
        found = json.loads(read_text(path, "record of tests"))
    except ValueError as error:
        raise CorruptFile(f"{path} is no JSON: {error}") from error
    if not isinstance(found, dict):
        raise CorruptFile(f"{path} is {type(found).__name__}, must be an object")
    return found

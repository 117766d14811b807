"""A small hint for the thesis's platform in 2 DOF, made once per process; a helper of the tests."""

from functools import cache

from otolith.core.frames import SURGE_PITCH
from otolith.cueing.hints.stored import StoredHint
from otolith.cueing.hints.training.build import build
from otolith.cueing.hints.training.fit import Effort
from otolith.cueing.hints.training.manoeuvres import Manoeuvre, along
from otolith.cueing.hints.training.recording import Recording, record
from otolith.cueing.mpc.settings import MpcSettings
from otolith.platforms import load
from otolith.scenarios.waves import Pulse, Sine

THESIS, PAIRS, SETTINGS = load("thesis"), (SURGE_PITCH,), MpcSettings()
SEEN = (Manoeuvre("pulse", 4.0, Pulse(1.0, 0.5, 2.5)), Manoeuvre("sine", 6.0, Sine(1.5, 0.3, 0.2)))
UNSEEN = (Manoeuvre("another pulse", 3.0, Pulse(-0.8, 0.7, 1.9)),)

EFFORT = Effort(layers=(16,), passes=30, batch=32, entries=100, levels=2)


@cache
def tiny_hint() -> StoredHint:
    """Learned from ten seconds of driving."""
    return build(THESIS, PAIRS, SETTINGS, manoeuvres=SEEN, effort=EFFORT)


@cache
def unseen_recording() -> Recording:
    """Three seconds of another drive."""
    return recording_of(SETTINGS)


def recording_of(settings: MpcSettings) -> Recording:
    """The same three seconds with other settings."""
    return record(THESIS, PAIRS, settings, along(UNSEEN, PAIRS), plans=True)

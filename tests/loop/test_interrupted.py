"""Outages of a reference, seen by an algorithm that only listens."""

import numpy as np

from otolith.interfaces import Command, Outcome, PlatformState, Reference, Status
from otolith.loop.interrupted import Interrupted, Outage


class Listener:
    period = 0.1

    def __init__(self) -> None:
        self.received: list[float] = []

    def reset(self, state: PlatformState) -> None:
        self.received = []

    def step(self, state: PlatformState, reference: Reference) -> Command:
        self.received.append(float(reference.specific_force[0]))
        zero, outcome = np.zeros(6), Outcome(status=Status.DECIDED)
        return Command(acceleration=zero, pose=zero, twist=zero, plan=np.zeros((0, 6)), outcome=outcome)


def test_outages_begin_with_their_start_end_before_their_end_and_are_the_same_after_reset() -> None:
    listener = Listener()
    broken = Interrupted(listener, [Outage(start=0.3, end=0.5), Outage(start=0.7, end=0.75, value=1e7)])
    for _ in range(2):
        broken.reset(PlatformState())
        for _ in range(10):
            broken.step(PlatformState(), Reference(specific_force=np.array([2.0, 0.0, 0.0])))
        np.testing.assert_array_equal(
            listener.received, [2.0, 2.0, 2.0, np.nan, np.nan, 2.0, 2.0, 1e7, 2.0, 2.0]
        )
    assert broken.period == 0.1

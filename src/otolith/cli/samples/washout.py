"""A cueing algorithm of one's own in a few lines: a second-order high-pass of the longitudinal force.

Run it with `otolith run sine-1 --cueing washout.py:HighPass`, compare it with others by `otolith compare`, or
run this file directly by `python washout.py`. Any object with `period`, `reset` and `step` as below is a
cueing algorithm (see `otolith.Cueing`) and is simulated, judged and drawn like the shipped ones.
"""

import numpy as np

import otolith
from otolith import Command, Outcome, PlatformState, Reference, Status

SURGE = otolith.SURGE_PITCH.translation  # index among surge, sway, heave, roll, pitch, yaw


class HighPass:
    """The platform accelerates as the vehicle does, and a spring with a damper returns it to its middle."""

    period = 0.01  # [s] between two decisions

    def __init__(self, natural: float = 1.5) -> None:
        self.stiffness, self.damping = natural**2, 2.0 * natural  # [1/s²], [1/s]

    def reset(self, state: PlatformState) -> None:
        """Do nothing: this algorithm has no memory besides the state of the platform."""

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Return the acceleration of the next period, and the state that it leads to."""
        acceleration, pose, twist = np.zeros(6), np.zeros(6), np.zeros(6)
        position, velocity = state.pose[SURGE], state.twist[SURGE]
        a = reference.specific_force[0] - self.damping * velocity - self.stiffness * position
        acceleration[SURGE] = a
        twist[SURGE] = velocity + self.period * a
        pose[SURGE] = position + self.period * velocity + 0.5 * self.period**2 * a
        outcome = Outcome(status=Status.DECIDED)
        return Command(
            acceleration=acceleration, pose=pose, twist=twist, plan=np.zeros((1, 6)), outcome=outcome
        )


if __name__ == "__main__":
    platform = otolith.platform("thesis")
    drive = otolith.scenario("sine:amplitude=0.8,frequency=0.3,duration=8")
    plant = otolith.make_plant("ideal", platform)
    run = otolith.simulate(HighPass(), plant, drive, platform=platform, dofs=("surge-pitch",))
    print(f"RMSE {otolith.summarise(run)['rmse']:.3f} m/s², farthest {abs(run.pose[:, SURGE]).max():.3f} m")

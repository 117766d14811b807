"""The reference of thesis section 6.3: a lap of Hockenheim, filtered by Telban's otolith."""

from typing import Final

from otolith.core.arrays import Mat
from otolith.perception import otoliths, sense
from otolith.recordings import log_scenario
from otolith.scenarios import Scenario
from otolith.scenarios.perceived import perceived
from otolith.vehicle.car import load_car
from otolith.vehicle.closed_loop import drive
from otolith.vehicle.driver import Driver
from otolith.vehicle.roads import road

SPEEDS: Final = (80, 100, 120)  # [km/h] speeds of Tables 6.4 and 6.5


def hockenheim_reference(speed: float, *, standing: bool = True, period: float = 0.01) -> Scenario:
    """Return what should be felt on a lap with at most `speed` [km/h], longitudinally and laterally.

    As in the thesis, the reference is the acceleration of the car, without the contribution of body roll and
    pitch at the driver's head, filtered by eq. 6.4 and nothing else. It starts from standstill, because the
    hairpin with the longest braking then comes at 80 s, where the thesis sees its hardest braking.

    Parameters
    ----------
    period : [s] of the controller; the reference has no content above its anti-alias filter.
    """
    lap = drive(road("hockenheim").limited(speed / 3.6), load_car(), Driver(), standing=standing)
    driven = log_scenario(lap.as_log(at_head=False), period=period)

    def otolith(force: Mat, dt: float) -> Mat:
        return sense(otoliths.telban(), force, dt, before=force[0])

    return perceived(driven, otolith, name="the otolith of eq. 6.4")

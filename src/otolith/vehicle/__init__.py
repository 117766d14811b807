"""A virtual drive: road, driver and car, and what the driver feels along the way.

Roads are imported at once; car, driver and drive are imported on first use.
"""

from typing import TYPE_CHECKING

from otolith.core.lazy import on_first_use
from otolith.vehicle.road import Road
from otolith.vehicle.roads import ROADS, road

if TYPE_CHECKING:
    from otolith.vehicle.car import Car, load_car, parse_car
    from otolith.vehicle.centreline import parse_centreline, parse_gpx
    from otolith.vehicle.closed_loop import drive
    from otolith.vehicle.driver import Driver
    from otolith.vehicle.lap import Lap
else:
    __getattr__ = on_first_use(
        __name__,
        {
            "Car": "car",
            "Driver": "driver",
            "Lap": "lap",
            "drive": "closed_loop",
            "load_car": "car",
            "parse_car": "car",
            "parse_centreline": "centreline",
            "parse_gpx": "centreline",
        },
    )

__all__ = [
    "ROADS",
    "Car",
    "Driver",
    "Lap",
    "Road",
    "drive",
    "load_car",
    "parse_car",
    "parse_centreline",
    "parse_gpx",
    "road",
]

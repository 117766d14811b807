"""A virtual drive: road, driver and car, and what the driver feels along the way."""

from otolith.vehicle.car import Car, load_car, parse_car
from otolith.vehicle.centreline import parse_centreline, parse_gpx
from otolith.vehicle.closed_loop import drive
from otolith.vehicle.driver import Driver
from otolith.vehicle.lap import Lap
from otolith.vehicle.road import Road
from otolith.vehicle.roads import ROADS, road

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

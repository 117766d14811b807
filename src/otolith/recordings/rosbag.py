"""Recorded drives of ROS 1 and ROS 2, as bags and MCAP, read through rosbags (extra `logs`).

The reader takes inertial units (sensor_msgs/Imu: by REP 103 in x forward, y left, z up, in SI units, with
gravity) and, for checks, the forward speed of odometry (nav_msgs/Odometry, geometry_msgs/TwistStamped) and
the position of satellites (sensor_msgs/NavSatFix). If there are several inertial units, the name of each
channel includes its topic, so that the user can choose. A covariance that begins with -1 marks a quantity
that the unit does not measure (sensor_msgs/Imu), and a status of -1 marks a missing fix
(sensor_msgs/NavSatStatus).
"""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Final

import numpy as np
from rosbags.highlevel import AnyReader, AnyReaderError
from rosbags.typesys import Stores, get_typestore

from otolith.core.arrays import Vec
from otolith.core.errors import CorruptFile, InputError
from otolith.recordings.channels import Layout
from otolith.recordings.recorded import Columns, Signal, with_own_clocks

AXES: Final = ("x", "y", "z")
IMU: Final = "sensor_msgs/msg/Imu"
SPEEDS: Final[dict[str, Callable[[Any], float]]] = {
    "nav_msgs/msg/Odometry": lambda message: message.twist.twist.linear.x,
    "geometry_msgs/msg/TwistStamped": lambda message: message.twist.linear.x,
}
FIX: Final = "sensor_msgs/msg/NavSatFix"
NO_ESTIMATE: Final = -1.0  # first element of a covariance: its quantity was not measured
FIELDS: Final = (("linear_acceleration", "m/s^2"), ("angular_velocity", "rad/s"))


def read_rosbag(path: Path) -> Columns:
    """Read specific force, angular rate, speed and position from a bag, each on its own clock.

    Raises
    ------
    CorruptFile : rosbags cannot read the file.
    InputError : the bag has no inertial unit with two messages.
    """
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as reader:
            units = [c for c in reader.connections if c.msgtype == IMU and c.msgcount > 1]
            fixes = [c for c in reader.connections if c.msgtype == FIX and c.msgcount > 1]
            speeds = [c for c in reader.connections if c.msgtype in SPEEDS and c.msgcount > 1]
            if not units:
                raise InputError(f"topics of {path.name}", "without one of type Imu", "one or more of them")
            read = [_inertial(reader, c, single=len(units) == 1) for c in units]
            signals = [s for found, _ in read for s in found]
            signals += [_speed(reader, c, single=len(speeds) == 1) for c in speeds]
            signals += [s for c in fixes for s in _place(reader, c, single=len(fixes) == 1)]
    except (AnyReaderError, OSError, ValueError, KeyError) as error:
        raise CorruptFile(f"{path.name} is damaged or no ROS bag: {error}") from error
    notes = tuple(f"{path.name}: {note}" for _, some in read for note in some)
    return with_own_clocks(path.name, signals, Layout(form="ROS bag"), notes)


def _inertial(reader: AnyReader, connection: Any, *, single: bool) -> tuple[list[Signal], list[str]]:
    """Return force and rate of an inertial unit where it measured them, and notes about where it did not."""
    t, messages = _messages(reader, connection)
    prefix = "" if single else f"{connection.topic} "
    signals, notes = [], []
    for name, unit in FIELDS:
        covariances = [getattr(message, f"{name}_covariance") for message in messages]
        measured = np.array([covariance[0] != NO_ESTIMATE for covariance in covariances])
        if not measured.all():
            share = f"in {int((~measured).sum())} of {len(t)} messages"
            notes.append(
                f"{connection.topic} does not measure {name} {share} (its covariance begins with -1)"
            )
        for axis in AXES:
            values = np.array([getattr(getattr(message, name), axis) for message in messages])
            signals.append(Signal(f"{prefix}{name}.{axis}", unit, t[measured], values[measured]))
    return signals, notes


def _place(reader: AnyReader, connection: Any, *, single: bool) -> Iterable[Signal]:
    """Yield latitude and longitude where satellites gave a fix."""
    t, messages = _messages(reader, connection)
    prefix = "" if single else f"{connection.topic} "
    fixed = np.array([message.status.status >= 0 for message in messages])
    for name in ("latitude", "longitude"):
        values = np.array([getattr(message, name) for message in messages])
        yield Signal(f"{prefix}{name}", "deg", t[fixed], values[fixed])


def _speed(reader: AnyReader, connection: Any, *, single: bool) -> Signal:
    t, messages = _messages(reader, connection)
    get = SPEEDS[connection.msgtype]
    name = "speed" if single else f"{connection.topic} speed"
    return Signal(name, "m/s", t, np.array([get(message) for message in messages]))


def _messages(reader: AnyReader, connection: Any) -> tuple[Vec, list[Any]]:
    """Return the senders' time stamps [s], or the recorder's where those are zero, and the messages."""
    t, messages = [], []
    for _, recorded, raw in reader.messages([connection]):
        message: Any = reader.deserialize(raw, connection.msgtype)
        stamp = message.header.stamp
        sent = stamp.sec + 1e-9 * stamp.nanosec
        t.append(sent if sent > 0.0 else 1e-9 * recorded)
        messages.append(message)
    return np.array(t), messages

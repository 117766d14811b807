"""ROS bags as rosbags writes them; skipped where the extra is not installed."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

pytest.importorskip("rosbags", exc_type=ImportError)

from rosbags.rosbag2 import Writer
from rosbags.typesys import Stores, get_typestore

from otolith import files
from otolith.core.errors import CorruptFile, InputError

STORE = get_typestore(Stores.LATEST)
T = np.round(np.arange(0.0, 4.0, 0.01), 3)


def write(path: Path, *topics: str, stamped: bool = True, unmeasured: str = "") -> Path:
    kinds = STORE.types
    vector, header = kinds["geometry_msgs/msg/Vector3"], kinds["std_msgs/msg/Header"]
    imu, stamp = kinds["sensor_msgs/msg/Imu"], kinds["builtin_interfaces/msg/Time"]
    level = kinds["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
    twist, stamped_twist = kinds["geometry_msgs/msg/Twist"], kinds["geometry_msgs/msg/TwistStamped"]
    with Writer(path, version=9) as bag:
        for topic in topics:
            connection = bag.add_connection(topic, imu.__msgtype__, typestore=STORE)
            for t in T:
                ns = round(1e9 * t) if stamped else 0
                message = imu(
                    header=header(stamp=stamp(sec=ns // 10**9 + stamped, nanosec=ns % 10**9), frame_id="imu"),
                    orientation=level,
                    orientation_covariance=np.zeros(9),
                    angular_velocity=vector(x=0.0, y=0.0, z=0.1),
                    angular_velocity_covariance=np.full(9, -1.0 if unmeasured == "angular_velocity" else 0.0),
                    linear_acceleration=vector(x=float(np.sin(t)), y=float(np.cos(t)), z=9.81),
                    linear_acceleration_covariance=np.full(
                        9, -1.0 if unmeasured == "linear_acceleration" else 0.0
                    ),
                )
                bag.write(connection, round(1e9 * (t + 5)), STORE.serialize_cdr(message, imu.__msgtype__))
        speed = bag.add_connection("/speed", stamped_twist.__msgtype__, typestore=STORE)
        for t in T[::5]:
            ns = round(1e9 * t) if stamped else 0
            message = stamped_twist(
                header=header(stamp=stamp(sec=ns // 10**9 + stamped, nanosec=ns % 10**9), frame_id=""),
                twist=twist(linear=vector(x=7.0, y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=0.0)),
            )
            data = STORE.serialize_cdr(message, stamped_twist.__msgtype__)
            bag.write(speed, round(1e9 * (t + 5)), data)
    return path


@pytest.mark.parametrize("stamped", [True, False])
def test_an_inertial_unit_is_read_without_its_gravity(tmp_path: Path, stamped: bool) -> None:
    log = files.read_log(write(tmp_path / "bag", "/imu", stamped=stamped), {})
    assert_allclose(log.force[:, 0], np.sin(log.t), atol=1e-6)
    assert_allclose(log.force[:, 2], 9.81 - 9.80665, atol=1e-9)
    assert_allclose(log.rate[:, 2], 0.1)
    assert any("it holds gravity" in note for note in log.notes)


def test_of_two_units_the_user_chooses(tmp_path: Path) -> None:
    bag = write(tmp_path / "bag", "/imu/front", "/imu/rear")
    with pytest.raises(InputError, match=r"'/imu/rear linear_acceleration.x'"):
        files.read_log(bag, {})
    log = files.read_log(bag, {"ax": "/imu/rear linear_acceleration.x"})
    assert_allclose(log.force[:, 0], np.sin(log.t), atol=1e-6)


def test_what_a_unit_does_not_measure_is_not_read_as_zeros(tmp_path: Path) -> None:
    """By sensor_msgs/Imu a covariance that begins with -1 says that the quantity has no estimate."""
    log = files.read_log(write(tmp_path / "bag", "/imu", unmeasured="angular_velocity"), {})
    assert "yaw_rate" not in log.channels
    assert any("/imu does not measure angular_velocity in 400 of 400 messages" in note for note in log.notes)
    with pytest.raises(
        InputError, match=r"\(ax\) in other is missing \(other: /imu does not measure linear_"
    ):
        files.read_log(write(tmp_path / "other", "/imu", unmeasured="linear_acceleration"), {}, needs=("ax",))


def test_what_holds_no_unit_or_is_no_bag_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"topics of bag is without one of type Imu"):
        files.read_log(write(tmp_path / "bag"), {})
    broken = tmp_path / "x.bag"
    broken.write_bytes(b"#ROSBAG V9.9\n" + bytes(60))
    with pytest.raises(CorruptFile, match=r"x.bag is damaged or no ROS bag"):
        files.read_log(broken, {})

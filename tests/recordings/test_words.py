"""Names of columns, as tools that export drives spell them, and names that must say nothing."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from otolith.recordings.words import interpret, words

SPELLED = {
    "t": "TIME SINCE START (ms)|Time since start in ms|ts_ms|Time|timestamp|stamp_ms|utc (ms)|"
    "SessionTime|elapsed_time|seconds_elapsed|utime|cts|Time Stamp|UTC Time|Device Time|"
    "Sample Time|GPS Time|Interval [ms]|Relative Time|meta_time",
    "ax": "Longitudinal acceleration (G) *canbus|Indicated Longitudinal Acceleration (g)|"
    "m_gForceLongitudinal|mLocalAccel.x|Ax (g)|values.acc_x|"
    "chassis_accelerations.longitudinal|ax|InlineAcc|LongG|LongAccel|G Force Long|GForceX|"
    "longitudinal_acc|accel_x|AccX|accx_can|Car.ax|AccelerationSurge|x_acc|Longacc|g_lon|"
    "Linear Acceleration x (m/s^2)|accelerometer_x|IMU_AccX|G Sensor Long|"
    "Acceleration Sensor(X axis)(g)|linear_acceleration.x|ACCEL_LONG|Lon G|"
    "userAcceleration.x|Acc.X|accG_x",
    "ay": "ay|LateralAcc|LatG|LatAccel|G Force Lat|GForceY|lateral_acc|GPS LatAcc|AccelerationSway|"
    "Latacc|Lat [g]|Car.ay|Lateral acceleration (G)|a_lat_mps2",
    "az": "az|VerticalAcc|VertAccel|G Force Vert|GForceZ|AccelerationHeave|Vert G|z_acc",
    "roll_rate": "RollRate|Gyro Roll Velocity|GyroX|x_rate_of_rotation|roll_rate_degps|Car.RollVel|"
    "rotation_rate.x",
    "pitch_rate": "PitchRate|Gyroscope y (rad/s)|angular_velocity.y|gyr_y|Pitch Rate [deg/s]",
    "yaw_rate": "AVz (deg/s)|GYROSCOPE Yaw (rad/s)|chassis_velocities.yaw|YawRate|Gyro Yaw Velocity|"
    "z_rate_of_rotation|turn rate (deg/s)|Yaw [Deg/Sec]|GyroZ|wz|yawrate|"
    "OrientationYawVelocity|Ang Vel Z|yaw_rate_deg_per_s|Car.YawVel|rotationRateZ",
    "vx": "Speed (kph) *gps|Indicated Vehicle Speed (km/hr)|GPS SPEED (Kmh)|LOCATION Speed ( Kmh)|"
    "chassis_velocities.longitudinal|v|vx|SpeedKmh|v_kmh|Ground Speed|GPS Speed|speed (mph)|"
    "SPEED_KPH|velocity kmh|Car.v|Corr Speed|Speed (OBD)(km/h)|GPS Speed (Meters/second)|"
    "Speed over ground [kn]|vEgo|wheelspeed velocity",
    "lat": "lat|Latitude|GPS Latitude|lat (deg)|gps_lat",
    "lon": "lon|long|Longitude|GPS Longitude|lng",
    "heading": "heading|Course|Bearing|GPS Heading|course over ground (deg)|heading (deg)",
    "x": "x_m|pos_x_m|Position X [m]",
}
NOTHING = (
    "throttle|brake|steering angle [deg]|steer_rate|lap time|TIME_LAP|LapDistPct|Beacon|gx|x|"
    "y|a|acc|acceleration|Accuracy (m)|horizontalAccuracy|GPS LatAccuracy|Car.vy|"
    "lateral velocity|vertical speed|yaw acceleration|wheel speed fl|Vhcl.PoI.ay|target_ax|"
    "planned_speed_mps|level_ax_mps2|platform|Fx [N]|force x|Engine Speed [rpm]|Lat Error|"
    "Long Offset|latitude of start|slip angle|roll|pitch|camber|GRAVITY X (m/s²)|"
    "MAGNETIC FIELD X (μT)|Combined acceleration (G)|Engine Speed (rpm) *obd|G(calibrated)|"
    "expire_at|device_update_rate|fuel rate|frame rate|sample rate|temperature [°C]|"
    "yaw_moment|x [mm/s]|y [deg]|date of birth||1|#|  "
)


@pytest.mark.parametrize(
    ("key", "name"), [(key, name) for key, all_ in SPELLED.items() for name in all_.split("|")]
)
def test_names_of_many_tools_are_told(key: str, name: str) -> None:
    meaning = interpret(name)
    assert meaning is not None
    assert meaning.key == key


@pytest.mark.parametrize("name", NOTHING.split("|"))
def test_names_of_other_things_say_nothing(name: str) -> None:
    assert interpret(name) is None


@pytest.mark.parametrize("name", ["Lat", "Long", "lon", "GPS Lat", "LAT"])
@pytest.mark.parametrize("unit", ["", "deg", "°"])
def test_a_geographic_name_is_never_an_acceleration(name: str, unit: str) -> None:
    meaning = interpret(name, unit)
    assert meaning is not None
    assert meaning.key in ("lat", "lon")


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        ("LateralAcc", ("lateral", "acc")),
        ("x_rate_of_rotation", ("x", "rate", "of", "rotation")),
        ("GForceLong", ("g", "force", "long")),
        ("accx_can", ("acc", "x", "can")),
        ("yawrate", ("yaw", "rate")),
        ("GPSSpeed", ("gps", "speed")),
        ("Querbeschleunigung", ("querbeschleunigung",)),
    ],
)
def test_names_are_parted_into_words(name: str, parts: tuple[str, ...]) -> None:
    assert words(name) == parts


@given(st.text(max_size=40), st.text(max_size=8))
def test_any_name_and_unit_are_read_without_failing(name: str, unit: str) -> None:
    interpret(name, unit)


def test_units_may_be_parted_by_bars() -> None:
    assert interpret("a_x [m|s^2]") == interpret("a_x [m/s^2]")._replace(unit="m|s^2")  # type: ignore[union-attr]

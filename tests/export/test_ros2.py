"""The generated ROS 2 package: its files, and its node run against stubs of rclcpp that need no network."""

import re
import shutil
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.export.ros2 import ros2_package
from tests.export.sled import SLED, SLED_LEGS

STUBS = Path(__file__).parent / "ros2_stubs"
COMPILERS = [shutil.which(name) for name in ("cc", "c++")]
needs_compilers = pytest.mark.skipif(
    None in COMPILERS, reason="no C and C++ compiler (cc, c++) on this machine"
)

GRAVITY = 9.80665


def written(folder: Path, package: dict[str, str]) -> Path:
    for name, text in package.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder


@pytest.fixture(scope="module")
def node(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The node of the sled with legs, compiled against the stubs, all warnings on."""
    folder = written(tmp_path_factory.mktemp("sled"), ros2_package(SLED, SLED_LEGS))
    warnings = ["-Wall", "-Wextra", "-Werror", "-O1", f"-I{folder / 'include'}"]
    run = [str(COMPILERS[0]), "-std=c99", *warnings, "-c", "-o", "program.o", "src/program.c"]
    subprocess.run(run, check=True, cwd=folder)
    run = [str(COMPILERS[1]), "-std=c++17", *warnings, f"-I{STUBS}", "-Isrc", "-o", "node"]
    subprocess.run([*run, str(STUBS / "driver.cpp"), "program.o", "-lpthread"], check=True, cwd=folder)
    return folder / "node"


def drive(node: Path, lines: list[str], *arguments: str) -> np.ndarray:
    """What was published in every period: status, rest, position, quaternion, rates, acceleration, legs."""
    done = subprocess.run(
        [node, *arguments], input="\n".join(lines), capture_output=True, text=True, check=True, timeout=60
    )
    period, *rows = done.stdout.splitlines()
    assert int(period) == 10_000_000  # [ns]
    return np.array([[float(word) for word in row.split()] for row in rows])


STATUS, REST, PLACE, SPEED, ACCELERATION, LEGS = 0, 1, 2, 9, 15, slice(18, 24)


@needs_compilers
def test_what_is_wanted_reaches_the_program_and_its_motion_is_published(node: Path) -> None:
    """Gravity is taken off along z only; turning about z counts."""
    lines = [f"hear 2.0 5.0 {GRAVITY + 0.25} 9.0 9.0 0.5"] * 10
    rows, speed = drive(node, lines, "10"), 0.025 * np.arange(1, 11)
    np.testing.assert_array_equal(rows[:, STATUS], 0)
    np.testing.assert_allclose(rows[:, SPEED], speed, atol=1e-15)
    np.testing.assert_allclose(rows[:, PLACE], 0.01 * np.cumsum(speed), atol=1e-15)
    np.testing.assert_allclose(rows[:, ACCELERATION], 2.5)
    np.testing.assert_allclose(rows[:, ACCELERATION + 2], 0.25, atol=1e-14)
    pose = np.column_stack([rows[:, PLACE], *np.tile([[0.0], [0.0], [0.1], [0.2], [0.3]], 10)])
    np.testing.assert_allclose(rows[:, LEGS], 1.0 + pose, atol=1e-15)


@needs_compilers
def test_the_quaternion_turns_as_the_angles_do(node: Path) -> None:
    """Roll 0.1, pitch 0.2, yaw 0.3: the product of the three turns, yaw first."""
    x, y, z, w = drive(node, ["tick"])[0, 5:9]
    turned = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    (cr, sr), (cp, sp), (cy, sy) = ((np.cos(a), np.sin(a)) for a in (0.1, 0.2, 0.3))
    roll = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    pitch = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    yaw = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    np.testing.assert_allclose(turned, yaw @ pitch @ roll, atol=1e-15)


@needs_compilers
@pytest.mark.parametrize("trouble", ["wait", "stop", "hear nan 0 0", "hear inf 0 0", "hear 0 0 0 0 0 nan"])
def test_without_a_fresh_and_finite_request_the_program_brakes(node: Path, trouble: str) -> None:
    again = "tick" if trouble in ("wait", "stop") else trouble
    rows = drive(node, [*["hear 3.0 0 0"] * 5, trouble, *[again] * 8], "1" if trouble == "wait" else "10")
    assert (rows[:5, STATUS] == 0).all()
    assert (rows[5:, STATUS] == 3).all()
    np.testing.assert_allclose(rows[5:, SPEED], 0.15 * 0.5 ** np.arange(1, 10), atol=1e-15)
    assert not rows[:12, REST].any()
    assert rows[-1, REST]  # 0.15 / 2^9 m/s is below the bound of 1 mm/s


@needs_compilers
def test_it_rests_until_the_first_request_comes_and_follows_after_an_outage(node: Path) -> None:
    rows = drive(node, ["tick", "tick", "hear 1 0 0", "wait", "hear 1 0 0"], "1")
    np.testing.assert_array_equal(rows[:, STATUS], [3, 3, 0, 3, 0])
    np.testing.assert_allclose(rows[:, SPEED], [0.0, 0.0, 0.01, 0.005, 0.015], atol=1e-15)


@needs_compilers
def test_legs_are_told_nothing_for_a_pose_beyond_their_reach(node: Path) -> None:
    rows = drive(node, ["hear 100 0 0"] * 40, "10")
    beyond = rows[:, PLACE] > 0.5
    assert 5 < beyond.sum() < 35
    assert np.isfinite(rows).all()
    np.testing.assert_allclose(rows[~beyond, 18], 1.0 + rows[~beyond, PLACE], atol=1e-15)
    np.testing.assert_array_equal(rows[beyond, 18], rows[~beyond, 18][-1])  # the last that was published


@needs_compilers
def test_rates_that_were_not_measured_count_as_none(node: Path) -> None:
    assert drive(node, ["unmeasured 1 0 0"], "10")[0, ACCELERATION] == 1.0


@needs_compilers
def test_parameters_are_checked(node: Path) -> None:
    assert drive(node, ["tick"], "10", "6")[0, 18] == 0.75
    for arguments, sentence in (
        (["0"], "parameter timeout is 0.000000 s, must be greater than 0"),
        (["nan"], "parameter timeout is nan s"),
        (["1", "5"], "parameter leg_zero has 5 values, must have 6"),
    ):
        done = subprocess.run([node, *arguments], input="", capture_output=True, text=True, check=False)
        assert done.returncode == 2
        assert sentence in done.stderr


def test_the_package_is_complete_and_names_agree() -> None:
    package = ros2_package(SLED, SLED_LEGS)
    described = ET.fromstring(package["package.xml"])
    assert described.findtext("name") == "sled"
    assert re.fullmatch(r"\d+\.\d+\.\d+", described.findtext("version") or "")
    needs = {e.text for e in described.iter("depend")} | {"ament_cmake"}
    assert set(re.findall(r"find_package\((\w+) REQUIRED\)", package["CMakeLists.txt"])) == needs
    assert "project(sled C CXX)" in package["CMakeLists.txt"]
    compile(package["launch/cueing.launch.py"], "launch", "exec")
    assert package["config/parameters.yaml"].startswith("sled:\n  ros__parameters:\n")
    assert not [name for name, text in package.items() if re.search(r"@[A-Z_]+@", text)]


def test_a_platform_without_legs_has_no_topic_for_them() -> None:
    package = ros2_package(SLED)
    assert "#define HAS_LEGS 0" in package["include/program.hpp"]
    assert "include/sled_legs.h" not in package


@pytest.mark.parametrize("name", ["Sled", "my__sled", "s", "sled_"])
def test_a_name_that_ros_does_not_take_is_refused(name: str) -> None:
    other = type(SLED)(name=name, period=0.01, inputs=SLED.inputs, outputs=SLED.outputs, header="")
    with pytest.raises(InputError, match="name of the ROS package"):
        ros2_package(other)

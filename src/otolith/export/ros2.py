"""An exported program as a package of ROS 2: a node in C++, its launch file and its parameters.

The node hears what should be felt as `sensor_msgs/Imu`, whose axes are those of Otolith (x forward, y left,
z up), decides once per period by a timer, and publishes pose, rates and acceleration of the platform, and the
set-points of its legs as `std_msgs/Float64MultiArray`, which position controllers of ros2_control take. The
texts are templates in `ros2/`, where @WORDS@ stand for what differs between programs.
"""

import re
from importlib.resources import files
from typing import Final

from otolith import __version__
from otolith.compiled import STATUSES
from otolith.core.errors import InputError
from otolith.core.frames import AXES
from otolith.export.program import Program, check_free, check_name

_PLACES: Final = {
    "package.xml.in": "package.xml",
    "CMakeLists.txt.in": "CMakeLists.txt",
    "program.c.in": "src/program.c",
    "program.hpp.in": "include/program.hpp",
    "node.cpp.in": "src/node.cpp",
    "launch.py.in": "launch/cueing.launch.py",
    "parameters.yaml.in": "config/parameters.yaml",
}  # templates, and the files of the package that they become
_CODE: Final = ("node.cpp.in", "program.hpp.in")  # what is compiled together with the program's header
_WANTED: Final = [f"wanted_{kind}_{axis}" for kind in ("force", "rate") for axis in "xyz"]


def ros2_package(program: Program, legs: Program | None = None, *, leg_unit: str = "m") -> dict[str, str]:
    """Return the files of a package by their paths in it.

    Parameters
    ----------
    program : of the kind that moves as a platform: its outputs contain the pose.
    legs : from the pose (6,) to what the drives of six legs are told, named as the program with `_legs` after
        it; None for a platform without legs.
    leg_unit : of what the drives are told, m or rad.

    Raises
    ------
    InputError : the program's name is none that ROS allows for a package.
    """
    check_package_name(program.name)
    words = _words(program, legs, leg_unit)
    made = {path: _filled(_template(template), words) for template, path in _PLACES.items()}
    for one in (program, *([] if legs is None else [legs])):
        made[f"include/{one.name}.h"] = one.header
    return made


def check_package_name(name: str) -> None:
    """Refuse a name that ROS, C or the code of the node does not take; raises `InputError`."""
    if not re.fullmatch(r"[a-z](_?[a-z0-9])+", name):
        bound = "lower-case letters, digits and single _ after a letter, at least 2 characters"
        raise InputError("name of the ROS package", repr(name), bound)
    check_name(name)
    check_free(name, *(_template(one) for one in _CODE))


def _template(name: str) -> str:
    return (files("otolith.export") / "ros2" / name).read_text(encoding="utf-8")


def _words(program: Program, legs: Program | None, leg_unit: str) -> dict[str, str]:
    received = [port.name for port in program.inputs]
    given = [port.name for port in program.outputs]
    wanted = [received.index(name) if name in received else -1 for name in _WANTED]
    motion = {
        kind.upper(): ", ".join(str(given.index(f"{kind}_{axis}")) for axis in AXES)
        for kind in ("pose", "velocity", "acceleration")
    }
    name = program.name
    with_legs = {
        "HAS_LEGS": str(int(legs is not None)),
        "AND_LEGS": "" if legs is None else " and of its legs",
        "LEGS_INCLUDE": "" if legs is None else f'#include "{legs.name}.h"',
        "LEGS_SOURCE": ""
        if legs is None
        else f'#define {legs.name.upper()}_IMPLEMENTATION\n#include "{legs.name}.h"',
        "LEG_UNIT": leg_unit,
    }
    return motion | with_legs | {
        "PACKAGE": name,
        "NAME": name,
        "UPPER": name.upper(),
        "VERSION": ".".join(re.findall(r"\d+", __version__)[:3]),
        "PERIOD": repr(program.period),
        "INPUTS": str(len(received)),
        "OUTPUTS": str(len(given)),
        "WANTED": ", ".join(map(str, wanted)),
        "STATUS": ", ".join(f'"{status}"' for status in STATUSES),
    }  # fmt: skip


def _filled(text: str, words: dict[str, str]) -> str:
    """Put words in their places; a place without a word is a mistake of ours, and a KeyError."""
    return re.sub(r"@([A-Z_]+)@", lambda found: words[found[1]], text)

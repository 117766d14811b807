"""FMUs, driven as a host drives them: the small program `lag` has a closed form, y_k = u (1 - 0.9^k)."""

import re
import shutil
import subprocess
import zipfile
from io import BytesIO
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.build import build_platform_binary
from fmpy.validation import validate_fmu

from otolith.core.errors import InputError
from otolith.export.fmu import fmu, interface_sources
from otolith.export.fmu_binary import NotCompiled, compile_binary
from otolith.export.fmu_description import Version
from tests.export.fmus import COMPILER, VERSIONS, Host, host, needs_compiler
from tests.export.lag import GAIN, LAG, PERIOD

pytestmark = needs_compiler


def lagged(periods: int, u: float = 1.0) -> float:
    return u * (1.0 - (1.0 - GAIN) ** periods)


@pytest.fixture(scope="module", params=VERSIONS)
def file(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path: Path = tmp_path_factory.mktemp("fmu") / "lag.fmu"
    path.write_bytes(fmu(LAG, request.param, [str(COMPILER)]))
    return path


@pytest.fixture(scope="module")
def folder(file: Path) -> Path:
    zipfile.ZipFile(file).extractall(file.parent / "lag")
    return file.parent / "lag"


def test_the_standards_checks_find_nothing(file: Path) -> None:
    """Schema, units, names, start values, structure, for the version that was asked for."""
    assert validate_fmu(str(file)) == []


def test_names_units_and_meanings_are_those_of_the_program(file: Path) -> None:
    described = fmpy.read_model_description(str(file))
    found = [v for v in described.modelVariables if v.causality != "independent"]
    assert [(v.name, v.unit, v.description, v.causality) for v in found] == [
        ("u", "m/s2", "what comes in", "input"),
        ("y", "m/s2", "u, lagged", "output"),
        ("seen", "rad/s", "u, as it was read <here & now>", "output"),
        ("residual", "1", "infinite where a fallback decides", "output"),
    ]
    assert described.defaultExperiment.stepSize == str(PERIOD)


def test_the_same_program_gives_the_same_bytes(file: Path) -> None:
    version: Version = "2.0" if fmpy.read_model_description(str(file)).fmiVersion == "2.0" else "3.0"
    assert fmu(LAG, version, [str(COMPILER)]) == file.read_bytes()
    entries = zipfile.ZipFile(file).infolist()
    assert {entry.date_time for entry in entries} == {(1980, 1, 1, 0, 0, 0)}
    assert [entry.filename for entry in entries] == sorted(entry.filename for entry in entries)


@pytest.mark.parametrize("part", [0.05, 0.1, 0.3, 1.0, 2.0, 5.0])
def test_outputs_are_those_of_the_periods_that_ended_whatever_the_hosts_step(
    folder: Path, part: float
) -> None:
    """Also where 10 ms is no multiple of the step; sums of steps are rounded, which must not matter."""
    with host(folder) as one:
        one.set("u", 1.0)
        now = 0.0
        for k in range(1, 400):
            one.step(now, part * PERIOD)
            now += part * PERIOD
            assert one.get("y") == pytest.approx(lagged(int(k * part + 1e-6)), abs=1e-14)
        assert one.said == []


def test_a_period_reads_what_was_set_before_it_began(folder: Path) -> None:
    with host(folder) as one:
        for k, u in enumerate([1.0, 2.0, 3.0, 4.0]):
            one.set("u", u)
            one.step(k * PERIOD / 2, PERIOD / 2)
        assert one.get("seen") == 3.0  # the second period began at the third step


def test_commands_are_shown_in_the_step_in_which_their_period_begins(tmp_path: Path) -> None:
    zipfile.ZipFile(BytesIO(fmu(LAG, "3.0", [str(COMPILER)], at_once=True))).extractall(tmp_path)
    with host(tmp_path) as one:
        one.set("u", 1.0)
        for k in range(30):
            one.step(k * PERIOD / 10, PERIOD / 10)
            assert one.get("y") == pytest.approx(lagged(k // 10 + 1), abs=1e-14)


def test_two_instances_do_not_know_of_each_other(folder: Path) -> None:
    with host(folder) as one, host(folder) as other:
        one.set("u", 1.0)
        other.set("u", -2.0)
        for k in range(20):
            one.step(k * PERIOD, PERIOD)
            other.step(k * PERIOD, PERIOD)
        assert one.get("y") == pytest.approx(lagged(20), abs=1e-14)
        assert other.get("y") == pytest.approx(lagged(20, -2.0), abs=1e-14)


def test_a_simulation_may_begin_at_any_time_and_be_reset(folder: Path) -> None:
    with host(folder) as one:
        one.set("u", 1.0)
        one.step(0.0, 0.5)
        one.fmu.reset()
        one.start(at=7.0)
        assert one.get("y") == 0.0
        assert one.get("u") == 0.0
        one.set("u", 1.0)
        one.step(7.0, 0.1)
        assert one.get("y") == pytest.approx(lagged(10), abs=1e-14)


def test_a_stored_state_goes_on_as_the_instance_did(folder: Path) -> None:
    with host(folder) as one, host(folder) as other:
        v2 = one.description.fmiVersion == "2.0"
        names = ("FMUstate", "deSerialize") if v2 else ("FMUState", "deserialize")
        one.set("u", 1.0)
        one.step(0.0, 3.5 * PERIOD)
        state = getattr(one.fmu, f"get{names[0]}")()
        stored = getattr(one.fmu, f"serialize{names[0]}")(state)
        one.step(3.5 * PERIOD, 10 * PERIOD)
        there = one.get("y")
        getattr(one.fmu, f"set{names[0]}")(state)
        one.step(3.5 * PERIOD, 10 * PERIOD)
        assert one.get("y") == there
        again = getattr(other.fmu, f"{names[1]}{names[0]}")(stored)
        getattr(other.fmu, f"set{names[0]}")(again)
        other.step(3.5 * PERIOD, 10 * PERIOD)
        assert other.get("y") == there
        with pytest.raises(Exception, match=r"[sS]erialize"):
            getattr(other.fmu, f"{names[1]}{names[0]}")(bytes(len(stored)))
        assert other.said == ["the stored state was written by another FMU"]


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda one: one.step(0.5, PERIOD), "begins at 0.5 s, must begin at 0 s"),
        (lambda one: one.step(0.0, -PERIOD), "communication step is -0.01 s, must be 0 to 10000 s"),
        (lambda one: one.step(0.0, np.inf), "communication step is inf s, must be 0 to 10000 s"),
        (lambda one: one.step(0.0, np.nan), "must be 0 to 10000 s"),
        (lambda one: one.step(0.0, 1e300), "communication step is 1e+300 s, must be 0 to 10000 s"),
        (lambda one: one.step(np.nan, PERIOD), "must be within 1e+07 s of 0"),
        (lambda one: one.set("y", 1.0), "value reference 2 was set, must be an input's, 1 to 1"),
        (lambda one: one.start(), "was called while the instance is in step mode, must be instantiated"),
        (lambda one: one.fmu.exitInitializationMode(), "in step mode, must be in initialization"),
    ],
)
def test_a_call_that_is_refused_says_why_and_changes_nothing(folder: Path, call, sentence: str) -> None:
    with host(folder) as one:
        with pytest.raises(Exception, match=r"Error|error|status"):
            call(one)
        assert len(one.said) == 1
        assert sentence in one.said[0]
        one.set("u", 1.0)
        one.step(0.0, 0.1)
        assert one.get("y") == pytest.approx(lagged(10), abs=1e-14)


@pytest.mark.parametrize("start", [np.nan, -np.inf, 1e12])
def test_a_start_at_which_periods_would_not_be_told_apart_is_refused(folder: Path, start: float) -> None:
    """At 1e12 s a double is exact to 0.1 ms, and from 1e14 s on a period of 10 ms would never end."""
    made = Host(folder)
    made.instantiate()
    with pytest.raises(Exception, match=r"Error|error|status"):
        made.start(at=start)
    assert "must be within 1e+07 s of 0" in made.said[0]
    made.fmu.freeInstance()


def test_an_instance_ends_before_its_first_step_and_no_step_follows(folder: Path) -> None:
    made = Host(folder)
    made.instantiate()
    made.start()
    made.fmu.terminate()
    with pytest.raises(Exception, match=r"Error|error|status"):
        made.step(0.0, PERIOD)
    assert made.said == ["doStep was called while the instance is terminated, must be in step mode"]
    made.fmu.freeInstance()


def test_a_fallback_is_told_when_it_begins_and_not_once_per_period(folder: Path) -> None:
    with host(folder) as one:
        for k in range(30):
            one.set("u", 6.0 if k > 10 else 1.0)
            one.step(k * PERIOD, PERIOD)
            assert one.get("residual") == (-1.0 if k > 10 else 0.5)  # -1: there is none
        assert one.said == ["from 0.11 s on a fallback brakes to rest, status 1 (fallback)"]


def test_a_program_without_an_answer_ends_the_simulation(folder: Path) -> None:
    with host(folder) as one:
        one.set("u", 2000.0)
        with pytest.raises(Exception, match=r"[dD]oStep"):
            one.step(0.0, PERIOD)
        assert one.said == ["a model in the program has no answer at 0 s"]


def test_an_output_that_is_no_number_ends_the_simulation(folder: Path) -> None:
    with host(folder) as one:
        one.set("u", np.nan)
        with pytest.raises(Exception, match=r"[dD]oStep"):
            one.step(0.0, PERIOD)
        assert one.said == ["output y is not finite at 0 s"]


def test_an_fmu_refuses_the_description_of_another(folder: Path) -> None:
    stranger = Host(folder)
    stranger.fmu.guid = "{0}"
    with pytest.raises(Exception, match="Failed to instantiate"):
        stranger.instantiate()
    assert "the instance could not be made" in stranger.said[0]
    stranger.fmu.freeLibrary()


@pytest.mark.skipif(shutil.which("c++") is None, reason="no C++ compiler, which FMPy asks of CMake")
def test_the_sources_alone_compile_elsewhere_and_do_the_same(tmp_path: Path) -> None:
    """FMPy builds them by CMake, all warnings on, as the description says."""
    zipfile.ZipFile(BytesIO(fmu(LAG, "3.0"))).extractall(tmp_path)
    assert not (tmp_path / "binaries").exists()
    (tmp_path / "build").mkdir()
    build_platform_binary(
        tmp_path, tmp_path / "build", all_warnings=True, cmake_options={"CMAKE_C_FLAGS": "-Werror"}
    )
    with host(tmp_path) as one:
        one.set("u", 1.0)
        one.step(0.0, 0.1)
        assert one.get("y") == pytest.approx(lagged(10), abs=1e-14)


OWN_TYPES = {
    "2.0": {
        "status": "fmi2Status",
        "kind": "fmi2Type",
        "question": "fmi2StatusKind",
        "callbacks": "fmi2CallbackFunctions",
    },
    "3.0": {
        "status": "fmi3Status",
        "dependency": "fmi3DependencyKind",
        "qualifier": "fmi3IntervalQualifier",
    },
}


@pytest.mark.parametrize("version", VERSIONS)
def test_our_declarations_are_those_of_the_standards_headers(version: Version, tmp_path: Path) -> None:
    """With the standard's types in place of ours, the compiler compares each function with it."""
    number = version[0]
    sources = interface_sources(version)
    main = f"fmi{number}.c"
    text = sources[main]
    for own, theirs in OWN_TYPES[version].items():
        found = re.search(rf"typedef (enum|struct) \{{([^}}]*)\}} {own};", text)
        assert found is not None, own
        constants = f"enum {{{found[2]}}};" if found[1] == "enum" else ""
        text = text.replace(found[0], f"{constants} typedef {theirs} {own};")
    text = text.replace("host->log", "host->logger").replace(
        "host->environment", "host->componentEnvironment"
    )
    standard = f'#include "{Path(fmpy.__file__).parent / "c-code" / f"fmi{number}Functions.h"}"\n'
    zipped = zipfile.ZipFile(BytesIO(fmu(LAG, version)))
    sources |= {name: zipped.read(f"sources/{name}").decode() for name in ("model.h", "lag.h")}
    compile_binary(str(COMPILER), {**sources, main: standard + text}, main, "lag")
    changed = text.replace("double from, double length", "float from, double length")
    assert changed != text
    with pytest.raises(NotCompiled, match="conflicting types"):
        compile_binary(str(COMPILER), {**sources, main: standard + changed}, main, "lag")


def test_nothing_is_shared_between_instances(folder: Path, tmp_path: Path) -> None:
    """The object file has no writable data (pointers in constants would be writable where code may move)."""
    (main,) = folder.glob("sources/fmi?.c")
    command = [
        str(COMPILER),
        "-std=c99",
        "-fno-pic",
        "-fno-pie",
        "-c",
        "-o",
        str(tmp_path / "lag.o"),
        str(main),
    ]
    subprocess.run(command, check=True)
    listed = subprocess.run(
        ["nm", str(tmp_path / "lag.o")], check=True, capture_output=True, text=True
    ).stdout
    assert "fmi" in listed
    assert not re.search(r" [bBdDC] ", listed)


def test_two_compilers_for_one_machine_are_refused() -> None:
    """Their binaries would have one place in the archive."""
    compiler = str(COMPILER)
    with pytest.raises(InputError, match=r"--compiler is .*, must be one for each kind of machine"):
        fmu(LAG, "2.0", [compiler, compiler])


def test_a_compiler_that_is_none_is_refused() -> None:
    with pytest.raises(
        InputError, match="--compiler is no-such-compiler, must be the command of an installed C"
    ):
        fmu(LAG, "3.0", ["no-such-compiler"])
    with pytest.raises(NotCompiled, match="false ended with code 1"):
        fmu(LAG, "3.0", ["false"])
    with pytest.raises(InputError, match=r"echo \(for -dumpmachine\), must be a compiler for Linux, Windows"):
        fmu(LAG, "3.0", ["echo"])

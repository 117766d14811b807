"""The Objective Motion Cueing Test: modulus and phase of a whole motion system, axis by axis.

The input is what the vehicle would let the driver feel, the output is what the platform does. Between them
are the cueing algorithm, its period and the plant. The force along a translation includes the part of gravity
from tilt. Rotations are driven by their rate alone, without a force.
"""

import cmath
import math
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from otolith.core.arrays import Vec
from otolith.core.frames import AXES
from otolith.interfaces import Cueing, Plant
from otolith.loop import Run, simulate
from otolith.metrics.harmonics import Harmonic, harmonic
from otolith.platforms import Platform
from otolith.scenarios.cueing_tests import FREQUENCIES, TESTS, Amplitudes, MotionTest, Sweep, sinusoid

NOTHING = 1e-9  # share of the driven amplitude below which a response counts as zero, without a phase


@dataclass(frozen=True, slots=True, kw_only=True)
class Response:
    """The result of one test at one frequency, with the largest deviation of a period as uncertainty."""

    test: MotionTest
    omega: float  # [rad/s]
    modulus: float  # [MotionTest.unit]
    modulus_uncertainty: float  # in the unit of `modulus`
    phase_deg: float  # of the output relative to the input, negative if late; NaN if nothing is felt
    phase_uncertainty_deg: float
    distortion: float  # RMS of the rest over that of the sinusoid; NaN if nothing is felt
    status: Mapping[str, int] = field(default_factory=dict)  # number of decisions by status


@dataclass(frozen=True, slots=True, kw_only=True)
class System:
    """The system under test. Only axes that the cueing cues are driven and measured."""

    cueing: Cueing
    plant: Plant
    platform: Platform
    axes: Collection[str]  # names from `otolith.core.frames.AXES`


@dataclass(frozen=True, slots=True, kw_only=True)
class Procedure:
    """How the system is tested."""

    amplitudes: Amplitudes = field(default_factory=Amplitudes)
    sweep: Sweep = field(default_factory=Sweep)
    frequencies: Sequence[float] = FREQUENCIES  # [rad/s]
    plant_period: float = 1e-3  # [s] sampling of the motion; errors of interpolation grow with it

    def seconds(self, system: System) -> float:
        """Return the simulated time of the whole test [s]."""
        each = sum(sum(self.sweep.times(omega)) for omega in self.frequencies)
        return each * len({test.driven for test in applicable(system.axes)})


def applicable(axes: Collection[str]) -> list[MotionTest]:
    """Return the tests whose two axes are among `axes`."""
    return [test for test in TESTS if test.driven in axes and test.felt in axes]


def motion_cueing_test(
    system: System, procedure: Procedure, *, progress: Callable[[float], None] = lambda _: None
) -> list[Response]:
    """Run all tests of the system's axes at all frequencies, in the order of `TESTS` and of frequency.

    Parameters
    ----------
    progress : is called with the fraction done.
    """
    found = [*_drive_all(system, procedure, progress)]
    return sorted(found, key=lambda response: (response.test.number, response.omega))


def decisions(responses: Sequence[Response]) -> Counter[str]:
    """Count the decisions of all drives by status; a drive that serves several tests counts once."""
    drives = {(response.test.driven, response.omega): response.status for response in responses}
    return sum((Counter(status) for status in drives.values()), Counter())


def drive(system: System, axis: str, omega: float, procedure: Procedure) -> Run:
    """Drive one axis at one frequency [rad/s], from rest in the neutral pose."""
    amplitude = procedure.amplitudes.of(axis, omega)
    return simulate(
        system.cueing,
        system.plant,
        sinusoid(axis, omega, amplitude, procedure.sweep),
        platform=system.platform,
        plant_period=procedure.plant_period,
        dofs=(),  # limits are not judged in this run
    )


def respond(run: Run, test: MotionTest, omega: float, procedure: Procedure) -> Response:
    """Evaluate one test from a run that `drive` made along the test's driven axis."""
    return _read(run, felt_along(run, test.felt), test, omega, procedure)


def sinacori_point(system: System, axis: str, procedure: Procedure) -> Response:
    """Return gain and phase of one axis's own motion at 1 rad/s, by which Sinacori judges a washout.

    Unlike the test along the same axis, a translation is measured without gravity from tilt, so the result is
    the high-pass path alone. Judge it with `otolith.metrics.harmonics.graded`.
    """
    run = drive(system, axis, 1.0, procedure)
    index = AXES.index(axis)
    moved: Vec = run.acceleration[:, index] if index < 3 else run.twist[:, index]
    return _read(run, moved, MotionTest(0, axis, axis), 1.0, procedure)


def felt_along(run: Run, axis: str) -> Vec:
    """Return what is felt along one axis (n,): specific force [m/s²], or for small angles rate [rad/s]."""
    index = AXES.index(axis)
    series: Vec = run.felt_force[:, index] if index < 3 else run.twist[:, index]
    return series


def _drive_all(system: System, procedure: Procedure, progress: Callable[[float], None]) -> Iterator[Response]:
    tests, total, done = applicable(system.axes), procedure.seconds(system), 0.0
    for axis in dict.fromkeys(test.driven for test in tests):
        for omega in procedure.frequencies:
            run = drive(system, axis, omega, procedure)
            yield from (respond(run, test, omega, procedure) for test in tests if test.driven == axis)
            done += sum(procedure.sweep.times(omega))
            progress(done / total)


def _read(run: Run, series: Vec, test: MotionTest, omega: float, procedure: Procedure) -> Response:
    _, measured = procedure.sweep.times(omega)
    last = run.time > run.time[-1] - measured - 0.5 * run.plant_period
    driven = -1j * procedure.amplitudes.of(test.driven, omega)  # a sin ωt is the real part of −j a e^{jωt}
    found = _response(test, omega, driven, harmonic(run.time[last], series[last], omega))
    return replace(found, status=Counter(run.outcomes))


def _response(test: MotionTest, omega: float, driven: complex, felt: Harmonic) -> Response:
    ratio, spread = felt.amplitude / driven, felt.spread / abs(driven)
    nothing = abs(ratio) <= NOTHING
    wobble = 180.0 if spread >= abs(ratio) else math.degrees(math.asin(spread / abs(ratio)))
    return Response(
        test=test,
        omega=omega,
        modulus=abs(ratio),
        modulus_uncertainty=spread,
        phase_deg=math.nan if nothing else math.degrees(cmath.phase(ratio)),
        phase_uncertainty_deg=math.nan if nothing else wobble,
        distortion=math.nan if nothing else felt.distortion,
    )

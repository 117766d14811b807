"""`otolith live bench`: what live operation takes, measured beside a bare loop; or hours in virtual time."""

import re
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Final

import numpy as np
import typer
from rich.table import Table

from otolith.cli.durations import LONGEST, lasting
from otolith.cli.live_run import Choices, measure
from otolith.cli.live_virtual import CueingName, Json, Tuning, prepared
from otolith.cli.options import Dofs, PlatformName
from otolith.cli.output import print_json, progress_bar, screen
from otolith.core.errors import InputError

if TYPE_CHECKING:
    from otolith.live.shell.reference import Bare
    from otolith.live.shell.supervise import Live
    from otolith.platforms import Platform

UNITS: Final = {"": 1.0, "s": 1.0, "min": 60.0, "h": 3600.0}
GATED: Final = 2000  # motions by which the gate is timed


def bench(
    virtual: Annotated[
        str | None,
        typer.Option(metavar="TIME", help="Run in virtual time instead, e.g. 2h, 10min or 90 (seconds)."),
    ] = None,
    seconds: Annotated[float, lasting("How long to be engaged, in real time", least=1.0)] = 20.0,
    cueing: CueingName = "predictive",
    platform: PlatformName = "davsi-4dof",
    dofs: Dofs = "surge-pitch,sway-roll",
    tuning: Tuning = None,
    seed: Annotated[int, typer.Option(min=0, help="Of references and faults in virtual time.")] = 0,
    json: Json = False,
) -> None:
    """Measure a session in real time; or run in virtual time with hostile references and random faults.

    In virtual time, the exit code is 1 if a limit is passed.
    """
    choices = Choices(cueing=cueing, platform=platform, dofs=dofs, tuning=tuning)
    if virtual is None:
        _real(choices, seconds, json)
    else:
        _virtual(choices, _seconds(virtual), seed, json)


def _seconds(text: str) -> float:
    """Return a time such as 2h in seconds."""
    found = re.fullmatch(r"(\d+(?:\.\d*)?)\s*(|s|min|h)", text.strip())
    seconds = float(found[1]) * UNITS[found[2]] if found else 0.0
    if not 1.0 <= seconds <= LONGEST:
        raise InputError("--virtual", repr(text), "a time of 1 s to 100 h, such as 90, 10min or 2h")
    return seconds


@dataclass(frozen=True, slots=True)
class Line:
    """One figure, its goal, and the same figure of the bare loop where it has one."""

    what: str
    value: float
    unit: str
    goal: float
    reference: float | None = None

    def cells(self) -> tuple[str, ...]:
        """Return the cells of its row."""
        beside = "" if self.reference is None else f"{self.reference:.3g}"
        mark = "" if self.value <= self.goal else "beyond"
        return self.what, f"{self.value:.3g}", self.unit, f"{self.goal:g}", beside, mark


def _real(choices: Choices, seconds: float, json: bool) -> None:
    """Run a session with a base in software and a bare loop beside it, and print the figures."""
    from otolith.live.shell.reference import BareLoop

    with choices.rehearsed() as session, BareLoop() as loop:
        live = measure(session, seconds, stderr=json)
    lines = _lines(live, loop.found, session.settings.dofs.count(",") + 1, session.platform)
    if json:
        names = ("what", "value", "unit", "goal", "reference")
        print_json({"rows": [{name: getattr(line, name) for name in names} for line in lines]})
        return
    table = Table(box=None, pad_edge=False)
    for column in ("what", "value", "unit", "goal", "bare loop", ""):
        table.add_column(column, overflow="fold", justify="left" if column in {"what", ""} else "right")
    for line in lines:
        table.add_row(*line.cells())
    screen(stderr=False, wide=True).print(table)


def _lines(live: "Live", bare: "Bare", pairs: int, platform: "Platform") -> list[Line]:
    output, controller = live.output_timing, live.controller_timing
    us, ms = 1e-3, 1e-6
    step = (150.0, 300.0) if pairs == 1 else (250.0, 600.0)
    late, its = output.late, bare.late
    missed = controller.missed / max(1, controller.decisions)
    return [
        Line("packet to plan, on the processor: median", us * controller.cpu.share(0.5), "us", step[0]),
        Line("packet to plan, on the processor: p99", us * controller.cpu.share(0.99), "us", step[1]),
        Line("packet to plan, published: median", ms * controller.plan.share(0.5), "ms", 1.0),
        Line("packet to plan, published: p99", ms * controller.plan.share(0.99), "ms", 2.0),
        Line("packet to first set-point: median", ms * output.answer.share(0.5), "ms", 2.0),
        Line("packet to first set-point: p99", ms * output.answer.share(0.99), "ms", 4.0),
        Line("output woken late: p99", ms * late.share(0.99), "ms", 0.3, ms * its.share(0.99)),
        Line("output woken late: p99.9", ms * late.share(0.999), "ms", 2.0, ms * its.share(0.999)),
        Line("output woken late: p99.9, to the bare loop's", late.share(0.999) / its.share(0.999), "", 1.5),
        Line("output woken late: most", ms * late.largest, "ms", 10.0, ms * its.largest),
        Line("output skipped, of its ticks", output.skipped / late.count, "", 1e-3, bare.skipped / its.count),
        Line("decisions missed, of their periods", missed, "", 1e-4),
        Line("gate, a set-point with its way to rest", _gate_us(platform), "us", 15.0),
    ]


def _gate_us(platform: "Platform") -> float:
    """Return the time of the processor [us] for a set-point that the gate lets pass, while it moves."""
    from otolith.live.core.gate import Gate
    from otolith.live.core.rollout import Rollout

    gate = Gate(platform, lag=platform.actuators.lag_s, period=0.01)
    rng, rollout, spent = np.random.default_rng(0), Rollout(gate), 0
    rollout.place(np.zeros(6))
    for _ in range(GATED // 20):
        command = gate.reach.command * rng.uniform(-1.0, 1.0, 6) * rng.random()
        for _ in range(20):
            begin = time.thread_time_ns()
            rollout.follow(command, 1e-3)
            spent += time.thread_time_ns() - begin
    return 1e-3 * spent / GATED


def _virtual(choices: Choices, virtual_s: float, seed: int, json: bool) -> None:
    """Run in virtual time and give account."""
    from otolith.live.endurance import endurance

    algorithm, machine = prepared(
        choices.cueing or "", choices.platform or "", choices.dofs or "", choices.tuning
    )
    console, started, spent = screen(), time.perf_counter(), time.process_time()
    with progress_bar(console, "running") as bar:
        account = endurance(algorithm, machine, virtual_s, seed=seed, progress=bar)
    took = time.perf_counter() - started
    found: dict[str, Any] = {
        "seconds": account.seconds,
        "computed_in_s": round(took, 1),
        "processor_s_per_virtual_hour": round(3600.0 * (time.process_time() - spent) / virtual_s, 1),
        "cued_seconds": round(account.cued_seconds, 1),
        "engagements": account.engagements,
        "restarts": account.restarts,
        "decisions": account.decisions,
        "set_points": account.set_points,
        "fallbacks": account.fallbacks,
        "plans_refused_by_gate": account.refused_plans,
        "set_points_refused_by_gate": account.refused_set_points,
        "faults": dict(account.faults),
        "violations": account.violations,
        "exceptions": account.exceptions,
        "device_faults": account.device_faults,
        "compilations": account.compilations,
    }
    if json:
        print_json(found)
    else:
        out = screen(stderr=False)
        for name, value in found.items():
            out.print(
                f"{name.replace('_', ' ')}: {value if value else 'none'}", highlight=False, soft_wrap=True
            )
    if not account.clean:
        raise typer.Exit(1)

"""Messages between the processes of a session as bytes: in shared memory, and in the log.

All numbers are little endian and keep their bits, so a message that is packed and unpacked is the same.
"""

import struct
from dataclasses import astuple, fields
from typing import Final

import numpy as np

from otolith.live.core.parameters import Parameters
from otolith.live.messages import Plan, Report, Rung, State, Vitals, Word

_PLAN: Final = struct.Struct("<qqqqqqd?qq")
_VITALS: Final = struct.Struct("<q3dq?q")
_PARAMETERS: Final = struct.Struct(f"<{len(fields(Parameters))}d")
_FIRST: Final = 2  # parameters of the oldest logs: scale and liveliness
_REPORT: Final = struct.Struct("<qqq")
_NOWHERE: Final = np.full(6, np.nan)


def pack_plan(plan: Plan) -> bytes:
    """Return a plan as bytes; texts are cut at 200 bytes."""
    reason, outcome = (text.encode()[:200] for text in (plan.reason, plan.outcome))
    head = _PLAN.pack(
        plan.sequence,
        plan.generation,
        plan.time_ns,
        plan.period_ns,
        plan.rung,
        plan.telemetry_ns,
        plan.residual,
        plan.healthy,
        len(reason),
        len(outcome),
    )
    return head + reason + outcome + plan.stages.tobytes()


def unpack_plan(message: bytes) -> Plan:
    """Return the plan of `pack_plan`."""
    sequence, generation, time_ns, period_ns, rung, telemetry_ns, residual, healthy, m, n = _PLAN.unpack_from(
        message
    )
    at = _PLAN.size
    return Plan(
        sequence=sequence,
        generation=generation,
        time_ns=time_ns,
        period_ns=period_ns,
        rung=Rung(rung),
        telemetry_ns=telemetry_ns,
        residual=residual,
        healthy=healthy,
        reason=message[at : at + m].decode(errors="ignore"),
        outcome=message[at + m : at + m + n].decode(errors="ignore"),
        stages=np.frombuffer(message[at + m + n :]).reshape(-1, 6),
    )


def pack_report(report: Report) -> bytes:
    """Return a report as bytes."""
    head = _REPORT.pack(report.time_ns, report.generation, report.follows)
    measured = _NOWHERE if report.measured is None else report.measured
    return head + report.motion.tobytes() + measured.tobytes() + str(report.state).encode()


def unpack_report(message: bytes) -> Report:
    """Return the report of `pack_report`."""
    time_ns, generation, follows = _REPORT.unpack_from(message)
    at = _REPORT.size
    measured = np.frombuffer(message[at + 144 : at + 192])
    return Report(
        time_ns=time_ns,
        generation=generation,
        follows=follows,
        motion=np.frombuffer(message[at : at + 144]).reshape(3, 6),
        state=State(message[at + 192 :].decode()),
        measured=None if np.isnan(measured).any() else measured,
    )


def pack_words(words: tuple[Word, ...]) -> bytes:
    """Return the operator's words as bytes."""
    return " ".join(words).encode()


def unpack_words(message: bytes) -> tuple[Word, ...]:
    """Return the words of `pack_words`."""
    return tuple(Word(word) for word in message.decode().split())


def pack_vitals(vitals: Vitals) -> bytes:
    """Return what the controller shows as bytes."""
    clock = vitals.clock_ns
    head = _VITALS.pack(vitals.time_ns, *vitals.asked, vitals.missed, clock is not None, clock or 0)
    return head + pack_parameters(vitals.parameters)


def unpack_vitals(message: bytes) -> Vitals:
    """Return what `pack_vitals` packed."""
    time_ns, x, y, z, missed, has_clock, clock = _VITALS.unpack_from(message)
    return Vitals(
        time_ns=time_ns,
        asked=np.array([x, y, z]),
        missed=missed,
        clock_ns=clock if has_clock else None,
        parameters=unpack_parameters(message[_VITALS.size :]),
    )


def pack_parameters(parameters: Parameters) -> bytes:
    """Return parameters as bytes."""
    return _PARAMETERS.pack(*astuple(parameters))


def unpack_parameters(message: bytes) -> Parameters:
    """Return the parameters of `pack_parameters`.

    A log holds fewer where it is older than some of them. These had their defaults then, and come last.
    """
    names = [one.name for one in fields(Parameters)][: max(_FIRST, len(message) // 8)]
    return Parameters(**dict(zip(names, struct.unpack(f"<{len(names)}d", message), strict=True)))

"""`otolith live record`, `learn` and `emulate`: telemetry and devices, each without the other."""

import time
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from otolith import files
from otolith.cli.durations import lasting
from otolith.cli.output import print_json, screen, warn
from otolith.cli.stop import Stopped
from otolith.core.disk import read_bytes, write_bytes
from otolith.core.errors import InputError
from otolith.live.messages import Telemetry
from otolith.live.wire.axes import with_axes
from otolith.live.wire.capture import Capture, Packet, is_capture, packet_record, read_capture, session_record
from otolith.live.wire.formats import OtherPacket, WireError
from otolith.live.wire.learned import Learned, learn
from otolith.live.wire.minute import Minute, minute_of, minute_of_recording
from otolith.live.wire.sources import SOURCES, source_named
from otolith.recordings.settings import LogSettings

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")]
_NAMES = ", ".join(f"{name}:FILE" if one.needs else name for name, one in SOURCES.items())
SourceName = Annotated[str, typer.Argument(metavar="SOURCE", help=f"Who sends: {_NAMES}.")]
LARGEST = 200_000_000  # largest capture that is read [bytes]


class Device(StrEnum):
    """Devices that exist in software."""

    MOOG = "moog"


def record(
    source: SourceName,
    out: Annotated[Path, typer.Option(metavar="FILE", help="The file to write, such as drive.otc.")],
    port: Annotated[int | None, typer.Option(help="UDP port (default: the game's own).")] = None,
    seconds: Annotated[float, lasting("How long to record", least=0.1)] = 60.0,
    host: Annotated[
        str, typer.Option(help="Address to listen on; 0.0.0.0 for other machines.")
    ] = "127.0.0.1",
) -> None:
    """Record what a game sends, packet by packet; nothing moves."""
    from otolith.live.shell.datagrams import opened, receive

    parser = source_named(source, _text)
    console, taken = screen(), [session_record(source)]
    refused: dict[str, int] = {}  # by what the refusal says

    def take(packet: bytes, now_ns: int) -> None:
        taken.append(packet_record(Packet(now_ns, packet)))
        try:
            parser.parse(packet)
        except WireError as error:
            refused[str(error)] = refused.get(str(error), 0) + 1

    entry = SOURCES[source.partition(":")[0]]
    with opened(entry.port if port is None else port, host=host) as listening:
        console.print(f"listening on {host}:{listening.getsockname()[1]} for {seconds:g} s")
        interrupted = None
        try:
            receive(listening, take, seconds=seconds)
        except Stopped as request:  # what was received until now is kept
            interrupted = request
    if len(taken) > 1:
        write_bytes(out, b"".join(taken))
        console.print(f"{len(taken) - 1} packets, {sum(refused.values())} of them refused, written to {out}")
    if refused:
        console.print(f"most often: {max(refused, key=lambda said: refused[said])}", style="yellow")
    if interrupted is not None:
        raise interrupted
    if len(taken) == 1:
        bound = f"at least one within {seconds:g} s: does the game send to this port?"
        raise InputError("number of packets received", 0, bound)


def learn_(
    log: Annotated[
        Path, typer.Option("--log", metavar="FILE", help="A capture of 'live record', or a CSV drive.")
    ],
    out: Annotated[
        Path | None,
        typer.Option(metavar="TOML", help="Write the axis map; into a session file, if it is there already."),
    ] = None,
    source: Annotated[str, typer.Option(help="Who sent, if not as the capture says; for its options.")] = "",
    json: Json = False,
) -> None:
    """Find axes, signs, units and gravity in a recorded minute: rest, accelerate, brake, circle left."""
    learned = learn(_minute(log, source))
    if out is not None:
        files.check_file(out, ".toml")
        before = files.read_text(out, "session") if out.exists() else ""
        files.write_text(out, with_axes(before, out.name, learned.axes))
    console = screen()
    if json:
        print_json(_summary(learned))
    else:
        for sentence in learned.sentences():
            screen(stderr=False).print(sentence)
    for note in learned.notes:
        console.print(f"note: {note}", style="yellow")
    if out is not None:
        console.print(f"axis map written to {out}")


def emulate(
    device: Annotated[Device, typer.Argument(help="Which device.")],
    port: Annotated[int, typer.Option(help="UDP port.")] = 9910,
    host: Annotated[str, typer.Option(help="Address to listen on.")] = "127.0.0.1",
    interface: Annotated[str, typer.Option(help="Moog's interface: CDS7237 or CDS7330.")] = "CDS7237",
    platform: Annotated[
        str | None,
        typer.Option(help="Go as far as this platform (default: public figures of a small base)."),
    ] = None,
    neutral_heave: Annotated[
        float, typer.Option(help="The base's own heave [m] at the platform's neutral pose.")
    ] = -0.2,
    seconds: Annotated[
        float | None, lasting("End after this time, if not only when it is interrupted", least=0.1)
    ] = None,
) -> None:
    """Be a device in software: it answers, moves, and refuses what the real one refuses."""
    from otolith.live.devices.emulator import Envelope, MoogEmulator
    from otolith.live.devices.moog import MACHINE_STATES, Moog
    from otolith.live.shell.datagrams import opened, receive

    driven = Moog(
        interface=interface, neutral_heave=neutral_heave
    )  # refuses what a base could not start from
    reach = (
        None if platform is None else Envelope.holding(files.read_platform(platform), driven.neutral_heave)
    )
    base, console, seen = MoogEmulator(interface, reach), screen(), {"state": -1, "refused": 0}

    def passed(now_ns: int) -> None:
        base.tick(now_ns)
        if base.state != seen["state"]:
            seen["state"] = base.state
            faults = ", ".join(base.fault_names)
            console.print(f"{MACHINE_STATES[base.state][0]}{f': {faults}' if faults else ''}")
        for sentence in base.refusals[seen["refused"] :]:
            console.print(sentence, style="yellow")
        seen["refused"] = len(base.refusals)

    with opened(port, host=host) as listening:
        console.print(f"{device} {interface} on {host}:{listening.getsockname()[1]}")
        base.cycle_power(time.monotonic_ns())
        receive(listening, base.receive, seconds=seconds, passed=passed)


def _minute(log: Path, source: str) -> Minute:
    data = read_bytes(log, "recording", most=LARGEST)
    if is_capture(data):
        capture = read_capture(data, log.name)
        return _captured(capture, source or capture.source, log.name)
    if source:
        raise InputError("--source", repr(source), f"left out: {log.name} is no capture of packets")
    return minute_of_recording(files.understand_log(log, LogSettings()).stated)


def _captured(capture: Capture, source: str, name: str) -> Minute:
    parser = source_named(source, _text)
    samples: list[tuple[float, Telemetry]] = []
    refused: list[WireError] = []
    for packet in capture.packets:
        try:
            samples.append((1e-9 * packet.time_ns, parser.parse(packet.data)))
        except OtherPacket:
            continue
        except WireError as error:
            refused.append(error)
    if not samples and refused:
        raise refused[0]
    if not samples:
        raise InputError(f"packets of {name}", 0, f"some of {parser.name}")
    if refused:
        warn(
            screen(),
            f"{len(refused)} of {len(capture.packets)} packets are left out, the first: {refused[0]}",
        )
    if capture.cut:
        warn(screen(), f"{name} ends within a packet, as if its recorder had been killed")
    return minute_of(parser.name, samples)


def _summary(learned: Learned) -> dict[str, Any]:
    axes = learned.axes
    return {
        "source": axes.source,
        "force": list(axes.force),
        "force_unit": axes.force_unit,
        "gravity": axes.gravity,
        "frame": axes.frame,
        "rate": list(axes.rate),
        "rate_unit": axes.rate_unit,
        "evidence": dict(axes.evidence),
        "notes": list(learned.notes),
        "sha256": axes.digest,
    }


def _text(name: str) -> str:
    return files.read_text(Path(name), "file of channels")

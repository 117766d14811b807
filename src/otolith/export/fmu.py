"""An exported program as a Functional Mock-up Unit (FMU), for hosts such as Simulink, CarMaker and dSPACE.

An FMU is a zip archive: an XML description, the C sources, and a shared library for each kind of machine that
it was compiled for. This one does co-simulation by FMI 2.0 or 3.0 (fmi-standard.org). The C code around the
program, in `fmi/`, is the same for all programs; `model.h`, which is written here, tells it of this one.

The same program and compiler give the same archive, bit for bit: entries are sorted and bear no time of day.
"""

import hashlib
import io
import uuid
import zipfile
from collections.abc import Sequence
from importlib.resources import files
from typing import Final

from otolith.compiled import STATUSES
from otolith.export.fmu_binary import check_compilers, compile_binary
from otolith.export.fmu_description import Version, build_description, model_description
from otolith.export.fmu_page import page
from otolith.export.program import Port, Program, check_free, check_name

_INTERFACE: Final = {"2.0": "fmi2.c", "3.0": "fmi3.c"}  # the file to compile; it includes the others
_NEVER: Final = (1980, 1, 1, 0, 0, 0)  # the time of every entry: the earliest that a zip archive can say


def fmu(program: Program, version: Version, compilers: Sequence[str] = (), *, at_once: bool = False) -> bytes:
    """Return the bytes of an FMU.

    Parameters
    ----------
    compilers : commands of C compilers; each adds a binary for the machine that it compiles for. With none,
        the archive holds the sources alone, and the host's own compiler makes the binary.
    at_once : outputs are shown at the end of the communication step in which a period begins, as is right for
        commands that another model follows. Otherwise they are shown when the period ends, since motion is
        that of this moment.

    Raises
    ------
    InputError : a compiler cannot be started, its machine is none that FMI has a name for or that of another
        compiler, or the program's name is no name of a model.
    NotCompiled : a compiler refused the sources.
    """
    check_model_name(program.name, version)
    check_compilers(compilers)
    names = [_INTERFACE[version]]
    sources = interface_sources(version) | {f"{program.name}.h": program.header}
    model, description = _model(program, at_once), model_description(program, version, "", names)
    token = _token([*sources.values(), model, description])
    sources["model.h"] = f'#define TOKEN "{token}"\n{model}'
    entries = {
        "modelDescription.xml": model_description(program, version, token, names),
        "documentation/index.html": page(program, version),
        **{f"sources/{name}": text for name, text in sources.items()},
    }
    if version == "3.0":
        entries["sources/buildDescription.xml"] = build_description(program, names)
    binaries = [compile_binary(compiler, sources, names[0], program.name) for compiler in compilers]
    libraries = {f"binaries/{one.folder(version)}/{one.name}": one.content for one in binaries}
    return _archive({name: text.encode() for name, text in entries.items()} | libraries)


def check_model_name(name: str, version: Version) -> None:
    """Refuse a name that the C code of an FMU uses, or that C does not take; raises `InputError`."""
    check_name(name)
    check_free(name, *interface_sources(version).values())


def interface_sources(version: Version) -> dict[str, str]:
    """Return the C sources that all FMUs of this version share, by name."""
    folder = files("otolith.export") / "fmi"
    return {name: (folder / name).read_text(encoding="utf-8") for name in ("instance.h", _INTERFACE[version])}


def _token(texts: list[str]) -> str:
    """Name a program by its content: an FMU refuses to be made with the description of another."""
    digest = hashlib.sha256("\0".join(texts).encode()).digest()
    return f"{{{uuid.UUID(bytes=digest[:16])}}}"


def _model(program: Program, at_once: bool) -> str:
    """Return what the code around a program must know of it, less its token."""
    name = program.name
    return f"""\
#define {name.upper()}_IMPLEMENTATION
#include "{name}.h"

typedef {name} program_state;
#define program_init {name}_init
#define program_step {name}_step
#define PERIOD {program.period!r} /* [s] */
#define SHOWN_AT_ONCE {int(at_once)}
enum {{ INPUTS = {len(program.inputs)}, OUTPUTS = {len(program.outputs)}, STATUSES = {len(STATUSES)} }};

static const double input_start[] = {_starts(program.inputs)};
static const double output_start[] = {_starts(program.outputs)};
static const char *const output_name[] = {_strings([port.name for port in program.outputs])};
static const char output_has_unit[] = {{{", ".join(str(int(port.unit != "")) for port in program.outputs)}}};
static const char *const status_name[] = {_strings([str(status) for status in STATUSES])};
"""


def _starts(ports: tuple[Port, ...]) -> str:
    return f"{{{', '.join(repr(float(port.start)) for port in ports)}}}"


def _strings(words: list[str]) -> str:
    return "{" + ", ".join(f'"{word}"' for word in words) + "}"


def _archive(entries: dict[str, bytes]) -> bytes:
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(entries):
            entry = zipfile.ZipInfo(name, _NEVER)
            entry.external_attr = 0o644 << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, entries[name])
    return memory.getvalue()

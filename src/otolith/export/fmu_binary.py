"""The shared library of an FMU, made by a C compiler of this machine for this or another kind of machine."""

import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from shutil import which
from typing import Final

from otolith.core.errors import InputError, OtolithError
from otolith.export.fmu_description import Version

COMPILERS: Final = ("cc", "gcc", "clang")  # what is looked for where the user names none

_PROCESSORS: Final = {
    "x86_64": "x86_64",
    "amd64": "x86_64",
    "i386": "x86",
    "i586": "x86",
    "i686": "x86",
    "aarch64": "aarch64",
    "arm64": "aarch64",
    "arm": "aarch32",
}  # as compilers call them, and as FMI 3.0 does
_SYSTEMS: Final = {"linux": ("linux", ".so"), "mingw": ("windows", ".dll"), "darwin": ("darwin", ".dylib")}
_OLD_NAMES: Final = {
    "x86_64-linux": "linux64",
    "x86-linux": "linux32",
    "x86_64-windows": "win64",
    "x86-windows": "win32",
    "x86_64-darwin": "darwin64",
}  # of FMI 2.0, which has none for other machines: there the new name is used

# Sums and products are rounded one by one, as in Python, also where the processor could fuse them.
_OPTIONS: Final = ("-std=c99", "-O3", "-ffp-contract=off", "-fvisibility=hidden", "-shared")


class NotCompiled(OtolithError):
    """A C compiler refused the sources, or could not be run."""


@dataclass(frozen=True, kw_only=True)
class Binary:
    """A shared library for one kind of machine."""

    machine: str  # as FMI 3.0 calls it, e.g. x86_64-linux
    name: str  # of the file
    content: bytes

    def folder(self, version: Version) -> str:
        """Return the name of its folder in an FMU of this version."""
        return _OLD_NAMES.get(self.machine, self.machine) if version == "2.0" else self.machine


def installed_compiler() -> str:
    """Return the first C compiler that this machine has.

    Raises
    ------
    NotCompiled : it has none.
    """
    for name in COMPILERS:
        if which(name):
            return name
    raise NotCompiled(
        f"no C compiler ({', '.join(COMPILERS)}) is on this machine: install one, name one with --compiler, "
        "or write the sources alone with --sources-only"
    )


def check_compilers(compilers: Sequence[str]) -> None:
    """Refuse compilers that cannot be run, or of which two are for one kind of machine.

    Raises
    ------
    InputError : so it is, or one compiles for a machine that FMI has no name for.
    NotCompiled : one does not say what it compiles for.
    """
    makers: dict[str, str] = {}
    for compiler in compilers:
        machine, _ = machine_of(compiler)
        if machine in makers:
            value = f"{compiler}, for {machine} as {makers[machine]} is"
            raise InputError("--compiler", value, "one for each kind of machine")
        makers[machine] = compiler


def compile_binary(compiler: str, sources: dict[str, str], main: str, name: str) -> Binary:
    """Compile the file `main`, which includes the other sources, into a shared library called `name`.

    Raises
    ------
    InputError : the compiler cannot be run, or compiles for a machine that FMI has no name for.
    NotCompiled : it refused the sources.
    """
    machine, ending = machine_of(compiler)
    # A DLL needs no other file of gcc, and bears no time of day: the same sources give the same file
    apart = ("-static-libgcc", "-Wl,--no-insert-timestamp") if ending == ".dll" else ("-fPIC",)
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        for file, text in sources.items():
            (folder / file).write_text(text, encoding="utf-8")
        library = f"{name}{ending}"
        _run([compiler, *_OPTIONS, *apart, "-o", library, main, "-lm"], folder)
        return Binary(machine=machine, name=library, content=(folder / library).read_bytes())


def machine_of(compiler: str) -> tuple[str, str]:
    """Return the kind of machine that a compiler makes code for, and the ending of its shared libraries.

    Raises
    ------
    InputError : the compiler cannot be run, or compiles for a machine that FMI has no name for.
    """
    field = "--compiler"
    if which(compiler) is None:
        raise InputError(field, compiler, "the command of an installed C compiler, such as gcc")
    triple = _run([compiler, "-dumpmachine"], Path.cwd()).strip()
    processor = _PROCESSORS.get(triple.split("-", 1)[0].lower())
    system = next((known for word, known in _SYSTEMS.items() if word in triple), None)
    if processor is None or system is None:
        bound = "a compiler for Linux, Windows or macOS on x86 or ARM"
        raise InputError(field, f"{compiler} (for {triple or 'an unnamed machine'})", bound)
    return f"{processor}-{system[0]}", system[1]


def _run(command: list[str], folder: Path) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)  # noqa: S603
    if done.returncode != 0:
        lines = (done.stderr or done.stdout).strip().splitlines() or ["nothing"]
        said = next((line for line in lines if "error" in line), lines[0])
        raise NotCompiled(f"{command[0]} ended with code {done.returncode}, saying: {said}")
    return done.stdout

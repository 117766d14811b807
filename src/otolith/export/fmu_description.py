"""The descriptions inside an FMU: `modelDescription.xml` of FMI 2.0 and 3.0, and `buildDescription.xml`.

A value reference is 0 for time, then 1, 2, … for all inputs and then for all outputs, as `fmi/instance.h`
counts them. There are no parameters: the limits, weights and filters of a program are compiled into it, since
they were designed together, and a host that changed one of them would have a program that nobody checked.
"""

import math
from dataclasses import dataclass
from typing import Final, Literal
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from otolith import __version__
from otolith.export.program import Port, Program

Version = Literal["2.0", "3.0"]

# Powers of kg, m, s and rad of the units that programs have. FMI counts the radian as a base unit.
_UNITS: Final[dict[str, dict[str, int]]] = {
    "1": {},
    "m": {"m": 1},
    "m/s": {"m": 1, "s": -1},
    "m/s2": {"m": 1, "s": -2},
    "rad": {"rad": 1},
    "rad/s": {"rad": 1, "s": -1},
    "rad/s2": {"rad": 1, "s": -2},
    "s": {"s": 1},
}
_DEGREES: Final = {"rad": "deg", "rad/s": "deg/s", "rad/s2": "deg/s2"}  # what hosts may show instead


@dataclass(frozen=True, kw_only=True)
class _Variable:
    """One variable of an FMU with the words that both versions of the standard share."""

    reference: int
    port: Port
    causality: Literal["input", "output"]

    def attributes(self) -> dict[str, str]:
        """Name, reference and meaning; inputs may change at any time, outputs once per period."""
        return {
            "name": self.port.name,
            "valueReference": str(self.reference),
            "description": self.port.meaning,
            "causality": self.causality,
            "variability": "continuous" if self.causality == "input" else "discrete",
            "initial": "exact",
        }

    def value(self) -> dict[str, str]:
        """Unit and the value before the first period."""
        unit = unit_name(self.port.unit)
        shown = {"displayUnit": _DEGREES[unit]} if unit in _DEGREES else {}
        return {"unit": unit, **shown, "start": repr(float(self.port.start))}


def unit_name(unit: str) -> str:
    """Return a unit as FMI writes it: `m/s2` for m/s², `1` for none."""
    return unit.replace("²", "2").replace("^", "") or "1"


def model_description(program: Program, version: Version, token: str, sources: list[str]) -> str:
    """Return the text of `modelDescription.xml`.

    Parameters
    ----------
    token : what the host hands over when it makes an instance (FMI 2.0: GUID). The binary knows the same.
    sources : names of the files to compile, which FMI 2.0 lists here and FMI 3.0 in `buildDescription.xml`.
    """
    root = _root(program, version, token)
    simulation = SubElement(root, "CoSimulation", _abilities(program, version))
    if version == "2.0":
        files = SubElement(simulation, "SourceFiles")
        for name in sources:
            SubElement(files, "File", name=name)
    variables = _variables(program)
    _add_units(SubElement(root, "UnitDefinitions"), variables)
    categories = SubElement(root, "LogCategories")
    for name, about in (
        ("logStatusWarning", "A fallback decides."),
        ("logStatusError", "A call is refused."),
    ):
        SubElement(categories, "Category", name=name, description=about)
    SubElement(root, "DefaultExperiment", startTime="0.0", stepSize=repr(program.period))
    listed = SubElement(root, "ModelVariables")
    if version == "3.0":
        time = {"name": "time", "valueReference": "0", "description": "Simulation time", "unit": "s"}
        SubElement(listed, "Float64", time, causality="independent", variability="continuous")
    for variable in variables:
        _add_variable(listed, variable, version)
    _add_structure(SubElement(root, "ModelStructure"), program, version)
    return _text(root)


def build_description(program: Program, sources: list[str]) -> str:
    """Return the text of `sources/buildDescription.xml` (FMI 3.0): what to compile, as which language."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    build = SubElement(root, "BuildConfiguration", modelIdentifier=program.name)
    files = SubElement(build, "SourceFileSet", language="C99")
    for name in sources:
        SubElement(files, "SourceFile", name=name)
    return _text(root)


def _root(program: Program, version: Version, token: str) -> Element:
    key = "guid" if version == "2.0" else "instantiationToken"
    about = {
        "fmiVersion": version,
        "modelName": program.name,
        key: token,
        "description": f"Motion cueing: one decision per {1e3 * program.period:g} ms",
        "generationTool": f"Otolith {__version__}",
        "variableNamingConvention": "flat",
    }
    return Element("fmiModelDescription", about)


def _abilities(program: Program, version: Version) -> dict[str, str]:
    able = {"modelIdentifier": program.name, "canHandleVariableCommunicationStepSize": "true"}
    if version == "2.0":
        states = {"canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true"}
        return {**able, **states, "canNotUseMemoryManagementFunctions": "true"}
    states = {"canGetAndSetFMUState": "true", "canSerializeFMUState": "true"}
    return {**able, **states, "fixedInternalStepSize": repr(program.period)}


def _variables(program: Program) -> list[_Variable]:
    ports = [("input", port) for port in program.inputs] + [("output", port) for port in program.outputs]
    return [
        _Variable(reference=number, port=port, causality="input" if kind == "input" else "output")
        for number, (kind, port) in enumerate(ports, start=1)
    ]


def _add_units(units: Element, variables: list[_Variable]) -> None:
    used = {unit_name(variable.port.unit) for variable in variables} | {"s"}
    for name, powers in _UNITS.items():
        if name not in used:
            continue
        unit = SubElement(units, "Unit", name=name)
        SubElement(unit, "BaseUnit", {base: str(power) for base, power in powers.items()})
        if name in _DEGREES:
            SubElement(unit, "DisplayUnit", name=_DEGREES[name], factor=repr(math.degrees(1.0)))


def _add_variable(listed: Element, variable: _Variable, version: Version) -> None:
    if version == "3.0":
        SubElement(listed, "Float64", {**variable.attributes(), **variable.value()})
        return
    words = variable.attributes()
    if variable.causality == "input":
        del words["initial"]  # FMI 2.0 knows it of inputs, and forbids to say it
    scalar = SubElement(listed, "ScalarVariable", words)
    SubElement(scalar, "Real", variable.value())


def _add_structure(structure: Element, program: Program, version: Version) -> None:
    """List the outputs: by position among all variables (FMI 2.0), or by value reference (FMI 3.0).

    None depends on the inputs of the same moment, so a host need not solve a loop through this FMU.
    """
    first = len(program.inputs) + 1
    numbers = [str(number) for number in range(first, first + len(program.outputs))]
    if version == "2.0":
        outputs = SubElement(structure, "Outputs")
        for number in numbers:
            SubElement(outputs, "Unknown", index=number, dependencies="")
    else:
        for number in numbers:
            SubElement(structure, "Output", valueReference=number, dependencies="")


def _text(root: Element) -> str:
    indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="unicode") + "\n"

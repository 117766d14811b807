"""The text of a program's header: declarations for all, and the implementation for one file."""

import textwrap
from collections.abc import Sequence
from string import Template
from typing import Any, Final

from numpy.typing import NDArray

from otolith.export.program import Port
from otolith.export.translate.render import Rendered

_BROKEN: Final = "; or -1, now and until init, since a model in it has no answer: out is as it was"

Part = tuple[NDArray[Any], int, int]  # an array of the data, and the places in it from … to

_HEADER: Final = Template("""\
/* $name.h: $title

$about

   One source file says

       #define ${NAME}_IMPLEMENTATION
       #include "$name.h"

   and all others include it as it is. Each instance has a struct of its own; there is no other memory, and a
   copy of the struct is a snapshot. $mathematics

   in[]
$inputs

   out[]
$outputs
*/
#ifndef ${NAME}_H
#define ${NAME}_H

#define ${NAME}_PERIOD $period /* [s] between two steps */
#define ${NAME}_INPUTS $input_count
#define ${NAME}_OUTPUTS $output_count

#ifdef __cplusplus
extern "C" {
#endif

typedef struct $name $name;

/* Start at rest, in the neutral pose. */
void ${name}_init($name *me);

/* $returns */
int ${name}_step($name *me, const double in[], double out[]);

$struct

#ifdef __cplusplus
}
#endif

#ifdef ${NAME}_IMPLEMENTATION

#include <math.h>
#include <string.h>

$implementation

void ${name}_init($name *me) {
    memset(me, 0, sizeof *me);
$initial}

int ${name}_step($name *me, const double in[], double out[]) {
$read    const int status = ${name}_$entry(me);
$broken$write    return status;
}

#endif /* ${NAME}_IMPLEMENTATION */
#endif /* ${NAME}_H */
""")


def header(
    rendered: Rendered,
    title: str,
    about: str,
    *,
    returns: str,
    period: float,
    inputs: Sequence[tuple[Port, ...]],
    outputs: Sequence[tuple[Port, ...]],
    read: Sequence[Part],
    write: Sequence[Part],
) -> str:
    """Return the text of a header.

    Parameters
    ----------
    returns : what the number is that a step returns.
    inputs, outputs : ports of every part of `read` and `write`.
    read : where the inputs go, one part after the other.
    write : where the outputs come from.
    """
    flat_in, flat_out = (
        [port for part in inputs for port in part],
        [port for part in outputs for port in part],
    )
    used = rendered.unit.mathematics.library
    needs = f"Of the library of mathematics it needs {', '.join(used)}." if used else "It needs no library."
    implementation = rendered.implementation()
    return _HEADER.substitute(
        name=rendered.name,
        NAME=rendered.name.upper(),
        title=title.replace("*/", "* /").replace("/*", "/ *"),  # a platform's name may hold anything
        about=textwrap.indent(textwrap.fill(about, 107), "   "),
        returns=textwrap.fill(
            f"Do one period. Returns {returns}{_BROKEN if rendered.broken else ''}.",
            107,
            subsequent_indent="   ",
        ),
        mathematics=needs,
        inputs=_ports(flat_in),
        outputs=_ports(flat_out),
        period=repr(period),
        input_count=len(flat_in),
        output_count=len(flat_out),
        struct=rendered.struct(),
        implementation=implementation,
        initial="".join(f"{line}\n" for line in rendered.initial()),
        read="".join(_copies(read, "{here}[i] = in[{at} + i];", rendered)),
        write="".join(_copies(write, "out[{at} + i] = {here}[i];", rendered)),
        entry=rendered.entry.name,
        broken=f"    if ({rendered.broken}) return -1;\n" if rendered.broken else "",
    )


def _ports(ports: Sequence[Port]) -> str:
    width = max(len(port.name) for port in ports)
    return "\n".join(
        f"   {i:3}  {port.name:{width}}  {f'[{port.unit}]' if port.unit else '':9} {port.meaning}"
        for i, port in enumerate(ports)
    )


def _copies(parts: Sequence[Part], line: str, rendered: Rendered) -> list[str]:
    """Return the loops that copy parts of the data from `in` or to `out`."""
    found, at = [], 0
    for array, first, last in parts:
        here = f"({rendered.of(array.reshape(-1)[first:last])})"
        text = line.format(here=here.strip("()") if "+" not in here else here, at=at).replace(
            "[0 + i]", "[i]"
        )
        found.append(f"    for (int i = 0; i < {last - first}; i++) {text}\n")
        at += last - first
    return found

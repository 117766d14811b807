"""Source text of the pass that sums wrong pulls inwards along arcs of contact, with a variable for each row.

Written as a loop over rows, it would keep the running sums in memory, and each stage would wait for the
stores of the stage before.
"""

from otolith.qp.structured.cost import Lines
from otolith.qp.structured.emit import BACKWARD, FORWARD, function, loop
from otolith.qp.structured.layout import Structure


def end_arcs(s: Structure) -> str:
    """Text of `end_arcs`, see `otolith.qp.structured.kernels.working`: EXCESS holds the pulls of all rows.

    It writes to PULL the smaller of two sums, what arrives from the stages before and from those after.
    """
    start = [f"pull{r} = 0.0" for r in range(s.rows)]
    there: Lines = []
    back: Lines = ["k = N - 1 - back"]
    for r in range(s.rows):
        i = f"k*{s.rows} + {r}"
        passed_on = f"pull{r} = W[EXCESS + {i}] + SHARE*smallest(pull{r}, 0.0)"
        there += [passed_on, f"W[PULL + {i}] = pull{r}"]
        back += [passed_on, f"W[PULL + {i}] = smallest(pull{r}, W[PULL + {i}])"]
    return function("end_arcs", "W", start, loop(FORWARD, there), start, loop(BACKWARD.format("N"), back))

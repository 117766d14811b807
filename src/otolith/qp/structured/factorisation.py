"""Source text of `factor`, the backward recursion of matrices; notation as in `emit`.

Matrices over (u_k, x_k) are rows of registers (`packing`, `otolith.core.lanes`): a line below computes four
columns of a row, as a combination of such rows with numbers as factors. T are the rows of [B A], Z = S [B A],
E those of M after the elimination of earlier inputs, G = d E.
"""

from otolith.core.lanes import WIDTH
from otolith.qp.structured.algebra import gram, in_column, symmetric, total, upper
from otolith.qp.structured.cost import Combination, Lines, cost_of
from otolith.qp.structured.emit import (
    BACKWARD,
    all_rows,
    constants,
    eliminate_vector,
    function,
    joined,
    loop,
    of_stage,
    per_stage,
    stage_gradient,
)
from otolith.qp.structured.layout import Structure


def combined(terms: Combination, text: str = "") -> str:
    """Source text of a sum of rows, each times its factor, added to the row `text`."""
    for factor, row in terms:
        if text:
            text = f"add_times4({text}, {factor}, {row})" if factor else f"add4({text}, {row})"
        else:
            text = f"times4({factor}, {row})" if factor else row
    return text


def stage_hessian(s: Structure) -> Lines:
    """Lines that compute S_ij in the upper triangle, from P of x_{k+1}."""
    of_rows, of_cost, packing = gram(all_rows(s), range(s.nc + s.nv), "w"), cost_of(s), s.packing
    size = packing.symmetric_size(s.nu)
    lines = per_stage(s.rows, "DIAGONAL", "w")
    for i, j in upper(s.nx):
        place = size + packing.symmetric(s.nu + i, s.nu + j, s.nu)
        kept = f"W[COST_TO_GO + k*{size} + {place}]"
        terms = [kept, *of_cost.in_state_hessian(i, j), *of_rows.get((i, j), [])]
        lines.append(f"S{i}_{j} = {total(terms)}")
    return lines


def transition(s: Structure) -> Lines:
    """Lines that load the rows of [B A]."""
    packing = s.packing
    base = f"DYNAMICS + k*{packing.dynamics_size}" if s.lengths else "DYNAMICS"
    return [
        f"T{a - s.nu}_{g} = load4(W, {base} + {packing.dynamics_row(a, g)})"
        for a in packing.states
        for g in packing.own[a]
    ]


def input_hessian(s: Structure) -> Lines:
    """Lines that compute M, without what the rows add to the inputs; Z is needed for one part at a time."""
    packing, S, BA, cost = s.packing, symmetric(s.nx, "S"), joined(s), cost_of(s)
    lines: Lines = []
    for part in packing.parts:
        for i in (a - s.nu for a in part if a >= s.nu):
            for g in packing.groups:
                states = [a - s.nu for a in packing.states if g in packing.own[a]]
                if states:
                    lines.append(f"Z{i}_{g} = {combined([(S[i, j], f'T{j}_{g}') for j in states])}")
        for a in part:
            for g in packing.later(a):
                terms = [(symbol, f"Z{i}_{g}") for i, symbol in in_column(BA, a)]
                lines.append(f"M{a}_{g} = {combined(terms + cost.in_joint_hessian(a, g))}")
    return lines


def eliminate_inputs(s: Structure) -> Lines:
    """Lines that eliminate the inputs: pivots d and gains f are stored in GAIN."""
    packing, first, lines = s.packing, s.nc + s.nv, Lines()
    for j in range(s.nu):
        own, lane, after = packing.group(j), packing.lane(j), range(j + 1, s.nu + s.nx)
        for g in packing.groups:
            row = f"M{j}_{g}"
            row = combined([(f"w{first + j}", f"unit4({lane})")], row) if g == own else row
            lines.append(f"E{j}_{g} = {less_earlier(row, j, g, range(j))}")
        lines.append(f"d{j} = 1.0 / lane4(E{j}_{own}, {lane})")
        lines.append(f"W[GAIN + k*{s.gains} + {s.pivot(j)}] = d{j}")
        for g in packing.groups:
            lines.append(f"G{j}_{g} = times4(d{j}, E{j}_{g})")
            place = j * packing.width + WIDTH * g
            lines.append(f"store4(W, GAIN + k*{s.gains} + {place}, G{j}_{g})")
        lines += [f"f{j}_{a} = lane4(G{j}_{packing.group(a)}, {packing.lane(a)})" for a in after]
    return lines


def less_earlier(row: str, a: int, group: int, inputs: range) -> str:
    """Source text of a group of row a of M after the elimination of `inputs`."""
    for j in inputs:
        row = f"less_times4({row}, f{j}_{a}, E{j}_{group})"
    return row


def remaining_states(s: Structure) -> Lines:
    """Lines that store what remains in x_k, the next P."""
    packing = s.packing
    size = packing.symmetric_size(s.nu)
    return [
        f"store4(W, COST_TO_GO + k*{size} + {packing.symmetric_row(a, g, s.nu)}, "
        f"{less_earlier(f'M{a}_{g}', a, g, range(s.nu))})"
        for a in packing.states
        for g in packing.later(a)
    ]


def factor(s: Structure) -> str:
    """Text of `factor`: it factors the stages `last` … 0 and sweeps the gradient back; later stages keep
    their factors.
    """
    return function(
        "factor",
        "W, last",
        ["backward(W, last + 1)"],
        constants(s),
        [] if s.lengths else transition(s),
        [f"p{i} = W[COSTATE + {i}]" for i in range(s.nx)],
        loop(
            BACKWARD.format("last + 1"),
            ["k = last - back"],
            of_stage(s),
            transition(s) if s.lengths else [],
            cost_of(s).loads(),
            stage_gradient(s),
            stage_hessian(s),
            input_hessian(s),
            eliminate_inputs(s),
            remaining_states(s),
            eliminate_vector(s),
        ),
    )

"""Source text for blocks: inputs held for several steps, rows only at the ends of blocks, the cost at every
step.

Within block k of n steps, step j = 1 … n leads from the block's start to x_j = A^j x_k + B_j u_k with B_j =
Σ_{i<j} A^i B. In z = (u_k, x_k) the block's cost is ½ zᵀ H z + hᵀ z with

    H = Σ_j [B_j A^j]ᵀ (Dᵀ D + diag(W)) [B_j A^j] + n diag(R, 0)
    h = Σ_j [B_j A^j]ᵀ (Dᵀ e + p) + (Σ_j r, 0),

and the recursions of `emit` run over blocks instead of steps, with A^n and B_n in place of A and B.
"""

from collections.abc import Iterable
from itertools import chain

from otolith.core.lanes import WIDTH
from otolith.qp.structured.algebra import in_row, product, total
from otolith.qp.structured.cost import Lines
from otolith.qp.structured.emit import dynamics, function, loop
from otolith.qp.structured.factorisation import combined, transition
from otolith.qp.structured.layout import Structure, data

BLOCKS = "for k in range(N):"
STEPS = "for j in range(LENGTHS[k]):"


def condense_blocks(s: Structure) -> str:
    """Text of the function that computes H and h of all blocks from the costs of their steps."""
    packing = s.packing
    start, kept = Lines(), Lines()
    for a in packing.variables:
        for g in packing.later(a):
            own = a < s.nu and g == packing.group(a)
            weight = f"LENGTHS[k]*W[CONTROL_WEIGHT + {a}]" if own else "0.0"
            start.append(f"H{a}_{g} = times4({weight}, unit4({packing.lane(a) if own else 0}))")
            place = packing.symmetric_row(a, g)
            kept.append(f"store4(W, BLOCK_HESSIAN + k*{packing.symmetric_size()} + {place}, H{a}_{g})")
    for g in packing.groups:
        inputs = [
            (f"W[INPUT_LINEAR + k*{s.nu} + {j}]", f"unit4({packing.lane(j)})")
            for j in range(s.nu)
            if packing.group(j) == g
        ]
        start.append(f"h{g} = {combined(inputs or [('0.0', 'unit4(0)')])}")
        kept.append(f"store4(W, BLOCK_GRADIENT + k*{packing.width} + {WIDTH * g}, h{g})")
    of_step = loop(STEPS, _rows_of_step(s), _outputs(s), _squares(s), ["step += 1"])
    return function("condense_blocks", "W", ["step = 0"], loop(BLOCKS, start, of_step, kept))


def _rows_of_step(s: Structure) -> Lines:
    """Lines that load the rows of [B_j A^j]."""
    return [line.replace("DYNAMICS + k*", "POWERS + j*") for line in transition(s)]


def dynamics_of_step(s: Structure) -> Lines:
    """Lines that load A^j and B_j."""
    return dynamics(s, f"j*{s.packing.dynamics_size} + ", "POWERS")


def _outputs(s: Structure) -> Lines:
    """Lines that load the D of a step and compute its rows on z: r = D [B_j A^j]."""
    packing = s.packing
    lines = [f"{s.D[p]} = W[OUTPUT + step*{len(s.D)} + {n}]" for n, p in enumerate(data(s.D))]
    for y in range(s.ny):
        for g in _touched(s, [i for i, _ in in_row(s.D, y)]):
            terms = [(d, f"T{i}_{g}") for i, d in in_row(s.D, y) if g in packing.own[s.nu + i]]
            lines.append(f"r{y}_{g} = {combined(terms)}")
    return lines


def _touched(s: Structure, states: Iterable[int]) -> list[int]:
    """The groups of the variables on which these states depend."""
    return sorted({g for i in states for g in s.packing.own[s.nu + i]})


def _squares(s: Structure) -> Lines:
    """Lines that add one step's share to H and h."""
    lines: Lines = []
    for y in range(s.ny):
        groups, error = _touched(s, [i for i, _ in in_row(s.D, y)]), f"W[ERROR + step*{s.ny} + {y}]"
        lines += _square(s, f"r{y}", groups, "", error)
    for n, i in enumerate(s.weighted):
        at = f"step*{len(s.weighted)} + {n}]"
        lines += _square(s, f"T{i}", _touched(s, [i]), f"W[STATE_WEIGHT + {at}", f"W[STATE_LINEAR + {at}")
    return lines


def _square(s: Structure, row: str, groups: list[int], weight: str, linear: str) -> Lines:
    """Lines that add weight·rᵀ r to H and linear·r to h, for a row r on z that is zero but in `groups`."""
    packing = s.packing
    lines = [f"h{g} = add_times4(h{g}, {linear}, {row}_{g})" for g in groups]
    for a in packing.variables:
        if packing.group(a) in groups:
            factor = product(f"lane4({row}_{packing.group(a)}, {packing.lane(a)})", weight)
            later = [g for g in packing.later(a) if g in groups]
            lines += [f"H{a}_{g} = add_times4(H{a}_{g}, {factor}, {row}_{g})" for g in later]
    return lines


def states_within(s: Structure) -> str:
    """Text of the function that writes the states of all steps under U, each from its block's start, to
    STEP_STATE.
    """
    start = ["before = X + (k - 1)*NX if k > 0 else START"]
    start += [f"x{i} = W[before + {i}]" for i in range(s.nx)] + [
        f"u{a} = W[U + k*{s.nu} + {a}]" for a in range(s.nu)
    ]
    states = []
    for i in range(s.nx):
        terms = chain(
            (product(f, f"x{j}") for j, f in in_row(s.A, i)), (product(f, f"u{j}") for j, f in in_row(s.B, i))
        )
        states.append(f"W[STEP_STATE + step*{s.nx} + {i}] = {total(terms)}")
    of_step = loop(STEPS, dynamics_of_step(s), states, ["step += 1"])
    return function("states_within", "W", ["step = 0"], loop(BLOCKS, start, of_step))


def preparation(s: Structure) -> str:
    """Text of the two functions that blocks need before and after a solve; both are empty without blocks."""
    if s.lengths:
        return condense_blocks(s) + "\n\n" + states_within(s)
    return "\n\n".join(function(name, "W", ["pass"]) for name in ("condense_blocks", "states_within"))

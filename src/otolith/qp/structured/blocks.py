"""Source text for blocks: inputs held for several steps, rows only at the ends of blocks, the cost at every
step.

Within block k of n steps, step j = 1 … n leads from the block's start to x_j = A^j x_k + B_j u_k with B_j =
Σ_{i<j} A^i B. In z = (u_k, x_k) the block's cost is ½ zᵀ H z + hᵀ z with

    H = Σ_j [B_j A^j]ᵀ (Dᵀ D + diag(W)) [B_j A^j] + n diag(R, 0)
    h = Σ_j [B_j A^j]ᵀ (Dᵀ e + p) + (Σ_j r, 0),

and the recursions of `emit` run over blocks instead of steps, with A^n and B_n in place of A and B.
"""

from itertools import chain

from otolith.qp.structured.algebra import in_column, in_row, product, total, upper
from otolith.qp.structured.cost import Lines
from otolith.qp.structured.emit import dynamics, function, joined, loop
from otolith.qp.structured.layout import Structure, data

BLOCKS = "for k in range(N):"
STEPS = "for j in range(LENGTHS[k]):"


def condense_blocks(s: Structure) -> str:
    """Text of the function that computes H and h of all blocks from the costs of their steps."""
    size = s.nu + s.nx
    triangle = upper(size)
    start = [f"H{a}_{b} = 0.0" for a, b in triangle] + [f"h{a} = 0.0" for a in range(size)]
    for a in range(s.nu):
        start[triangle.index((a, a))] = f"H{a}_{a} = LENGTHS[k] * W[CONTROL_WEIGHT + {a}]"
        start[len(triangle) + a] = f"h{a} = W[INPUT_LINEAR + k*{s.nu} + {a}]"
    kept = [f"W[BLOCK_HESSIAN + k*{len(triangle)} + {n}] = H{a}_{b}" for n, (a, b) in enumerate(triangle)]
    kept += [f"W[BLOCK_GRADIENT + k*{size} + {a}] = h{a}" for a in range(size)]
    of_step = loop(STEPS, dynamics_of_step(s), _outputs(s), _squares(s), ["step += 1"])
    return function("condense_blocks", "W", ["step = 0"], loop(BLOCKS, start, of_step, kept))


def dynamics_of_step(s: Structure) -> Lines:
    """Lines that load A^j and B_j."""
    return [line.replace("DYNAMICS", "POWERS") for line in dynamics(s, f"j*{s.dynamics} + ")]


def _outputs(s: Structure) -> Lines:
    """Lines that load the D of a step and compute its rows on z: r = D [B_j A^j]."""
    lines = [f"{s.D[p]} = W[OUTPUT + step*{len(s.D)} + {n}]" for n, p in enumerate(data(s.D))]
    BA = joined(s)
    for y in range(s.ny):
        for a in range(s.nu + s.nx):
            terms = _row_times_column(in_row(s.D, y), dict(in_column(BA, a)))
            lines += [f"r{y}_{a} = {total(terms)}"] if terms else []
    return lines


def _row_times_column(row: list[tuple[int, str]], column: dict[int, str]) -> Lines:
    return [product(d, column[i]) for i, d in row if i in column]


def _squares(s: Structure) -> Lines:
    """Lines that add one step's share to H and h."""
    BA = joined(s)
    hessian: dict[tuple[int, int], Lines] = {}
    gradient: dict[int, Lines] = {}
    for y in range(s.ny):
        columns = [a for a in range(s.nu + s.nx) if _row_times_column(in_row(s.D, y), dict(in_column(BA, a)))]
        for n, a in enumerate(columns):
            gradient.setdefault(a, []).append(f"r{y}_{a}*W[ERROR + step*{s.ny} + {y}]")
            for b in columns[n:]:
                hessian.setdefault((a, b), []).append(f"r{y}_{a}*r{y}_{b}")
    for n, i in enumerate(s.weighted):
        row, at = in_row(BA, i), f"step*{len(s.weighted)} + {n}"
        for m, (a, f) in enumerate(row):
            gradient.setdefault(a, []).append(product(f, f"W[STATE_LINEAR + {at}]"))
            for b, g in row[m:]:
                hessian.setdefault((a, b), []).append(product(f, g, f"W[STATE_WEIGHT + {at}]"))
    lines = [f"H{a}_{b} += {total(terms)}" for (a, b), terms in sorted(hessian.items())]
    return lines + [f"h{a} += {total(terms)}" for a, terms in sorted(gradient.items())]


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

"""Source text of the stage recursions, one function each, unrolled within a stage.

The notation is that of `otolith.qp.stage`. The rows enter the recursions as ½ w_r r² + c_r r, where r is the
row's value, w is DIAGONAL and c is GRADIENT in the workspace: an augmented Lagrangian or a barrier, see the
kernels. Backward in k, with P, p of the cost-to-go ½ xᵀP x + pᵀx of x_{k+1} from the later stages:

    S = P + Dᵀ D + diag(W) + Σ_r w_r C_rᵀ C_r              Hessian in x_{k+1}
    s = p + Dᵀ e + p_k + Σ_r c_r C_rᵀ                      its gradient
    M = [B A]ᵀ S [B A] + diag(R + w_inputs, 0)             Hessian in (u_k, x_k)
    m = [B A]ᵀ s + (r_k + c_inputs, 0)

(when stages are blocks, their cost enters M and m instead, and A, B are the block's: see `cost`). The inputs
are eliminated one by one (L D Lᵀ without square roots). For input j, with a and b all indices after j,

    E_jb = M_jb − Σ_{i<j} f_ij E_ib,   d_j = 1/E_jj,   f_ja = d_j E_ja,   h_j = m_j − Σ_{i<j} f_ij h_i,

and what remains in x_k is the next P_ab = M_ab − Σ_j f_ja E_jb and p_a = m_a − Σ_j f_ja h_j. Forward: u_j =
−d_j h_j − Σ_{a after j} f_ja (u, x)_a. Here C includes V_k. Every name is assigned once per stage, which
helps the compiler.
"""

from collections.abc import Iterable
from itertools import chain

from otolith.qp.structured.algebra import (
    Matrix,
    in_column,
    in_row,
    product,
    total,
)
from otolith.qp.structured.cost import Lines, cost_of
from otolith.qp.structured.layout import Structure, data


def function(name: str, arguments: str, *bodies: Iterable[str], result: str = "") -> str:
    """Text of one compiled function."""
    lines = [f"    {line}" for line in chain(*bodies)]
    ending = [f"    return {result}"] if result else []
    return "\n".join(["@jit_fused", f"def {name}({arguments}):", *lines, *ending]) + "\n"


def loop(header: str, *bodies: Iterable[str]) -> Lines:
    """Lines of a loop with its body indented."""
    return [header, *(f"    {line}" for line in chain(*bodies))]


BACKWARD = "for back in range({}):"
FORWARD = "for k in range(N):"


def load(M: Matrix, part: str, first: int = 0, base: str = "") -> Lines:
    """Lines that read the data of a sparse matrix from the workspace into its names."""
    return [f"{M[p]} = W[{part} + {base}{first + n}]" for n, p in enumerate(data(M))]


def per_stage(count: int, part: str, letter: str) -> Lines:
    """Lines that read `count` numbers of stage k of a part into letter0, letter1, …"""
    return [f"{letter}{n} = W[{part} + k*{count} + {n}]" for n in range(count)]


def dynamics(s: Structure, base: str = "", part: str = "DYNAMICS") -> Lines:
    """Lines that load the numbers of A and B."""
    packing = s.packing
    entries = [(s.A[i, j], i, s.nu + j) for i, j in data(s.A)] + [(s.B[i, j], i, j) for i, j in data(s.B)]
    return [f"{name} = W[{part} + {base}{packing.dynamics(s.nu + i, a)}]" for name, i, a in entries]


def constants(s: Structure) -> Lines:
    """Lines that load all data common to all stages: C, R, and A, B unless stages are blocks."""
    of_inputs = [f"R{j} = W[CONTROL_WEIGHT + {j}]" for j in range(s.nu)]
    return load(s.C, "CONSTANT") + (of_inputs + dynamics(s) if not s.lengths else [])


def of_stage(s: Structure) -> Lines:
    """Lines that load the data that differ from stage to stage: V_k, and A, B of a block."""
    return load(s.V, "VARYING", base=f"k*{len(s.V)} + ") + (
        dynamics(s, f"k*{s.packing.dynamics_size} + ") if s.lengths else []
    )


def all_rows(s: Structure) -> Matrix:
    """The rows on the state (C; V_k): constant rows first, then varying ones."""
    return s.C | {(s.nc + r, i): symbol for (r, i), symbol in s.V.items()}


def state_terms(s: Structure, i: int, *, cost: bool = True) -> Lines:
    """Terms of s_i: from the later stages, the rows, and, if `cost` is set, the cost."""
    terms = [f"p{i}"] + [product(f"c{r}", a) for r, a in in_column(all_rows(s), i)]
    return terms + (cost_of(s).in_state_gradient(i) if cost else [])


def stage_gradient(s: Structure, *, cost: bool = True) -> Lines:
    """Lines that compute all s_i."""
    lines = per_stage(s.rows, "GRADIENT", "c")
    return lines + [f"s{i} = {total(state_terms(s, i, cost=cost))}" for i in range(s.nx)]


def joined(s: Structure) -> Matrix:
    """The matrix [B A]: column a < nu belongs to input a, column nu + i to state i."""
    return s.B | {(i, s.nu + j): symbol for (i, j), symbol in s.A.items()}


def reduced(entry: str, letter: str, inputs: int, a: int, b: int | None = None) -> str:
    """An entry of M or m in row a after the elimination of the first `inputs` inputs, as text."""
    column = "" if b is None else f"_{b}"
    return entry + "".join(f" - f{i}_{a}*{letter}{i}{column}" for i in range(inputs))


def eliminate_vector(s: Structure) -> Lines:
    """Lines that store the feed-forward d h of the inputs in GAIN; p of x_k remains."""
    lines = input_gradient(s)
    for j in range(s.nu):
        lines.append(f"h{j} = {reduced(f'm{j}', 'h', j, j)}")
        lines.append(f"W[GAIN + k*{s.gains} + {s.feed_forward(j)}] = d{j}*h{j}")
    return lines + [f"p{i} = {reduced(f'm{s.nu + i}', 'h', s.nu, s.nu + i)}" for i in range(s.nx)]


def input_terms(s: Structure, a: int, *, cost: bool = True) -> Lines:
    """Terms of m_a, see `input_gradient`."""
    first = s.nc + s.nv
    terms = [product(symbol, f"s{i}") for i, symbol in in_column(joined(s), a)]
    return terms + (cost_of(s).in_joint_gradient(a) + ([f"c{first + a}"] if a < s.nu else []) if cost else [])


def input_gradient(s: Structure, *, cost: bool = True) -> Lines:
    """Lines of m = [B A]ᵀ s + (r_k + c_inputs, 0), or of [B A]ᵀ s alone if `cost` is not set."""
    return [f"m{a} = {total(input_terms(s, a, cost=cost))}" for a in range(s.nu + s.nx)]


def backward(s: Structure) -> str:
    """Text of `backward`: it sweeps the gradient back over the stages N−1 … `first` with their existing
    factors.
    """
    gains = [f"d{j} = W[GAIN + k*{s.gains} + {s.pivot(j)}]" for j in range(s.nu)]
    gains += [
        f"f{j}_{a} = W[GAIN + k*{s.gains} + {s.gain(j, a)}]"
        for j in range(s.nu)
        for a in range(j + 1, s.nu + s.nx)
    ]
    return function(
        "backward",
        "W, first",
        constants(s),
        [f"p{i} = 0.0" for i in range(s.nx)],
        loop(
            BACKWARD.format("N - first"),
            ["k = N - 1 - back"],
            of_stage(s),
            cost_of(s).loads(),
            stage_gradient(s),
            gains,
            eliminate_vector(s),
        ),
        [f"W[COSTATE + {i}] = p{i}" for i in range(s.nx)],
    )


def next_state(s: Structure) -> Lines:
    """Lines that compute the next state X ← A x + B u and store it with the values of all rows."""
    lines = []
    for i in range(s.nx):
        terms = [product(a, f"x{j}") for j, a in in_row(s.A, i)] + [
            product(b, f"u{j}") for j, b in in_row(s.B, i)
        ]
        lines.append(f"n{i} = {total(terms)}")
    lines += [f"x{i} = n{i}" for i in range(s.nx)]
    lines += [f"W[X + k*{s.nx} + {i}] = x{i}" for i in range(s.nx)]
    values = [total(product(a, f"x{j}") for j, a in in_row(all_rows(s), r)) for r in range(s.nc + s.nv)]
    values += [f"u{j}" for j in range(s.nu)]
    return lines + [f"W[VALUE + k*{s.rows} + {r}] = {value}" for r, value in enumerate(values)]


def initial_state(s: Structure) -> Lines:
    """Lines that set X ← x_0."""
    return [f"x{i} = W[START + {i}]" for i in range(s.nx)]


def forward(s: Structure) -> str:
    """Text of `forward`: it computes the inputs by the factors' feedback law, with their states and rows."""
    law: Lines = []
    for j in reversed(range(s.nu)):
        law.append(f"u{j} = -W[GAIN + k*{s.gains} + {s.feed_forward(j)}]")
        for a in reversed(range(j + 1, s.nu + s.nx)):
            factor_of = f"u{a}" if a < s.nu else f"x{a - s.nu}"
            law[-1] += f" - W[GAIN + k*{s.gains} + {s.gain(j, a)}]*{factor_of}"
    kept = [f"W[U + k*{s.nu} + {j}] = u{j}" for j in range(s.nu)]
    return function(
        "forward", "W", constants(s), initial_state(s), loop(FORWARD, of_stage(s), law, kept, next_state(s))
    )


def rollout(s: Structure) -> str:
    """Text of `rollout`: it computes the states and rows of the inputs U."""
    given = per_stage(s.nu, "U", "u")
    return function(
        "rollout", "W", constants(s), initial_state(s), loop(FORWARD, of_stage(s), given, next_state(s))
    )


def absolute(terms: Iterable[str]) -> str:
    """Text of the sum of the terms' absolute values."""
    return total(f"abs({term})" for term in terms)


def stationarity(s: Structure) -> str:
    """Text of `stationarity`: the gradient of the Lagrangian at U, X with the rows' multipliers in GRADIENT.

    It equals `otolith.qp.stage.stationarity`. The function returns three numbers: the largest |∂L/∂u|; the
    largest
    |∂L/∂u| relative to its terms; Σ_j (largest sum of terms)·(largest |u_j|).
    """
    at_errors, at_states, at_inputs = cost_of(s).at_point()
    added = dict(line.split(" += ") for line in at_states + at_inputs)  # what the point adds to s and m
    judged: Lines = []
    for i in sorted({i for i, _ in s.B}):
        terms = state_terms(s, i) + ([added[f"s{i}"]] if f"s{i}" in added else [])
        judged.append(f"S{i} = {absolute(terms)}")
    for j in range(s.nu):
        terms = [product(f"abs({b})" if b else "", f"S{i}") for i, b in in_column(s.B, j)]
        own = absolute([*input_terms(s, j)[len(terms) :], added[f"m{j}"]])
        judged += [f"worst{j} = largest(worst{j}, abs(m{j}))", f"sum_of_squares += m{j}*m{j}"]
        judged.append(f"terms{j} = largest(terms{j}, {total([*terms, own])})")
        judged.append(f"most{j} = largest(most{j}, abs(W[U + k*{s.nu} + {j}]))")
    ending = ["worst = part = whole = 0.0"]
    for j in range(s.nu):
        ending += [f"worst = largest(worst, worst{j})", f"whole += terms{j}*most{j}"]
        ending.append(f"part = largest(part, worst{j} / terms{j} if worst{j} > 0.0 else 0.0)")
    ending += ["good = sum_of_squares < HUGE"]  # a maximum ignores NaN, a sum does not
    return function(
        "stationarity",
        "W",
        constants(s),
        ["sum_of_squares = 0.0"],
        [f"worst{j} = terms{j} = most{j} = 0.0" for j in range(s.nu)],
        [f"p{i} = 0.0" for i in range(s.nx)],
        loop(
            BACKWARD.format("N"),
            ["k = N - 1 - back"],
            of_stage(s),
            cost_of(s).loads(),
            at_errors,
            stage_gradient(s),
            at_states,
            input_gradient(s),
            at_inputs,
            judged,
            [f"p{i} = m{s.nu + i}" for i in range(s.nx)],
        ),
        ending,
        result="(worst, part, whole) if good else (INFINITY, INFINITY, INFINITY)",
    )


def least_of_rows(s: Structure) -> str:
    """Text of `least_of_rows`: smallest value of Σ c_r r over all inputs within their bounds, c in GRADIENT.

    Only rows on states count. Σ c_r r = p₀ᵀ x_0 + Σ_k g_kᵀ u_k, where g are the rows' costates multiplied by
    Bᵀ. The inputs are bounded one by one, so the sign of g decides which side gives the minimum. If that side
    has no bound, the input's pivot row takes the input's share: the c of that row changes by −g / (C B),
    which leaves g = 0. Any c is valid in a proof, provided the caller accounts for its final value. The
    second result is the sum of all absolute values, for judging rounding errors.
    """
    least = []
    for j in range(s.nu):
        row = f"k*{s.rows} + {s.nc + s.nv + j}"
        left = (
            f"m{j}" if j not in s.pivots else f"(g{j} if t{j} == 0.0 else 0.0)"
        )  # without the rounding error of g + C B t
        least.append(f"of_input = min_of({left}, W[LOWER + {row}], W[UPPER + {row}])")
        least += ["least += of_input", "size += abs(of_input)"]
    start = [f"of_state = p{i}*W[START + {i}]\nleast += of_state\nsize += abs(of_state)" for i in range(s.nx)]
    return function(
        "least_of_rows",
        "W",
        constants(s),
        ["least = 0.0", "size = 0.0"],
        [f"p{i} = 0.0" for i in range(s.nx)],
        loop(
            BACKWARD.format("N"),
            ["k = N - 1 - back"],
            of_stage(s),
            stage_gradient(s, cost=False),
            pivoting(s),
            input_gradient(s, cost=False),
            least,
            [f"p{i} = m{s.nu + i}" for i in range(s.nx)],
        ),
        chain.from_iterable(text.split("\n") for text in start),
        result="least, size",
    )


def pivoting(s: Structure) -> Lines:
    """Lines that let the pivot rows take the pull on an input towards a side without a bound; s is
    updated.
    """
    lines: Lines = []
    for j, row in s.pivots.items():
        bound, column = f"k*{s.rows} + {s.nc + s.nv + j}", dict(in_column(s.B, j))
        pull = (product(b, f"s{i}") for i, b in column.items())
        reach = (product(c, column[i]) for i, c in in_row(s.C, row) if i in column)
        lines += [
            f"g{j} = {total(pull)}",
            f"t{j} = taken(g{j}, {total(reach)}, W[LOWER + {bound}], W[UPPER + {bound}])",
            f"W[GRADIENT + k*{s.rows} + {row}] += t{j}",
        ]
        lines += [f"s{i} += {product(c, f't{j}')}" for i, c in in_row(s.C, row)]
    return lines


def recursions(s: Structure) -> str:
    """Text of all stage recursions but `factor`, see `factorisation`."""
    emitters = (backward, forward, rollout, stationarity, least_of_rows)
    return "\n\n".join(emit(s) for emit in emitters)

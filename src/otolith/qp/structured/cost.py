"""How the cost of a stage enters the recursions of `emit`: two forms with the same interface.

Each form returns source text: the terms that it adds to the Hessian and gradient in x_{k+1} (S, s) and in
(u_k, x_k) (M, m), the loads that these need, and what turns the gradient at zero into the gradient at a
point.
"""

from otolith.qp.structured.algebra import gram, in_column, in_row, product, total
from otolith.qp.structured.layout import Structure, data

Lines = list[str]
Terms = list[str]
Combination = list[tuple[str, str]]  # factors, numbers, and the vectors of four that they multiply


class OnOutputs:
    """The cost as a function of outputs: ½‖D x_{k+1} + e‖² + Σ (½ W x² + p x)_{k+1} + ½ uᵀ diag(R) u + rᵀ
    u.
    """

    def __init__(self, s: Structure) -> None:
        self._s = s
        self._squares = gram(s.D, range(s.ny))

    def loads(self) -> Lines:
        """Lines that load D_k and e_k of stage k."""
        s = self._s
        entries = [f"{s.D[p]} = W[OUTPUT + k*{len(s.D)} + {n}]" for n, p in enumerate(data(s.D))]
        return entries + [f"e{y} = W[ERROR + k*{s.ny} + {y}]" for y in range(s.ny)]

    def in_state_hessian(self, i: int, j: int) -> Terms:
        """Terms that the cost adds to S_ij."""
        return self._squares.get((i, j), []) + (self._weighted("STATE_WEIGHT", i) if i == j else [])

    def in_state_gradient(self, i: int) -> Terms:
        """Terms that the cost adds to s_i."""
        return [product(f"e{y}", a) for y, a in in_column(self._s.D, i)] + self._weighted("STATE_LINEAR", i)

    def in_joint_hessian(self, a: int, group: int) -> Combination:
        """What the cost adds to a group of row a of M."""
        packing = self._s.packing
        own = a < self._s.nu and group == packing.group(a)
        return [(f"R{a}", f"unit4({packing.lane(a)})")] if own else []

    def in_joint_gradient(self, a: int) -> Terms:
        """Terms that the cost adds to m_a."""
        return [f"W[INPUT_LINEAR + k*{self._s.nu} + {a}]"] if a < self._s.nu else []

    def at_point(self) -> tuple[Lines, Lines, Lines]:
        """Lines that add the effect of the point (u_k, x_{k+1}) to e, to s and to m."""
        s = self._s
        state = [f"x{i} = W[X + k*{s.nx} + {i}]" for i in range(s.nx)]
        force = [f"e{y} += {total(product(a, f'x{i}') for i, a in in_row(s.D, y))}" for y in range(s.ny)]
        washout = [f"s{i} += {self._weighted('STATE_WEIGHT', i)[0]}*x{i}" for i in s.weighted]
        return state + force, washout, [f"m{j} += R{j}*W[U + k*{s.nu} + {j}]" for j in range(s.nu)]

    def _weighted(self, part: str, state: int) -> Terms:
        weighted = self._s.weighted
        return [f"W[{part} + k*{len(weighted)} + {n}]" for n, i in enumerate(weighted) if i == state]


class OnBlocks:
    """The cost of all steps of a block: ½ zᵀ H z + hᵀ z with z = (u_k, x_k), see `blocks`."""

    def __init__(self, s: Structure) -> None:
        self._s = s

    def loads(self) -> Lines:
        """No lines: each number is used only once, so nothing is loaded in advance."""
        return []

    def in_state_hessian(self, i: int, j: int) -> Terms:
        """No terms in S_ij: this cost is a function of z alone."""
        del i, j
        return []

    def in_state_gradient(self, i: int) -> Terms:
        """No terms in s_i: this cost is a function of z alone."""
        del i
        return []

    def in_joint_hessian(self, a: int, group: int) -> Combination:
        """What the cost adds to a group of row a of M."""
        packing = self._s.packing
        place = packing.symmetric_row(a, group)
        return [("", f"load4(W, BLOCK_HESSIAN + k*{packing.symmetric_size()} + {place})")]

    def in_joint_gradient(self, a: int) -> Terms:
        """Terms that the cost adds to m_a."""
        packing = self._s.packing
        return [f"W[BLOCK_GRADIENT + k*{packing.width} + {packing.column[a]}]"]

    def at_point(self) -> tuple[Lines, Lines, Lines]:
        """Lines that add the effect of the point z to m."""
        s = self._s
        state = ["before = X + (k - 1)*NX if k > 0 else START"]
        state += [f"z{s.nu + i} = W[before + {i}]" for i in range(s.nx)]
        state += [f"z{j} = W[U + k*{s.nu} + {j}]" for j in range(s.nu)]
        packing, each = s.packing, range(s.nu + s.nx)
        entry = f"W[BLOCK_HESSIAN + k*{packing.symmetric_size()} + {{}}]"
        rows = (total(f"{entry.format(packing.symmetric(a, b))}*z{b}" for b in each) for a in each)
        return state, [], [f"m{a} += {row}" for a, row in enumerate(rows)]


def cost_of(s: Structure) -> OnOutputs | OnBlocks:
    """Choose the form of the cost for a structure: `OnBlocks` if it has blocks, else `OnOutputs`."""
    return OnBlocks(s) if s.lengths else OnOutputs(s)

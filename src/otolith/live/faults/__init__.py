"""The fault matrix: every fault that can be played in virtual time, what must follow, and what does."""

from otolith.live.faults.case import ENGAGED_S, Case, Result, run_case
from otolith.live.faults.matrix import CASES, ROWS, prepare, row_of, run_matrix

__all__ = ["CASES", "ENGAGED_S", "ROWS", "Case", "Result", "prepare", "row_of", "run_case", "run_matrix"]

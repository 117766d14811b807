"""The best motion that a platform allows for a drive that is known as a whole (Katliar, 2020)."""

from otolith.cueing.optimum.optimum import NAME, NoOptimum, Optimum, check, measure_of, optimum

__all__ = ["NAME", "NoOptimum", "Optimum", "check", "measure_of", "optimum"]

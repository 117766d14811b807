"""Enumerate the explicit law of a small problem, look it up, and check one answer by hand."""

import numpy as np

from otolith.mpqp import ParametricQp, enumerate_regions

# min_z ½ z² − θ z with |z| ≤ 1: the law is z = θ, cut off at ±1, so there are three regions.
problem = ParametricQp(
    H=np.eye(1),
    f=np.zeros(1),
    F=-np.eye(1),
    G=np.array([[1.0], [-1.0]]),
    w=np.ones(2),
    S=np.zeros((2, 1)),
    lower=np.array([-3.0]),
    upper=np.array([3.0]),
)
law = enumerate_regions(problem)
print(f"{len(law)} regions")
for theta in (-2.0, 0.4, 1.5):
    print(f"theta = {theta:+.1f}: z = {law.evaluate(np.array([theta])).z[0]:+.3f}")

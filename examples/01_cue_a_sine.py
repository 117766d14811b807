"""Cue a sine with the hybrid controller and print what it cost and how well it was felt."""

from otolith import metrics
from otolith.cueing.design import Design, hybrid_all
from otolith.plant import Ideal
from otolith.platforms import load
from otolith.scenarios import scenario
from otolith.simulate import simulate

platform = load("thesis")
run = simulate(
    hybrid_all(Design(platform=platform)),
    Ideal(),
    scenario("sine:amplitude=0.8,frequency=0.15,duration=8"),
    platform=platform,
    dofs=("surge-pitch",),
)
summary = metrics.summarise(run)
print(f"RMSE {summary['rmse']:.4f} m/s², {summary['violations']} limit violations")
print(f"working-set changes: {summary['changes']}")

"""Cue a sine with the hybrid controller and print what it cost and how well it was felt."""

import otolith

wanted = otolith.Wanted(scenario="sine:amplitude=0.8,frequency=0.15,duration=8")
design = otolith.Design(platform=otolith.platform("thesis"))
run = otolith.Experiment(wanted=wanted, design=design).run()
summary = otolith.summarise(run)
print(f"RMSE {summary['rmse']:.4f} m/s², {summary['violations']} limit violations")
print(f"working-set changes: {summary['changes']}")

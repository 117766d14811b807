"""Describe a platform, and see what its reach costs: the same step on two of them."""

from otolith import metrics
from otolith.cueing.design import Design, implicit
from otolith.plant import Ideal
from otolith.platforms import load, parse_platform
from otolith.scenarios import scenario
from otolith.simulate import simulate

HOME_RIG = """
name = "home-rig"
description = "a small surge-pitch rig"

[surge]
position_m = [-0.12, 0.20]
velocity_mps = 0.5
acceleration_mps2 = 4.0

[pitch]
angle_deg = 12.0
rate_degps = 20.0

[tilt_coordination]
pitch_degps = 3.0
"""

for platform in (load("davsi"), parse_platform(HOME_RIG, "home-rig.toml")):
    design = Design(platform=platform)
    run = simulate(implicit(design), Ideal(), scenario("step-1"), platform=platform, dofs=("surge-pitch",))
    summary = metrics.summarise(run)
    print(f"{platform.name}: RMSE {summary['rmse']:.3f} m/s², {summary['violations']} limit violations")

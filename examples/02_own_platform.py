"""Describe a platform, and see what its reach costs: the same step on two of them."""

import otolith

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

for platform in (otolith.platform("davsi"), otolith.parse_platform(HOME_RIG, "home-rig.toml")):
    wanted, design = otolith.Wanted(scenario="step-1"), otolith.Design(platform=platform)
    run = otolith.Experiment(wanted=wanted, cueing="implicit", design=design).run()
    summary = otolith.summarise(run)
    print(f"{platform.name}: RMSE {summary['rmse']:.3f} m/s², {summary['violations']} limit violations")

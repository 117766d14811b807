"""Minutes of adversarial references and random faults, in seconds."""

from otolith.core.frames import SURGE_PITCH, SWAY_ROLL
from otolith.cueing.design import Design
from otolith.cueing.washout.tuning import load_tuning
from otolith.interfaces import Cueing
from otolith.live.endurance import Adversary, endurance
from otolith.platforms import Platform, parse_platform
from otolith.platforms.template import template
from otolith.registry import make_cueing


def test_nothing_happens_that_must_not(washout: Cueing, machine: Platform) -> None:
    account = endurance(washout, machine, 60.0, seed=1, tick=4e-3)
    assert account.clean, account
    assert account.engagements >= 3
    assert account.cued_seconds > 10.0
    assert account.refused_plans > 0  # the references are hostile enough to need the gate
    assert sum(account.faults.values()) > 8


def test_nothing_happens_that_must_not_on_cranks() -> None:
    """The gate and a judge with another form of the angles; the platform rests where its cranks reach."""
    rig = parse_platform(template("cranks"), "cranks.toml")
    design = Design(platform=rig, dofs=(SURGE_PITCH, SWAY_ROLL), washout=load_tuning("davsi"))
    account = endurance(make_cueing("classical", design), rig, 20.0, seed=3, tick=4e-3)
    assert account.clean, account
    assert account.engagements >= 1
    assert account.cued_seconds > 4.0


def test_the_adversary_is_a_function_of_time() -> None:
    drive = Adversary(5)
    assert (drive(12.345) == drive(12.345)).all()
    assert max(abs(drive(0.01 * k)[:3]).max() for k in range(3000)) > 8.0

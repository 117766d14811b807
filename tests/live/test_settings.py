"""Session files: what they may say, and the sentence for what they may not."""

import pytest

from otolith.core.errors import InputError
from otolith.live.settings import Settings, narrowed, settings_from_toml
from otolith.platforms import Platform

SESSION = """
platform = "davsi-4dof"
cueing = "classical"
tuning = "davsi"
scale = 0.8

[input]
source = "generic"
listen = "127.0.0.1:9100"

[device]
kind = "moog"
address = "127.0.0.1:9910"
interface = "CDS7237"
neutral_heave_m = -0.2
on_silence = "parks"

[limits]
circle_m = 0.12
tilt_pitch_degps = 2.5
[limits.surge]
position_m = [-0.1, 0.12]
velocity_mps = 0.2
[limits.pitch]
angle_deg = 5

[presets.gentle]
scale = 0.4
[presets.gentle.limits.surge]
acceleration_mps2 = 2.0
"""


def settings(text: str = SESSION) -> Settings:
    return settings_from_toml(text, "s.toml")


def test_a_session_file_narrows_the_platform_and_nothing_else(machine: Platform) -> None:
    found = narrowed(machine, settings().limits, "s.toml")
    assert found.surge is not None
    assert machine.surge is not None
    assert found.surge == machine.surge.model_copy(update={"position_m": (-0.1, 0.12), "velocity_mps": 0.2})
    assert found.pitch is not None
    assert found.pitch.angle_deg == (-5.0, 5.0)
    assert found.circle == 0.12
    assert found.tilt_coordination.pitch_degps == 2.5
    for same in ("sway", "roll", "hexapod", "braking", "actuators", "name"):
        assert getattr(found, same) == getattr(machine, same)


def test_a_preset_changes_what_it_says() -> None:
    gentle = settings().under("gentle")
    assert gentle.scale == 0.4
    assert gentle.limits.surge.acceleration_mps2 == 2.0
    assert gentle.cueing == "classical"
    assert settings().under(None) == settings()
    with pytest.raises(InputError, match=r"preset is 'gentel', must be one of gentle \(did you mean gentle"):
        settings().under("gentel")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("angle_deg = 5", "angle_deg = 0.1", r"limits.pitch.angle_deg in s.toml is 0.1, .*deg.*in rad\?"),
        ("[-0.1, 0.12]", "[0.12, -0.1]", r"limits.surge.position_m in s.toml .*low < 0 < high, in m"),
        ("tilt_pitch_degps = 2.5", "tilt_pitch_degps = 12", r"between 0.5 and 10 deg/s"),
        ("scale = 0.8", "scale = 1.5", r"scale in s.toml is 1.5, must be greater than 0 and at most 1"),
        ('interface = "CDS7237"\n', "", r"device.interface in s.toml is missing, must be CDS7237 or CDS7330"),
        ("parks", "floats", r"device.on_silence in s.toml is 'floats', must be one of 'holds', 'parks'"),
        ("127.0.0.1:9100", "9100", r"input.listen in s.toml is '9100', must be a host and a port"),
        ("velocity_mps", "velocty_mps", r"limits.surge.velocty_mps in s.toml is unknown, .*velocity_mps"),
        ("acceleration_mps2 = 2.0", "a = 2", r"presets.gentle.limits.surge.a in s.toml is unknown"),
        ("scale = 0.4", "scal = 0.4", r"presets.gentle.scal in s.toml is unknown, .*mean scale"),
    ],
)
def test_what_is_wrong_is_refused_by_field_value_bound_and_unit(old: str, new: str, words: str) -> None:
    assert old in SESSION
    with pytest.raises(InputError, match=words) as refused:
        settings(SESSION.replace(old, new))
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "velocity_mps = 0.2",
            "velocity_mps = 0.3",
            r"is 0.3 m/s, must be at most 0.267 m/s, as the platform",
        ),
        ("[-0.1, 0.12]", "[-0.1, 0.2]", r"is -0.1 to 0.2 m, must be within -0.165 to 0.165 m"),
        ("circle_m = 0.12", "circle_m = 0.2", r"limits.circle_m in s.toml is 0.2 m, must be at most 0.165 m"),
        ("tilt_pitch_degps = 2.5", "tilt_pitch_degps = 3.5", r"is 3.5 deg/s, must be at most 3 deg/s"),
        ("limits.pitch]\nangle_deg", "limits.yaw]\nangle_deg", r"davsi-4dof has no yaw"),
        (
            "limits.pitch]\nangle_deg",
            "limits.pitch]\nposition_m",
            r"limits.pitch.position_m .* left out: pitch",
        ),
    ],
)
def test_limits_wider_than_the_platforms_are_refused(
    old: str, new: str, words: str, machine: Platform
) -> None:
    assert old in SESSION
    with pytest.raises(InputError, match=words):
        narrowed(machine, settings(SESSION.replace(old, new)).limits, "s.toml")

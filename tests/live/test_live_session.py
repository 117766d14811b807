"""Sessions: what they read, that they come back from a log as they were, and what they refuse."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from otolith import files
from otolith.cli.live_run import Choices
from otolith.core.errors import CorruptFile, InputError
from otolith.core.frames import SURGE_PITCH
from otolith.cueing.mpc.explicit_problem import ExplicitSettings, explicit_problem
from otolith.live.devices.driver import Request
from otolith.live.devices.emulator import Envelope
from otolith.live.devices.moog import COMMAND_PACKETS, WORDS
from otolith.live.session import Session, session_from_record
from otolith.live.settings import settings_from_toml
from otolith.live.shell.virtual import base_at
from otolith.live.wire.axes import AxisMap, axes_from_toml, with_axes
from otolith.mpqp import enumerate_regions
from otolith.platforms import catalog, load
from tests.live.devices.test_template import at
from tests.live.test_settings import SESSION

FORZA = "forza+udp://127.0.0.1:5300"
AXES = AxisMap(source="generic", force=("2", "-1", "3"), evidence={"circle": 0.99})


@pytest.fixture
def path(tmp_path: Path) -> Path:
    made = tmp_path / "s.toml"
    made.write_text(SESSION + AXES.to_toml())
    return made


def test_a_session_comes_back_from_its_record_as_it_was(path: Path) -> None:
    session = Choices(file=path).session()
    assert session.axes == AXES
    assert session.park == (0.0, 0.0, -0.2, 0.0, 0.0, 0.0)
    assert session.driver.name == "moog CDS7237"
    assert session.platform.circle == 0.12
    record = json.loads(json.dumps(session.to_record()))
    again = session_from_record(record, "s.otl")
    assert again == session
    with pytest.raises(CorruptFile, match=r"s\.otl states no session of this version"):
        session_from_record({**record, "platform": 3}, "s.otl")


def test_the_command_line_goes_before_the_file(path: Path) -> None:
    session = Choices(
        file=path, outgoing="generic+udp://127.0.0.1:9", cueing="adaptive", preset="gentle"
    ).session()
    assert (session.settings.device.kind, session.settings.cueing) == ("generic", "adaptive")
    assert session.settings.scale == 0.4


@pytest.mark.parametrize("name", ["six-axis-nmpc", "joint"])
def test_an_algorithm_that_is_too_slow_or_moves_a_base_is_refused(path: Path, name: str) -> None:
    with pytest.raises(
        InputError, match=f"cueing in s.toml is {name}, must be one of predictive, .*: it dec"
    ):
        Choices(file=path, cueing=name).session()


def moog(platform: str, reach: str = "public") -> Session:
    """A session with a Moog base that has 0.2 m of travel below our neutral pose."""
    device = {**base_at(9910), "reach": reach}
    choices = Choices(incoming=FORZA, platform=platform, device=device, dofs="surge-pitch")
    return choices.session()


@pytest.mark.parametrize("name", sorted(set(catalog()) - {"thesis"}))
def test_a_session_begins_only_where_the_base_takes_all_poses_that_may_be_sent(name: str) -> None:
    """The emulator, which would end it in the middle of a drive, has bounds of its own."""
    session, words = moog(name, "platform"), []
    for axis in range(6):
        for end in (session.sent.low, session.sent.high):
            pose = np.where(np.arange(6) == axis, end, 0.0)
            packet = session.driver.encode(at(pose), Request.MOVE)
            values = COMMAND_PACKETS["CDS7237"].decode(packet)
            words.append([values[word][0] for word in WORDS])
    small, own = Envelope(), Envelope.holding(session.platform, -0.2)
    assert np.all((own.low <= words) & (words <= own.high))
    if np.all((small.low <= words) & (words <= small.high)):
        assert moog(name).platform.name == name
    else:
        with pytest.raises(InputError, match=r"of moog CDS7237 is .*, must be at least .*, where the pl"):
            moog(name)


@pytest.mark.parametrize(
    ("limits", "words"),
    [
        ("surge", "surge of moog CDS7237 is -0.241 to 0.259 m, must be at least -0.5 to 0.5 m, where the"),
        ("heave", "heave of moog CDS7237 is -0.2 to 0.2572 m, must be at least -0.42 to 0.42 m, where the"),
        (
            "yaw",
            "yaw of moog CDS7237 is -22 to 22 deg, must be at least -25 to 25 deg, where the platform may",
        ),
        ("", ""),
    ],
)
def test_the_axis_that_the_base_lacks_is_named_and_narrower_limits_are_enough(
    tmp_path: Path, limits: str, words: str
) -> None:
    narrow = {
        "surge": "[limits.surge]\nposition_m = 0.24\n[limits.sway]\nposition_m = 0.24\n",
        "heave": "[limits.heave]\nposition_m = [-0.2, 0.25]\n",
        "yaw": "[limits.yaw]\nangle_deg = 22\n",
        "": "[limits.pitch]\nangle_deg = 21\n[limits.roll]\nangle_deg = 21\n",
    }
    path = tmp_path / "s.toml"
    path.write_text("".join(text for axis, text in narrow.items() if axis != limits or axis == ""))
    choices = Choices(
        file=path,
        platform="davsi",
        incoming=FORZA,
        outgoing="moog+udp://127.0.0.1:9910",
    )
    if words:
        with pytest.raises(InputError, match=words):
            choices.session()
    else:
        assert choices.session().sent.high[2] == 0.25


@pytest.mark.parametrize("after", ["", "\n[limits.sway]\nvelocity_mps = 0.1  # slow\n"])
def test_an_axis_map_is_written_into_a_session_file_and_nothing_else_changes(after: str) -> None:
    text = SESSION + "# learned today\n" + AXES.to_toml() + after
    new = replace(AXES, force=("1", "2", "3"))
    made = with_axes(text, "s.toml", new)
    assert axes_from_toml(made, "s.toml") == new
    assert settings_from_toml(made, "s.toml") == settings_from_toml(text, "s.toml")
    assert SESSION in made
    assert after.strip() in made
    assert with_axes(made, "s.toml", AXES).count("[axes]") == 1
    assert with_axes("", "s.toml", AXES) == AXES.to_toml()
    assert axes_from_toml(with_axes(SESSION, "s.toml", AXES), "s.toml") == AXES


def test_an_axis_map_that_is_no_section_is_left_alone() -> None:
    with pytest.raises(InputError, match=r"s\.toml"):
        with_axes('axes = { source = "x" }\nplatform = "davsi"\n', "s.toml", AXES)


def test_files_that_a_session_read_and_that_change_are_named(path: Path, tmp_path: Path) -> None:
    """Row 20: what runs is what was read at the start."""
    mine = tmp_path / "mine.toml"
    mine.write_text((Path(files.__file__).parent / "platforms/catalog/davsi-4dof.toml").read_text())
    session = Choices(file=path, platform=str(mine)).session()
    assert session.changed() == []
    mine.write_text(mine.read_text() + "\n")
    path.unlink()
    said = session.changed()
    assert len(said) == 2
    assert any("session" in one and "no longer there" in one for one in said)
    assert any(one.startswith("SHA-256 of platform") for one in said)


def test_laws_of_another_model_and_damaged_ones_are_refused(path: Path, tmp_path: Path) -> None:
    """Row 21: SHA-256, version and model of a table, before anything is opened."""
    text = path.read_text().replace('"classical"', '"explicit"').replace('tuning = "davsi"\n', "")
    laws = tmp_path / "laws.h5"
    path.write_text(text.replace("scale = 0.8", f'scale = 0.8\nlaws = "{laws}"\ndofs = "surge-pitch"'))
    with pytest.raises(InputError, match=r"laws\.h5 is not readable"):
        Choices(file=path).session()
    settings = ExplicitSettings(horizon=2)
    other = load("davsi")
    problem = explicit_problem(SURGE_PITCH, other.limits(SURGE_PITCH), other.braking, settings)
    files.write_laws((enumerate_regions(problem),), laws)
    with pytest.raises(InputError, match=r"the stored law's model is .* of platform davsi-4dof as chosen"):
        Choices(file=path).session()
    damaged = bytearray(laws.read_bytes())
    damaged[-100] ^= 1
    laws.write_bytes(damaged)
    with pytest.raises(CorruptFile, match="does not match its SHA-256"):
        Choices(file=path).session()


def test_an_algorithm_of_ones_own_is_part_of_what_was_read(path: Path, tmp_path: Path) -> None:
    code = tmp_path / "mine.py"
    code.write_text("class Still:\n    period = 0.01\n")
    session = Choices(file=path, cueing=f"{code}:Still").session()
    assert session.changed() == []
    code.write_text("class Still:\n    period = 0.02\n")
    (said,) = session.changed()
    assert said.startswith("SHA-256 of cueing")

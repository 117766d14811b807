"""A rig that is set up in the page, against the real server."""

import time

import pytest

from otolith.commander.machine import form
from otolith.platforms import parse_platform
from tests.commander.client import Page
from tests.commander.conftest import Commander
from tests.commander.test_server import finished

SMALL = {"surge_position_m_low": 0.1, "surge_position_m_high": 0.2, "surge_velocity_mps": 0.5}


def machine(**values: float | str | None) -> dict[str, object]:
    return {"kind": "axes", "values": form("axes")["values"] | values}


def test_a_platform_of_ones_own_is_made_listed_changed_run_and_deleted(
    page: Page, commander: Commander
) -> None:
    shown = page.ask("/api/platforms").json
    assert set(shown["kinds"]) == {"axes", "legs"}
    saved = page.ask("/api/platforms/small.toml", machine(**SMALL, description="a sled"), method="PUT")
    assert saved.status == 200, saved.body
    assert "surge: -0.100 to 0.200 m (the file)" in saved.json["sentences"]
    file = commander.setup.folder / "platforms" / "small.toml"
    platform = parse_platform(file.read_text(), "small.toml")
    assert platform.surge is not None
    assert platform.surge.velocity_mps == 0.5
    start = page.ask("/api/start").json
    assert {"name": "small.toml", "text": "a sled"} in start["choices"]["platforms"]
    assert "small.toml" in start["schema"]["properties"]["platform"]["enum"]
    values = page.ask("/api/platforms/small.toml").json
    assert (values["kind"], values["values"]["surge_position_m_high"]) == ("axes", 0.2)

    chosen = {"platform": "small.toml", "scenario": "step:amplitude=0.3,duration=61", "speed": 0.0}
    checked = page.ask("/api/check", chosen).json
    assert f"--platform {file}" in checked["command"] or "platforms/small.toml" in checked["command"]
    done = finished(page, page.run(**chosen))
    assert done["summary"]["platform"] == "my-rig"

    assert page.ask("/api/platforms/small.toml", method="DELETE").status == 204
    assert page.ask("/api/platforms/small.toml", method="DELETE").status == 404
    assert page.ask("/api/platforms/small.toml").status == 404
    assert page.ask("/api/check", chosen).status == 422


def test_a_wrong_number_is_said_beside_its_field_and_nothing_is_written(
    page: Page, commander: Commander
) -> None:
    wrong = machine(surge_velocity_mps=400.0)
    answer = page.ask("/api/platforms/fast.toml/check", wrong).json
    assert answer["field"] == "surge_velocity_mps"
    assert answer["sentence"] == (
        "surge.velocity_mps in fast.toml is 400.0, must be between 0.005 and 20 m/s (is it in mm/s?)"
    )
    saved = page.ask("/api/platforms/fast.toml", wrong, method="PUT")
    assert (saved.status, saved.json) == (422, answer)
    assert page.ask("/api/platforms/fast.toml/check", machine()).json == {"field": "", "sentence": ""}
    assert not (commander.setup.folder / "platforms" / "fast.toml").exists()


@pytest.mark.parametrize(
    "name", ["x.txt", "..toml", "%2e%2e%2fx.toml", "..%5cx.toml", "x" * 65 + ".toml", "davsi"]
)
def test_platform_files_have_plain_names(page: Page, commander: Commander, name: str) -> None:
    before = sorted(commander.setup.folder.rglob("*"))
    for method, path in (("PUT", ""), ("POST", "/check"), ("DELETE", ""), ("GET", "")):
        given = None if method in ("GET", "DELETE") else machine()
        answer = page.ask(f"/api/platforms/{name}{path}", given, method=method)
        assert answer.status in (404, 405, 422), answer.body
        time.sleep(0.06)
    assert sorted(commander.setup.folder.rglob("*")) == before
    refused = page.ask("/api/check", {"platform": f"../{name}"})
    assert (refused.status, refused.json["field"]) == (422, "platform")


def test_a_file_that_is_damaged_is_said_in_the_list(page: Page, commander: Commander) -> None:
    file = commander.setup.folder / "platforms" / "torn.toml"
    file.write_text('name = "x"\nsurge = 3\n')
    try:
        (found,) = (one for one in page.ask("/api/platforms").json["own"] if one["name"] == "torn.toml")
        assert "surge in torn.toml is 3, must be a table of fields" in found["text"]
        assert page.ask("/api/platforms/torn.toml").status == 422
    finally:
        file.unlink()

"""A rig from nothing, in the page alone: its platform, its game, and a machine in software that is moved."""

import socket
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import pytest
from playwright.sync_api import Browser, Page, expect

from otolith.commander.machine import form, text_of
from otolith.live.settings import settings_from_toml
from otolith.live.wire.axes import axes_from_toml
from tests.commander.web.conftest import Server, Watched, free_port
from tests.commander.web.test_page import soon
from tests.commander.web.test_tour import COMMAND
from tests.live.shell.rig import Rig as Machine
from tests.live.wire.golden import WRC_JSON
from tests.live.wire.minute import DT, SHORT, driven, forza_packet

SLOW: Final = 60_000  # [ms]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "own"


@pytest.fixture
def real(browser: Browser, folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Server]:
    """`otolith commander`, with an empty folder and no tests kept."""
    monkeypatch.delenv("LOCALAPPDATA", raising=False)
    monkeypatch.setenv("XDG_STATE_HOME", str(folder.parent / "state"))
    port = free_port()
    command = [sys.executable, "-c", COMMAND, "commander", "--port", str(port), "--folder", str(folder)]
    server = Server(command, port, folder.parent / "log.txt")
    server.wait()
    yield server
    server.end()


def open_(page: Page, title: str) -> None:
    """Open a step of the rig, and close the others."""
    for step in page.locator("#rig > details").all():
        if (step.get_attribute("open") is not None) != (title in step.locator("h2").first.inner_text()):
            step.locator("summary").first.click()


def fill(page: Page, name: str, value: str) -> None:
    """Write a value, and wait for what the server thinks of it."""
    field = page.locator(f"#field-{name}")
    field.scroll_into_view_if_needed()
    if field.evaluate("one => one.tagName") == "SELECT":
        field.select_option(value)
    else:
        field.fill(value)
        field.press("Tab")


def drive(port: int) -> threading.Thread:
    """Drive the experiment, as Forza would send it."""
    drive = driven(SHORT)

    def send() -> None:
        begin = time.monotonic()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
            for k in range(len(drive.t)):
                line.sendto(forza_packet(k, drive), ("127.0.0.1", port))
                time.sleep(max(0.0, begin + (k + 1) * DT - time.monotonic()))

    thread = threading.Thread(target=send, daemon=True)
    thread.start()
    return thread


def platform_file(page: Page) -> None:
    """Make a platform file; a wrong number is refused in the sentence of the command line."""
    fill(page, "machine-surge_velocity_mps", "400")
    expect(page.locator("#machine-verdict")).to_contain_text("(is it in mm/s?)")
    expect(page.locator("#error-machine-surge_velocity_mps")).to_contain_text("is 400.0, must be between")
    fill(page, "machine-surge_velocity_mps", "0.2")
    expect(page.locator("#machine-verdict")).to_contain_text("in order")


def described_by_a_file(page: Page, folder: Path) -> None:
    """A game whose packets a file describes: what is missing is said, and the file is opened in the page."""
    fill(page, "rig-source", "wrc")
    expect(page.locator("#error-rig-channels")).to_contain_text("must be the game's JSON file")
    (folder / "udp.json").write_text(WRC_JSON)
    page.set_input_files("#channels-file", folder / "udp.json")
    expect(page.locator("#field-rig-channels")).to_have_value("udp.json")
    expect(page.locator("#rig-verdict")).to_contain_text("kept")
    assert (folder / "channels" / "udp.json").read_text() == WRC_JSON


def test_a_rig_from_nothing(browser: Browser, real: Server, folder: Path) -> None:
    (folder / "platforms" / "two.toml").write_text(text_of(form("axes")["values"], "axes", "two.toml"))
    context = browser.new_context(viewport={"width": 1280, "height": 720})
    watched = Watched(context, f"{real.url}/")
    page = watched.open()
    page.click("#tab-rig")
    expect(page.locator("#machine-verdict")).to_contain_text("in order")
    page.select_option("#machine-kind", "legs")
    page.locator("#rig summary:has-text('surge')").click()
    platform_file(page)
    page.click("#rig button:has-text('Save')")
    expect(page.locator("#machine")).to_have_value("my-rig.toml", timeout=SLOW)
    expect(page.locator("#rig .reach")).to_contain_text("every combination", timeout=SLOW)
    expect(page.locator("#field-platform")).to_have_value("my-rig.toml")

    open_(page, "Telemetry")
    described_by_a_file(page, folder)
    port = free_port()
    fill(page, "rig-source", "forza")
    expect(page.locator("#field-rig-channels")).to_be_hidden()
    expect(page.locator("#field-rig-listen")).to_have_value("127.0.0.1:5300")
    fill(page, "rig-listen", f"127.0.0.1:{port}")
    expect(page.locator("#rig-learn")).to_be_enabled()
    page.click("#rig-learn")
    expect(page.locator("#wizard")).to_contain_text("nothing has arrived yet")
    thread = drive(port)
    expect(page.locator("#wizard .passed")).to_have_count(5, timeout=SLOW)
    expect(page.locator("#wizard .reach")).to_contain_text("forward = channel", timeout=SLOW)
    thread.join()
    page.fill("#map-name", "my-game")
    page.click("text=Save the axis map")
    expect(page.locator("#field-rig-map")).to_have_value("my-game.toml")
    expect(page.locator("#wizard")).to_be_hidden()
    expect(page.locator("#rig-verdict")).to_contain_text("kept")

    soon(lambda: "[axes]" in (folder / "rig.toml").read_text(), "the axis map is not in the session file")
    kept = (folder / "rig.toml").read_text()
    assert settings_from_toml(kept, "rig.toml").platform == str(folder / "platforms" / "my-rig.toml")
    axes = axes_from_toml(kept, "rig.toml")
    assert (axes.source, axes.force) == ("forza", ("1", "2", "3"))  # its parser has turned them already
    with Machine() as machine:
        every_axis(page, machine)
    open_(page, "First ride")
    lacks = page.locator("#rig .lacks")
    expect(lacks).to_contain_text("this host has not been tested")
    expect(lacks.locator("li.bad")).to_have_count(1)
    lacks.locator("button", has_text="This computer").click()
    page.click("#rig-check")
    expect(page.locator("#trial")).to_contain_text("Testing this computer", timeout=SLOW)
    page.click("#stop")
    expect(page.locator("#trial")).to_be_hidden(timeout=SLOW)
    expect(page.locator("#events")).to_contain_text("stopped")
    watched.check()
    context.close()


def every_axis(page: Page, machine: Machine) -> None:
    """Move both axes of a platform in software, and stop once in between by Escape."""
    open_(page, "Platform and device")
    fill(page, "rig-platform", "two.toml")
    fill(page, "rig-dofs", "surge-pitch")
    fill(page, "rig-address", f"127.0.0.1:{machine.device}")
    open_(page, "Every axis")
    for stopped in (True, False):
        expect(page.locator("#rig-axis")).to_be_enabled()
        page.click("#rig-axis")
        for name in ("surge", "pitch"):
            expect(page.locator("#trial .now")).to_contain_text(name, timeout=SLOW)
            expect(page.locator("#trial-move")).to_be_visible(timeout=SLOW)
            page.click("#trial-move")
            expect(page.locator("#state")).to_contain_text("axis test")
            if stopped:
                soon(lambda: bool(machine.farthest[0] > 3e-3), "the platform does not move")
                page.keyboard.press("Escape")
                break
            expect(page.locator("#trial-yes")).to_be_visible(timeout=SLOW)
            page.click("#trial-yes")
        expect(page.locator("#trial")).to_be_hidden(timeout=SLOW)
        machine.is_at_home()
        expect(page.locator("#rig .note", has_text="stopped" if stopped else "may arm")).to_be_visible()
    assert machine.farthest[0] == pytest.approx(10e-3, rel=0.05)
    assert machine.base.faults == 0

"""The tour of a live session in the page, with a Moog base in software: arm, engage, change, STOP, park."""

from playwright.sync_api import Browser, expect

from otolith.live.messages import State
from otolith.live.shell.supervise import Live
from tests.commander import client
from tests.commander.web.conftest import Watched
from tests.commander.web.test_page import INK, soon
from tests.commander.web.test_tour import shown
from tests.live.shell.rig import Rig


def test_a_live_session_is_armed_engaged_changed_stopped_and_parked_in_the_page(
    browser: Browser, live_session: tuple[Live, Rig, client.Page, list[str]]
) -> None:
    live, rig, at, told = live_session
    context = browser.new_context(viewport={"width": 1280, "height": 720})
    watched = Watched(context, f"http://127.0.0.1:{at.port}/")
    watched.page.goto(f"{watched.url}?token={at.cookies['otolith-token']}", wait_until="domcontentloaded")
    page = watched.page
    page.click("#word-arm")
    expect(page.locator("#state")).to_contain_text("ready", timeout=60_000)
    page.click("#word-engage")
    expect(page.locator("#state")).to_contain_text("engaged")
    rig.moves()
    lamps = page.locator("#lamps")
    expect(lamps).to_contain_text("here")
    soon(lambda: page.evaluate(INK, [0.0, 9.0]) > 100, "nothing is drawn")
    surge = page.locator("#pose td").first
    reach = float(rig.farthest[0])
    soon(lambda: 1e-3 < abs(shown(surge.inner_text())) <= 2.0 * reach + 0.05, "the pose is not the base's")

    page.click("#tab-tune")
    page.fill("#field-scale", "0.5")
    page.keyboard.press("Tab")
    expect(page.locator("#events .parameter")).to_contain_text("scale")
    soon(lambda: live.look() is State.ENGAGED, "a change ended the ride")

    page.keyboard.press("Escape")
    expect(page.locator("#events")).to_contain_text("returning: stop")
    expect(page.locator("#state")).to_contain_text("ready", timeout=30_000)
    assert "returning: stop" in told
    page.click("#tab-setup")
    page.click("#word-park")
    expect(page.locator("#events")).to_contain_text("parked", timeout=30_000)
    rig.is_at_home()
    assert rig.base.faults == 0
    watched.check()
    context.close()

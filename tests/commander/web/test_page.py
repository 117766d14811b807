"""What the page owes to whoever looks at it, when samples are missing, late or refused."""

import math
import time
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.commander.web.conftest import Server, Watched

INK = """([first, last]) => {  // blue pixels of the first plot between two times [s]; its axis ends at 20 s
  const chart = document.querySelector(".panel canvas"), box = chart.getBoundingClientRect();
  const over = document.querySelector(".panel .u-over").getBoundingClientRect();
  const scale = chart.width / box.width;
  const x = scale * (over.left - box.left + over.width * first / 20), y = scale * (over.top - box.top);
  const wide = scale * over.width * (last - first) / 20, tall = scale * over.height;
  const {data} = chart.getContext("2d").getImageData(x, y, wide, tall);
  let blue = 0;
  for (let k = 0; k < data.length; k += 4) if (data[k + 2] > data[k] + 60 && data[k + 3] > 60) blue += 1;
  return blue;
}"""


LEGS = """() => {  // coloured pixels of the last plot in its first 3 s
  const chart = [...document.querySelectorAll(".panel canvas")].at(-1), box = chart.getBoundingClientRect();
  const over = [...document.querySelectorAll(".panel .u-over")].at(-1).getBoundingClientRect();
  const scale = chart.width / box.width, wide = scale * over.width * 3 / 20, tall = scale * over.height;
  const x = scale * (over.left - box.left), y = scale * (over.top - box.top);
  const {data} = chart.getContext("2d").getImageData(x, y, wide, tall);
  let coloured = 0;
  for (let k = 0; k < data.length; k += 4) {
    const [red, green, blue] = data.slice(k, k + 3);
    if (data[k + 3] > 60 && Math.max(red, green, blue) - Math.min(red, green, blue) > 60) coloured += 1;
  }
  return coloured;
}"""
ORANGE = INK.replace("data[k + 2] > data[k] + 60", "data[k] > data[k + 2] + 60")  # marks of changes


def soon(condition: Callable[[], bool], what: str) -> None:
    """Wait up to a minute for a condition: a busy machine draws late."""
    until = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < until, what
        time.sleep(0.05)


def begin(watched: Watched, fake: Server, at: float = 0.0) -> Page:
    """Open the page, and begin a run that has already reached a time."""
    page = watched.open()
    page.click("#run")
    expect(page.locator("#state")).to_contain_text("running")
    if at:
        fake.fault(time=at)
    page.wait_for_selector(".panel")
    return page


def test_a_gap_in_the_samples_is_a_gap_in_the_picture(watched: Watched, fake: Server) -> None:
    page = begin(watched, fake, at=8.0)
    soon(lambda: page.evaluate(INK, [5.2, 7.8]) > 100, "no curve was drawn")
    assert page.evaluate(INK, [1.2, 3.8]) > 100
    assert page.evaluate(INK, [4.1, 4.9]) == 0


def test_numbers_are_those_of_the_samples(watched: Watched, fake: Server) -> None:
    page = begin(watched, fake, at=6.0)
    page.click("#pause")
    expect(page.locator("#state")).to_contain_text("paused")
    reached = fake.fault()["time"]
    soon(lambda: float(page.inner_text("#clock")) > 6.0, "the clock stands")
    time.sleep(0.5)
    surge = page.locator("#pose td").first.inner_text()
    shown = float(surge.removesuffix(" m").replace("−", "-"))
    assert shown == pytest.approx(0.2 * math.sin(reached), abs=0.2 * 0.01 + 0.0006)  # a bucket, and rounding


def test_the_page_asks_only_for_what_is_on_screen(watched: Watched, fake: Server) -> None:
    page = begin(watched, fake, at=6.0)
    shown = ["time", "wanted_x", "felt_x", "pose_x", "pose_pitch", "tilt_rate_pitch"]
    shown += ["step_us", "changes", "residual"]
    soon(lambda: fake.fault()["asked"][-1:] == [shown], "other signals were asked for")
    legs = page.locator("#legs td").nth(1).inner_text()
    assert legs.endswith(" m")  # made of the pose
    page.select_option("#add", "Legs")
    soon(lambda: set(fake.fault()["asked"][-1]) == {*shown, *(f"leg_{k}" for k in range(1, 7))}, "no legs")
    panel = page.locator(".panel", has_text="Legs")
    expect(panel.locator("output").first).not_to_have_text("–")
    soon(lambda: page.evaluate(LEGS) > 500, "the past of a plot that was added is missing")
    panel.locator("button").click()
    soon(lambda: fake.fault()["asked"][-1] == shown, "signals of a closed plot still come")


def test_old_samples_are_never_shown_as_if_they_were_new(watched: Watched, fake: Server) -> None:
    page = begin(watched, fake)
    expect(page.locator("#veil")).to_be_hidden()
    fake.fault(silent=True)
    expect(page.locator("#veil")).to_contain_text("No data for")
    assert page.locator("#lamps [data-level=off]").count() == page.locator("#lamps li").count()
    fake.fault(silent=False)
    expect(page.locator("#veil")).to_be_hidden()


def test_lamps_say_in_words_and_shapes_what_a_session_counts(watched: Watched, fake: Server) -> None:
    fake.fault(reset=True, mode="live")
    page = watched.page
    page.goto(watched.url, wait_until="domcontentloaded")
    fake.fault(begin=True)
    told = {"telemetry_age_s": 0.012, "clock": 0.2, "gate_refused": 4, "refused_lately": 0, "missed": 20}
    fake.fault(lamps={**told, "missed_lately": 11, "log": "the log: cannot be written: No space left"})

    def lamp(name: str) -> str:
        return page.locator("#lamps li", has_text=name).locator("span").inner_text()

    soon(lambda: lamp("misses") == "■ 20", "misses")
    assert [lamp(name) for name in ("input", "clock", "gate")] == ["● 12 ms", "▲ 200 ms", "● 4 refused"]
    assert [lamp(name) for name in ("log", "control")] == ["■ trouble", "● here"]
    assert "No space left" in str(page.locator("#lamps li", has_text="log").get_attribute("title"))
    nothing = dict.fromkeys((*told, "missed_lately", "log"))
    fake.fault(lamps=nothing)
    soon(lambda: lamp("misses") == "○ –", "a lamp stays lit without a value")
    assert [lamp(name) for name in ("input", "clock", "gate", "log")] == ["○ –", "○ –", "○ –", "○ none"]


def test_a_live_session_has_its_own_parameters_and_a_line_where_one_changed(
    watched: Watched, fake: Server
) -> None:
    fake.fault(reset=True, mode="live")
    page = watched.page
    page.goto(watched.url, wait_until="domcontentloaded")
    fake.fault(begin=True)
    fake.fault(time=3.0)
    page.wait_for_selector(".panel")
    page.click("#tab-tune")
    assert page.locator("#tune .field").count() == 2
    assert page.locator("#preset").count() == 0
    assert page.get_attribute("#field-scale", "max") == "1"
    page.fill("#field-scale", "0.5")
    page.keyboard.press("Enter")
    soon(lambda: fake.fault()["changes"] == [{"scale": 0.5}], "the change was not sent once")
    expect(page.locator("#events .parameter")).to_contain_text("scale 0.5")
    soon(lambda: page.evaluate(ORANGE, [3.0, 10.0]) > 20, "no line was drawn")
    assert page.evaluate(ORANGE, [0.5, 2.9]) == 0
    fake.fault(parameters={"scale": 0.7, "liveliness": 0.5})  # somebody else's
    expect(page.locator("#field-scale")).to_have_value("0.7")
    expect(page.locator("#tune .note")).to_contain_text("gradually")


def test_the_page_comes_back_by_itself_and_keeps_what_it_has(watched: Watched, fake: Server) -> None:
    page = begin(watched, fake, at=3.0)
    fake.fault(close=True)
    expect(page.locator("#veil")).to_contain_text("No connection")
    soon(lambda: fake.fault()["clients"] == 1, "it did not come back")
    expect(page.locator("#veil")).to_be_hidden()
    expect(page.locator("#state")).to_contain_text("running")
    soon(lambda: page.evaluate(INK, [0.2, 2.5]) > 100, "what was drawn is gone")


def test_a_hidden_page_answers_without_drawing(watched: Watched, fake: Server) -> None:
    page = begin(watched, fake)
    page.evaluate("""() => {
      Object.defineProperty(document, "hidden", {get: () => true, configurable: true});
      document.dispatchEvent(new Event("visibilitychange"));
    }""")
    time.sleep(0.1)
    clock, answered = page.inner_text("#clock"), fake.fault()["acknowledged"]
    time.sleep(0.5)
    assert page.inner_text("#clock") == clock
    assert fake.fault()["acknowledged"] > answered + 3
    page.evaluate("""() => {
      delete document.hidden;
      document.dispatchEvent(new Event("visibilitychange"));
    }""")
    expect(page.locator("#clock")).not_to_have_text(clock)


@pytest.mark.parametrize("way", ["click", "escape", "space"])
def test_stop_arrives_by_both_ways(watched: Watched, fake: Server, way: str) -> None:
    page = begin(watched, fake)
    if way == "click":
        page.click("#stop")
    elif way == "escape":
        page.focus("#field-scenario")  # even while somebody types
        page.keyboard.press("Escape")
    else:
        page.focus("#hold")
        page.keyboard.down(" ")
        time.sleep(0.2)
        assert fake.fault()["words"] == []  # a short press is a press of the button
        time.sleep(0.6)
        page.keyboard.up(" ")
    soon(lambda: fake.fault()["words"] == ["stop", "stop"], "STOP came by one way only")
    expect(page.locator("#state")).to_contain_text("stopped")


def test_stop_is_repeated_until_it_has_arrived(watched: Watched, fake: Server) -> None:
    page = begin(watched, fake)
    fake.fault(deaf=True)
    page.keyboard.press("Escape")
    expect(page.locator("#events .fault")).to_contain_text("STOP has not arrived")
    fake.fault(deaf=False)
    expect(page.locator("#state")).to_contain_text("stopped")
    watched.complaints.clear()  # the browser notes each answer of 503


def test_a_slider_acts_when_it_is_let_go(watched: Watched, fake: Server) -> None:
    page = begin(watched, fake)
    page.click("#tab-tune")
    slider = page.locator(".field:has(#field-liveliness) input[type=range]")
    slider.scroll_into_view_if_needed()
    box: Any = slider.bounding_box()
    middle = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + box["width"] / 2, middle)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.9 * box["width"], middle, steps=5)
    time.sleep(0.2)
    assert fake.fault()["changes"] == []
    page.mouse.up()
    soon(lambda: len(fake.fault()["changes"]) == 1, "the change was not sent once")
    assert fake.fault()["changes"][0]["liveliness"] == pytest.approx(0.9, abs=0.05)
    expect(page.locator("#events .parameter")).to_contain_text("liveliness")
    expect(page.locator(".field.changed")).to_contain_text("Liveliness")


def test_a_refusal_is_one_sentence_beside_its_field(watched: Watched, fake: Server) -> None:
    page = watched.open()
    page.fill("#field-scenario", "nothing")
    page.keyboard.press("Tab")
    expect(page.locator(".verdict")).to_contain_text("no scenario is called nothing")
    expect(page.locator("#run")).to_be_disabled()
    page.select_option("#scenarios", "stop")
    expect(page.locator("#run")).to_be_enabled()


def test_in_a_live_session_only_possible_words_can_be_said(watched: Watched, fake: Server) -> None:
    fake.fault(reset=True, mode="live")
    page = watched.page
    page.goto(watched.url, wait_until="domcontentloaded")
    expect(page.locator("#word-arm")).to_be_enabled()
    assert [page.locator(f"#word-{word}").is_enabled() for word in ("engage", "return", "park", "rearm")] == [
        False
    ] * 4
    assert page.locator("#run").count() == 0
    expect(page.locator("#setup .bad")).to_have_count(2)
    expect(page.locator("#setup .checks")).to_contain_text("axes are not tested; end this session")
    expect(page.locator("#setup .checks")).to_contain_text("nothing arrives")
    page.click("#word-arm")
    soon(lambda: fake.fault()["words"] == ["arm"], "the word did not arrive")

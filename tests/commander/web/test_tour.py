"""The tour of the Commander with the real server and real runs: choose, run, tune, compare, stop, export."""

import csv
import io
import json
import sys
import urllib.request
from collections.abc import Iterator
from typing import Any, Final

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.commander.web.conftest import Server, Watched, free_port
from tests.commander.web.test_page import INK, soon

COMMAND: Final = "import sys; from otolith.cli import main; main(sys.argv[1:])"
COMPILED: Final = 180_000  # [ms] for what the first run of a machine compiles


@pytest.fixture(scope="module")
def real(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """`otolith commander`, with an empty folder."""
    port, folder = free_port(), tmp_path_factory.mktemp("commander")
    command = [
        sys.executable,
        "-c",
        COMMAND,
        "commander",
        "--port",
        str(port),
        "--folder",
        str(folder / "own"),
    ]
    server = Server(command, port, folder / "log.txt")
    server.wait()
    yield server
    server.end()


def answer(server: Server, path: str) -> bytes:
    with urllib.request.urlopen(server.url + path) as response:
        content: bytes = response.read()
    return content


def choose(page: Page, **values: str) -> None:
    """Fill the start chain; each choice is checked by the server before the next."""
    for name, value in values.items():
        field = page.locator(f"#field-{name}")
        if field.evaluate("one => one.tagName") == "SELECT":
            field.select_option(value)
        else:
            field.fill(value)
            field.press("Tab")
    expect(page.locator(".verdict")).to_contain_text("passed")


def shown(text: str) -> float:
    return float(text.replace("−", "-").replace("★", "").split()[0])


def test_the_tour(browser: Browser, real: Server) -> None:
    context = browser.new_context(viewport={"width": 1280, "height": 720})
    watched = Watched(context, f"{real.url}/")
    page = watched.open()

    choose(page, platform="thesis", cueing="classical", second="optimal")
    choose(page, scenario="step:amplitude=1.0,start=0.2,end=1.5,duration=3.0")
    page.click("#run")
    expect(page.locator("#state")).to_contain_text("running", timeout=COMPILED)
    page.wait_for_selector(".panel")
    page.click("#tab-tune")
    page.fill("#field-scale", "0.5")
    page.keyboard.press("Tab")
    expect(page.locator("#events .parameter")).to_contain_text("scale")

    expect(page.locator("#state")).to_contain_text("done", timeout=COMPILED)
    expect(page.locator("#measures table")).to_be_visible()
    assert page.evaluate(INK, [0.3, 2.9]) > 100  # something was drawn
    result = json.loads(answer(real, "/api/result"))
    cells = page.locator("#measures tbody tr").first.locator("td").all_inner_texts()
    errors = [result["summary"]["rmse"], result["second"]["rmse"]]
    assert [shown(cell) for cell in cells] == pytest.approx(errors, abs=6e-4)
    assert "★" in cells[errors.index(min(errors))]

    rows = samples(real, page)
    assert float(rows[-1]["time_s"]) == pytest.approx(3.0, abs=0.011)
    surge = page.locator("#pose td").first
    soon(
        lambda: abs(shown(surge.inner_text()) - float(rows[-1]["surge_m"])) < 2e-3,
        "the pose is not the recorded one",
    )

    stop_by_escape(page)
    watched.check()
    context.close()


def samples(real: Server, page: Page) -> list[dict[str, Any]]:
    """Export the samples by the page's own link, and return their rows."""
    with page.expect_download() as download:
        page.click("text=Samples (CSV)")
    text = download.value.path().read_text(encoding="utf-8")
    return list(csv.DictReader(io.StringIO(text)))


def stop_by_escape(page: Page) -> None:
    """Run again, and stop early: what was run until then is kept."""
    page.click("#tab-setup")
    choose(page, second="", scenario="step-sine-1")
    page.click("#run")
    expect(page.locator("#state")).to_contain_text("running", timeout=COMPILED)
    soon(lambda: float(page.inner_text("#clock")) > 0.3, "the clock stands")
    page.keyboard.press("Escape")
    expect(page.locator("#state")).to_contain_text("stopped", timeout=COMPILED)
    assert float(page.inner_text("#clock")) < 15.0
    expect(page.locator("#events")).to_contain_text("stopped by hand")

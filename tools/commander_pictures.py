"""Take the pictures of docs/commander.md: the tour, with a real server, real runs and the system's chromium.

    python tools/commander_pictures.py [FOLDER [rig]]

FOLDER is docs/images by default; with `rig`, only those of a rig from nothing are taken. It takes a few
minutes where nothing is compiled yet.
"""

import os
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from playwright.sync_api import Page, Playwright, sync_playwright

from otolith.live.shell.virtual import surroundings
from otolith.platforms import load

ROOT: Final = Path(__file__).parents[1]
LONG: Final = 300_000  # [ms] for whatever has to be compiled first
START: Final = "import sys; from otolith.cli import main; main(sys.argv[1:])"


@contextmanager
def commander(folder: Path) -> Iterator[str]:
    """Serve on a free port, with the usual folder below `folder`; the value is the address."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    server = subprocess.Popen(
        [sys.executable, "-c", START, "commander", "--port", str(port)],
        cwd=folder,
        env={**os.environ, "XDG_STATE_HOME": str(folder / "state")},  # no test of this machine's own is shown
    )
    address = f"http://127.0.0.1:{port}/"
    try:
        for _ in range(600):
            try:
                urllib.request.urlopen(f"{address}health").close()  # noqa: S310 (our own address)
                break
            except OSError:
                time.sleep(0.1)
        yield address
    finally:
        server.terminate()
        server.wait()


def wait_for(page: Page, state: str) -> None:
    """Wait until the state is a word."""
    page.wait_for_selector(f"#state[data-word={state}]", timeout=LONG)


def checked(page: Page) -> None:
    """Wait until the server has checked the form."""
    page.wait_for_timeout(1_000)
    page.wait_for_selector("#run:enabled", timeout=LONG)


def compare_on_a_log(page: Page, drive: Path, take: Path) -> None:
    """The tour: predictive against classical on a drive of one's own, calmer, then the result."""
    page.set_input_files("#file", drive)
    page.wait_for_function("() => document.querySelector('#field-log').value === 'drive.csv'")
    page.select_option("#field-platform", "davsi")
    page.select_option("#field-second", "classical")
    checked(page)
    page.screenshot(path=take / "commander-set-up.png")
    page.click("#run")
    wait_for(page, "running")
    page.wait_for_timeout(11_000)
    page.click("#tab-tune")
    page.fill("#field-liveliness", "0.2")
    page.keyboard.press("Tab")
    page.wait_for_timeout(5_000)
    page.screenshot(path=take / "commander-tune.png")
    page.emulate_media(color_scheme="dark")
    page.set_viewport_size({"width": 1024, "height": 768})
    page.wait_for_timeout(1_000)
    page.screenshot(path=take / "commander-dark.png")
    page.emulate_media(color_scheme="light")
    page.set_viewport_size({"width": 1280, "height": 720})
    wait_for(page, "done")
    page.wait_for_selector("#measures table", timeout=LONG)
    page.wait_for_timeout(500)
    page.screenshot(path=take / "commander-result.png")


def rig_from_nothing(page: Page, take: Path) -> None:
    """A rig's steps: platform, axes of a game, what is lacking before a ride, every axis alone."""
    page.click("#tab-rig")
    page.wait_for_selector("#rig-verdict:not(:empty)")
    page.select_option("#machine-kind", "legs")
    page.locator("#rig summary", has_text="surge").click()
    write(page, "machine-surge_velocity_mps", "200")
    page.screenshot(path=take / "commander-rig-machine.png")
    write(page, "machine-surge_velocity_mps", "0.2")
    page.click("#rig button:has-text('Save')")
    page.wait_for_selector("#rig .reach li", timeout=LONG)
    with surroundings(load("davsi-4dof")) as (telemetry, base):
        step(page, "3 Telemetry")
        write(page, "rig-listen", f"127.0.0.1:{telemetry}")
        page.click("#rig-learn")
        page.wait_for_selector("#wizard:visible")
        page.wait_for_timeout(34_000)
        page.screenshot(path=take / "commander-rig-learn.png")
        page.click("#wizard button:has-text('Cancel')")
        step(page, "2 Platform and device")
        page.select_option("#field-rig-platform", "davsi-4dof")
        write(page, "rig-address", f"127.0.0.1:{base}")
        step(page, "6 First ride")
        page.wait_for_timeout(1_000)
        page.screenshot(path=take / "commander-rig-lacks.png")
        step(page, "5 Every axis alone")
        page.click("#rig-axis:enabled")
        page.click("#trial-move:visible", timeout=LONG)
        page.click("#trial-yes:visible", timeout=LONG)
        page.wait_for_selector("#trial-move:visible", timeout=LONG)
        page.emulate_media(color_scheme="dark")
        page.set_viewport_size({"width": 1024, "height": 768})
        page.wait_for_timeout(500)
        page.screenshot(path=take / "commander-rig-axis.png")
        page.keyboard.press("Escape")
        page.wait_for_selector("#trial", state="hidden", timeout=LONG)


def step(page: Page, title: str) -> None:
    """Open one step of the rig, and close the others."""
    page.locator("#rig > details > summary", has_text=title).evaluate(
        """(summary) => {
          const steps = [...document.querySelectorAll("#rig > details")], chosen = summary.parentElement;
          for (const one of steps) one.open = one === chosen;
          chosen.scrollIntoView();
        }"""
    )
    page.wait_for_timeout(500)


def write(page: Page, name: str, value: str) -> None:
    """Write into a field, and wait for what the server thinks of it."""
    page.fill(f"#field-{name}", value)
    page.keyboard.press("Tab")
    page.wait_for_timeout(700)


def all_runs(page: Page, address: str, take: Path) -> None:
    """The page of all runs, with two of them compared."""
    page.goto(f"{address}web/runs.html", wait_until="domcontentloaded")
    for k in (0, 1):
        page.locator("#runs tbody input").nth(k).check()
    page.locator("#runs th button", has_text="RMS").click()
    page.wait_for_timeout(500)
    page.screenshot(path=take / "commander-runs.png")


def live(playwright: Playwright, chromium: str, folder: Path, take: Path) -> None:
    """A live session with a base in software, whose scale is changed while it is cued."""
    words = ["live", "demo", "--seconds", "30", "--cueing", "classical", "--tuning", "davsi"]
    command = [sys.executable, "-c", START, *words, "--log", str(folder / "logs"), "--commander", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as session:
        assert session.stdout is not None  # noqa: S101 (it is a pipe)
        address = next(line.split()[-1] for line in session.stdout if "token=" in line)
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        page.goto(address, wait_until="domcontentloaded")
        wait_for(page, "engaged")
        page.wait_for_timeout(6_000)
        page.click("#tab-tune")
        page.fill("#field-scale", "0.4")
        page.keyboard.press("Tab")
        page.wait_for_timeout(9_000)
        page.screenshot(path=take / "commander-live.png")
        browser.close()
        for _ in session.stdout:  # until it has parked
            pass


def main() -> None:
    """Take all pictures."""
    take = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "images"
    chromium = shutil.which("chromium")
    if chromium is None:
        sys.exit("there is no chromium here")
    with tempfile.TemporaryDirectory() as name, sync_playwright() as playwright:
        folder = Path(name)
        example = [sys.executable, "-c", START, "example", "--out", str(folder / "example")]
        subprocess.run(example, check=True)
        with commander(folder) as address:
            browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
            page = browser.new_page(viewport={"width": 1280, "height": 720})
            page.goto(address, wait_until="domcontentloaded")
            checked(page)
            if "rig" not in sys.argv[2:]:
                compare_on_a_log(page, folder / "example" / "drive.csv", take)
                all_runs(browser.new_page(viewport={"width": 1280, "height": 720}), address, take)
            rig_from_nothing(page, take)
            browser.close()
        if "rig" not in sys.argv[2:]:
            live(playwright, chromium, folder, take)


if __name__ == "__main__":
    main()

"""Whoever sees little, or has no mouse, can use the page."""

import re
from pathlib import Path
from typing import Final

import pytest
from playwright.sync_api import expect

from tests.commander.web.conftest import Server, Watched
from tests.commander.web.fake_server import WEB

STYLE: Final = (WEB / "style.css").read_text(encoding="utf-8")
TEXTS: Final = ("--ink", "--soft", "--accent", "--good", "--warn", "--fault")
CURVES: Final = tuple(f"--s{k}" for k in range(6))
LEAST: Final = 4.5  # WCAG 2.1, 1.4.3: contrast of text
LEAST_OF_CURVES: Final = 3.0  # 1.4.11: contrast of graphics


def colours(look: str) -> dict[str, str]:
    """Return the variables of the light or dark look."""
    light, dark = re.findall(r":root \{(.*?)\}", STYLE, flags=re.DOTALL)[:2]
    found = dict(re.findall(r"(--[\w-]+): (#[0-9a-f]{6})", light))
    return found | (dict(re.findall(r"(--[\w-]+): (#[0-9a-f]{6})", dark)) if look == "dark" else {})


def luminance(colour: str) -> float:
    """Return the relative luminance of sRGB (WCAG 2.1)."""
    parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one: str, other: str) -> float:
    low, high = sorted([luminance(one), luminance(other)])
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("look", ["light", "dark"])
def test_texts_and_curves_stand_out(look: str) -> None:
    of = colours(look)
    for paper in ("--paper", "--panel"):
        for text in TEXTS:
            assert contrast(of[text], of[paper]) >= LEAST, f"{text} on {paper}"
        for curve in CURVES:
            assert contrast(of[curve], of[paper]) >= LEAST_OF_CURVES, f"{curve} on {paper}"
    assert contrast("#ffffff", of["--stop"]) >= LEAST
    assert contrast(of["--on-accent"], of["--accent"]) >= LEAST


def test_contrast_is_that_of_the_standard() -> None:
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.478, abs=0.001)


def test_the_tab_key_reaches_everything(watched: Watched, fake: Server) -> None:
    page = watched.open()
    kinds = "button, input, select, summary, [tabindex='0']"
    wanted = page.evaluate(
        """(kinds) => [...document.querySelectorAll(kinds)]
        .filter((one) => one.checkVisibility() && !one.disabled && one.tabIndex >= 0).length""",
        kinds,
    )
    page.evaluate("() => document.activeElement.blur()")
    reached = set()
    for _ in range(wanted + 5):
        page.keyboard.press("Tab")
        reached.add(
            page.evaluate("""() => {
          const one = document.activeElement, style = getComputedStyle(one);
          if (one === document.body) return "";
          return `${[...document.querySelectorAll("*")].indexOf(one)} ${style.outlineStyle}`;
        }""")
        )
    reached.discard("")
    assert len(reached) >= wanted
    assert all(one.endswith("solid") for one in reached)  # the focus can be seen


def test_tabs_follow_the_arrow_keys(watched: Watched, fake: Server) -> None:
    page = watched.open()
    page.focus("#tab-setup")
    page.keyboard.press("ArrowRight")
    expect(page.locator("#tune")).to_be_visible()
    expect(page.locator("#setup")).to_be_hidden()
    assert page.evaluate("() => document.activeElement.id") == "tab-tune"


@pytest.mark.parametrize("size", [(1280, 720), (1024, 768)])
def test_nothing_is_cut_off(watched: Watched, fake: Server, size: tuple[int, int]) -> None:
    watched.page.set_viewport_size({"width": size[0], "height": size[1]})
    page = watched.open()
    page.click("#run")
    page.wait_for_selector(".panel")
    outside = page.evaluate("""() => [...document.querySelectorAll("header *, .tools *, .tabs *, #stop")]
        .filter((one) => one.checkVisibility() && one.getBoundingClientRect().right > innerWidth + 1)
        .map((one) => one.id || one.className)""")
    assert outside == []
    assert page.evaluate("() => document.documentElement.scrollWidth <= innerWidth")


def test_every_module_is_short() -> None:
    own = [path for path in WEB.glob("*.js") if not path.name.startswith("uplot")]
    assert own
    for path in own:
        assert len(Path(path).read_text(encoding="utf-8").splitlines()) <= 200, path.name

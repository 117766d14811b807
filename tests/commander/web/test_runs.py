"""The page of all runs: sorted, two compared, and STOP within reach."""

from playwright.sync_api import expect

from tests.commander.web.conftest import Server, Watched
from tests.commander.web.test_page import soon


def test_runs_are_sorted_and_two_are_compared(watched: Watched, fake: Server) -> None:
    page = watched.page
    page.goto(f"{watched.url}web/runs.html", wait_until="domcontentloaded")
    expect(page.locator("#runs tbody tr")).to_have_count(3)
    expect(page.locator("#events .warn")).to_contain_text("c: its summary.json is none of a run")

    def order() -> list[str]:
        return [row.split("\t")[4] for row in page.locator("#runs tbody tr").all_inner_texts()]

    assert order() == ["classical", "optimal", "predictive"]  # the newest first
    head = page.locator("#runs th", has_text="error of felt force")
    head.locator("button").click()
    assert order() == ["predictive", "classical", "optimal"]
    assert head.get_attribute("aria-sort") == "ascending"
    head.locator("button").click()
    assert order() == ["optimal", "classical", "predictive"]
    boxes = page.locator("#runs tbody input")
    for k in range(3):  # the third takes the place of the first
        boxes.nth(k).check()
    assert [boxes.nth(k).is_checked() for k in range(3)] == [False, True, True]
    compared = page.locator("#compared tbody tr").first.inner_text().split("\t")
    assert compared == ["error of felt force, RMS [m/s²]", "0.500", "★ 0.300"]
    fake.fault(begin=True)
    expect(page.locator("#state")).to_contain_text("running")
    page.keyboard.press("Escape")
    soon(lambda: fake.fault()["words"] == ["stop", "stop"], "STOP came by one way only")
    expect(page.locator("#state")).to_contain_text("stopped")
    soon(lambda: fake.fault()["asked"][-1:] == [["time"]], "signals were asked for that nobody sees")

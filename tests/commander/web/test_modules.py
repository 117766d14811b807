"""The page's modules by themselves, against the same numbers in Python."""

from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Page

from otolith.platforms import Platform, load, parse_platform
from otolith.platforms.template import template
from tests.commander.web.conftest import Server, Watched

CRANKS = parse_platform(template("cranks"), "cranks.toml")


@pytest.fixture
def page(watched: Watched, fake: Server) -> Page:
    return watched.open()


def test_a_minute_is_kept_and_a_jump_is_marked(page: Page) -> None:
    kept = page.evaluate("""async () => {
      const {History} = await import("/web/history.js");
      const history = new History([{name: "time"}, {name: "x"}]), rows = 100;
      for (let t = 0; t < 200; t += 1) {  // 200 s at 100 Hz, without the 150th
        if (t === 150) continue;
        const time = Float32Array.from({length: rows}, (_, k) => t + k / rows);
        history.append([time, time.map((one) => 2 * one)]);
      }
      const time = [...history.view(0)], x = [...history.view(1)];
      const known = x.map((one) => Number.isNaN(one) ? null : one);
      return {time, x: known, at: time[history.at(160.005)], early: history.at(0)};
    }""")
    time, x = np.array(kept["time"]), np.array(kept["x"], dtype=float)
    assert time[0] == pytest.approx(199.99 - 60.0, abs=0.011)
    assert time[-1] == pytest.approx(199.99, abs=1e-3)
    gaps = np.isnan(x)
    assert gaps.sum() == 1
    assert time[gaps] == pytest.approx([151.0])
    np.testing.assert_allclose(x[~gaps], 2 * time[~gaps], rtol=1e-6)
    assert kept["at"] == pytest.approx(160.0)
    assert kept["early"] == -1


def test_what_was_not_asked_for_is_filled_from_the_past_but_no_gap_is(page: Page) -> None:
    """x comes only in the second half; then the past comes again in buckets of 40 ms."""
    kept: Any = page.evaluate("""async () => {
      const {History} = await import("/web/history.js");
      const history = new History([{name: "time"}, {name: "pose_x"}, {name: "x"}]);
      const pairs = (from, to, wide) => {
        const length = 2 * Math.round((to - from) / wide);
        return Float32Array.from({length}, (_, k) => from + wide * Math.floor(k / 2));
      };
      const x = (time, off) => time.map((t, k) => 3 * t + (k % 2 ? off : -off));
      for (let t = 0; t < 10; t += 1) {
        const time = pairs(t, t + 1, 0.01), one = time.map(() => 1);
        const surge = t === 4 ? time.map(() => NaN) : one;
        history.append(history.newer([time, surge, t < 5 ? null : x(time, 0.015)]));
      }
      const past = pairs(0.02, 11, 0.04), all = x(past, 0.06);
      const gap = past.map((t, k) => t > 4.02 && t < 4.98 ? NaN : all[k]);
      const rest = history.newer([past, past.map(() => 1), gap]);
      const plain = (k) => [...history.view(k)].map((one) => Number.isNaN(one) ? null : one);
      return {time: plain(0), x: plain(2), rest: [rest[0][0], rest[2].length]};
    }""")
    time, x = np.array(kept["time"]), np.array(kept["x"], dtype=float)
    hole = (time >= 4.0) & (time < 4.995)
    assert np.isnan(x[hole]).all()
    np.testing.assert_allclose(x[~hole], 3 * time[~hole], atol=3 * 0.025 + 0.061)
    early = (time < 3.9) & (np.arange(len(x)) % 2 == 1)
    assert (x[early] >= 3 * time[early] - 1e-4).all()  # the second of a pair is the largest
    assert kept["rest"][0] > 9.99
    assert kept["rest"][1] == pytest.approx(2 * 25, abs=2)


@pytest.mark.parametrize("platform", [load("davsi"), CRANKS], ids=["legs", "cranks"])
def test_legs_are_as_long_as_the_kinematics_say(page: Page, platform: Platform) -> None:
    """Or cranks at their angles [deg], as the stream has them."""
    hexapod = platform.six_legs()
    size = 0.3 if hexapod.cranks is None else 0.05
    poses = np.random.default_rng(2).uniform(-size, size, size=(20, 6))
    shown = poses.copy()
    shown[:, 3:] = np.degrees(shown[:, 3:])
    legs = {
        "base": hexapod.anchors.tolist(),
        "platform": hexapod.joints.tolist(),
        "stroke": list(hexapod.drives.span),
        "cranks": None if hexapod.cranks is None else hexapod.cranks.plain(),
    }
    drawn: Any = page.evaluate(
        """async ([legs, poses]) => {
          const {HexapodView} = await import("/web/hexapod.js");
          const view = new HexapodView(document.createElement("canvas"));
          view.describe(legs);
          return poses.map((pose) => { view.draw(pose); return view.lengths(); });
        }""",
        [legs, shown.tolist()],
    )
    expected = hexapod.drives.size * hexapod.lengths(poses)
    np.testing.assert_allclose(drawn, expected, atol=1e-10)


def test_the_car_on_the_map_is_where_it_was_at_that_time(page: Page) -> None:
    """The middle of the coloured dot, against linear interpolation; the path is 1 px per m."""
    times = [0.0, 1.0, 2.0, 4.0]
    x, y = [0.0, 500.0, 552.0, 552.0], [0.0, 0.0, 104.0, 312.0]
    asked = [-1.0, 0.0, 0.25, 1.5, 3.0, 4.0, 9.0]
    found: Any = page.evaluate(
        """async ([path, asked]) => {
          const {LapMap} = await import("/web/map.js");
          const canvas = Object.assign(document.createElement("canvas"), {width: 600, height: 360});
          const map = new LapMap(canvas);
          map.describe(path);
          return asked.map((time) => {
            map.draw(time);
            const {data} = canvas.getContext("2d").getImageData(0, 0, 600, 360);
            let [n, px, py] = [0, 0, 0];
            for (let k = 0; k < data.length; k += 4) {
              if (data[k + 3] < 200 || data[k] < data[k + 2] + 80) continue;
              n += 1, px += k / 4 % 600, py += Math.floor(k / 2400);
            }
            return [px / n, py / n];
          });
        }""",
        [{"x": x, "y": y, "time": times}, asked],
    )
    expected = [(24.0 + np.interp(t, times, x), 336.0 - np.interp(t, times, y)) for t in asked]
    np.testing.assert_allclose(found, expected, atol=1.0)


def test_the_error_so_far_is_the_root_of_the_mean_square(page: Page) -> None:
    wanted, felt = np.random.default_rng(3).normal(size=(2, 500)).astype(np.float32)
    felt[100:120] = np.nan
    text = page.evaluate(
        """async ([wanted, felt]) => {
          const {SoFar} = await import("/web/sofar.js"), table = document.createElement("table");
          table.createTBody();
          const part = new SoFar(table), name = (text) => ({name: text});
          part.describe(["time", "wanted_x", "felt_x"].map(name));
          const row = (values) => Float32Array.from(values, (one) => one ?? NaN);
          part.take([row(wanted), row(wanted), row(felt)], false);
          part.draw();
          return table.textContent;
        }""",
        [wanted.tolist(), [None if np.isnan(one) else float(one) for one in felt]],
    )
    rms = np.sqrt(np.nanmean((wanted - felt) ** 2))
    assert text == f"forward{rms:.3f} m/s²"


def test_time_begins_at_zero_and_then_follows(page: Page) -> None:
    ranges = page.evaluate("""async () => {
      const {Plots} = await import("/web/plots.js");
      const plots = new Plots(document.createElement("div"));
      return [0, 5, 20, 50].map((last) => { plots.history = {last}; return plots.range(); });
    }""")
    assert ranges == [[0, 20], [0, 20], [0, 20], [30, 50]]


def test_the_page_is_light(watched: Watched, fake: Server) -> None:
    page = watched.open()
    weight = page.evaluate("""() => [
      performance.getEntriesByType("navigation")[0], ...performance.getEntriesByType("resource"),
    ].reduce((sum, one) => sum + one.transferSize, 0)""")
    assert 50_000 < weight <= 120_000  # [bytes] on the wire, packed

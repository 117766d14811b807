"""Diagrams as plotly.js reads them, and the library that pages carry."""

import base64
import hashlib
import json
from importlib.resources import files

import numpy as np
import pytest

from otolith.report.panels import Axis, Curve, Panel
from otolith.report.plots import plot_json

BUNDLE = files("otolith.report") / "assets" / "plotly"
VERSION = "4.1.1"
SHA256 = "99784e3abfb07b142a15e521a439e6d9addceadb3f79553fd24c72774f0649ba"


def panel(n: int) -> Panel:
    x = np.linspace(0.0, 1.0, n)
    y = np.sin(40.0 * x)
    y[n // 3] = 7.5  # a peak of one sample
    return Panel(
        key="force",
        title="</script>",
        axes=(Axis(label="<b>", span=(-1.0, 8.0)),),
        curves=(Curve(label="</script>", x=x, y=y, color="#000000"),),
    )


def test_the_library_is_the_published_one_with_its_licence() -> None:
    script = (BUNDLE / "plotly-basic.min.js").read_bytes()
    assert hashlib.sha256(script).hexdigest() == SHA256
    assert f"plotly.js (basic - minified) v{VERSION}" in script[:200].decode()
    assert "MIT" in (BUNDLE / "LICENSE").read_text(encoding="utf-8")
    assert VERSION in (BUNDLE / "README.md").read_text(encoding="utf-8")
    assert b"</script" not in script  # it stands inside a script element


@pytest.mark.parametrize(("points", "most"), [(5000, 5000), (800, 800)])
def test_a_curve_keeps_its_peak_in_so_many_points(points: int, most: int) -> None:
    text = plot_json(panel(20_000), points=points)
    assert "</" not in text
    (curve,) = json.loads(text)["data"]
    x, y = (np.frombuffer(base64.b64decode(curve[axis]["bdata"]), dtype="<f4") for axis in "xy")
    assert len(x) == len(y) <= most
    assert y.max() == np.float32(7.5)
    assert (np.diff(x) > 0.0).all()

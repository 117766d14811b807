"""The page of a study says what was found, and escapes what users write."""

import numpy as np

from otolith.report.study import Best, Found, render_study


def test_the_page_shows_front_presets_and_commands() -> None:
    best = [
        Best(number=3, values=(0.1, 0.9), judged=(0.2, 0.8), settings={"weight.position": "0.5"}),
        Best(number=7, values=(0.4, 0.2), judged=None, settings={"weight.position": "0.7"}),
    ]
    found = Found(
        name="a < b",
        description="<script>",
        objectives={"tracking": "error", "travel": "share"},
        tried=np.array([[0.1, 0.9], [0.4, 0.2], [0.5, 0.95]]),
        best=tuple(best),
        presets={"calm": 7},
        commands={"calm": "otolith study export s --preset calm --out calm.toml"},
        said="3 of 3 trials done",
    )
    text = render_study(found)
    for words in ("a &lt; b", "&lt;script&gt;", "calm: trial 7", "--preset calm", "0.9000", "0.8000", "0.7"):
        assert words in text
    assert "travel against tracking" in text
    nothing = render_study(
        Found(
            **{
                **{f: getattr(found, f) for f in Found.__dataclass_fields__},
                "best": (),
                "presets": {},
                "commands": {},
                "tried": np.zeros((0, 2)),
            }
        )
    )
    assert "3 of 3 trials done" in nothing

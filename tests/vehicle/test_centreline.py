import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core.errors import InputError
from otolith.vehicle import Road, parse_centreline, parse_gpx, road

HEADER = "# x_m,y_m,w_tr_right_m,w_tr_left_m"


def text(*columns: np.ndarray, header: str = HEADER) -> str:
    rows = (",".join(f"{value:.6f}" for value in row) for row in zip(*columns, strict=True))
    return "\n".join([header, *rows]) + "\n"


def ring(points: int = 126, radius: float = 100.0) -> tuple[np.ndarray, np.ndarray]:
    angle = np.linspace(0.0, 2.0 * np.pi, points)[:-1]
    return radius * np.cos(angle), radius * np.sin(angle)


def test_a_noisy_circle_has_the_circles_curvature() -> None:
    x, y = ring()
    rng = np.random.default_rng(3)
    noise = rng.normal(0.0, 0.05, (2, len(x)))
    wide = np.full(len(x), 6.0)
    path = parse_centreline(text(x + noise[0], y + noise[1], wide, wide - 2.0), "ring.csv")
    assert path.closed
    assert path.length == pytest.approx(2.0 * np.pi * 100.0, rel=1e-3)
    assert_allclose(path.curvature, 0.01, atol=1.5e-3)
    assert np.sqrt(np.mean((path.curvature - 0.01) ** 2)) < 3e-4
    assert_allclose(path.width, np.broadcast_to([6.0, 4.0], path.width.shape))


def test_a_spline_through_exact_points_of_a_circle_converges() -> None:
    errors = []
    for points in (11, 21, 81):
        path = parse_centreline(text(*ring(points), header="x_m,y_m"), "ring.csv", smoothing=0.0)
        errors.append(np.abs(path.curvature - 0.01).max())
    assert errors[1] < errors[0] / 10.0
    assert errors[2] < 1e-6  # as good as six decimals in the file allow


def test_hockenheim_goes_to_a_file_and_back() -> None:
    """Written as points five metres apart, as public databases are, the circuit keeps its shape."""
    lap = road("hockenheim")
    points = lap.position[::20]
    again = parse_centreline(text(*points.T, header="x_m;y_m").replace(",", ";"), "lap.csv")
    assert again.closed
    assert again.length == pytest.approx(lap.length, abs=2.0)
    assert again.heading[-1] - again.heading[0] == pytest.approx(-2.0 * np.pi, abs=1e-3)
    share = np.linspace(0.0, 1.0, 4000)
    before = lap.place(share * lap.length, np.zeros(4000))
    after = again.place(share * again.length, np.zeros(4000))
    assert np.linalg.norm(before - after, axis=1).max() < 0.6


def oval(points: int = 120) -> np.ndarray:
    """(points, 2) along an ellipse of 150 m and 60 m: 690.4 m around, radii of 24 m and 375 m."""
    angle = np.linspace(0.0, 2.0 * np.pi, points + 1)[:-1]
    return np.stack([150.0 * np.cos(angle), 60.0 * np.sin(angle)], axis=1)


def is_the_oval(path: Road, *, rel: float = 2e-3) -> bool:
    """Closed, as long as the ellipse, and as far from its middle, wherever it lies."""
    around = path.position - 0.5 * (path.position.min(axis=0) + path.position.max(axis=0))
    off = np.abs(np.hypot(around[:, 0] / 150.0, around[:, 1] / 60.0) - 1.0).max()
    return path.closed and abs(path.length / 690.4 - 1.0) < rel and bool(off < 5.0 * rel)


FAULTS = {
    "repeated": (np.insert(oval(), 41, oval()[40], axis=0), 2e-3, "1 repeated point left out"),
    "grid": (oval() + np.array([691_000.0, 5_334_000.0]), 2e-3, "x and y are 691000 m and 5334000 m less"),
    "overlap": (
        np.vstack([oval(), oval()[:10] + np.array([0.8, 0.5])]),
        3e-3,
        "one lap is kept, the 33 m",
    ),
    "no fix": (np.insert(oval(), 40, 0.0, axis=0), 2e-3, "1 stray point left out, the first in line 42"),
    "jump": (oval() + np.c_[np.zeros(120), 40.0 * (np.arange(120) == 50)], 2e-3, "1 stray point left out"),
    "noisy": (oval() + np.random.default_rng(0).normal(0, 1, (120, 2)), 8e-3, "points scatter by 1.3 m"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_faulty_file_of_an_oval_is_the_oval_and_its_note_says_so(fault: str) -> None:
    points, rel, note = FAULTS[fault]
    path = parse_centreline(text(*points.T, header="x_m,y_m"), "oval.csv")
    assert is_the_oval(path, rel=rel)
    assert note in path.notes[0]
    assert np.abs(path.curvature).max() == pytest.approx(1.0 / 24.0, rel=0.12)


def test_degrees_and_a_total_width_make_the_same_oval() -> None:
    x, y = oval().T
    lat, lon = 48.1 + y / 111_192.0, 11.6 + x / 74_490.0
    path = parse_centreline(text(lat, lon, 0 * x + 8.0, header="lat,lon,width_m"), "oval.csv", smoothing=0.0)
    assert is_the_oval(path)
    assert_allclose(path.width, 4.0)
    points = "".join(f'<trkpt lat="{a:.8f}" lon="{b:.8f}"/>' for a, b in zip(lat, lon, strict=True))
    again = parse_gpx(f"<gpx><trk><trkseg>{points}</trkseg></trk></gpx>", "my.oval.gpx")
    assert is_the_oval(again)
    assert again.name == "my.oval"


def test_ends_are_as_the_user_says() -> None:
    most = text(*oval()[:-2].T, header="x_m,y_m")
    assert parse_centreline(most, "t.csv").closed
    assert not parse_centreline(most, "t.csv", closed=False).closed
    short = text(*oval()[:-12].T, header="x_m,y_m")
    assert not parse_centreline(short, "t.csv").closed
    assert parse_centreline(short, "t.csv", closed=True).length == pytest.approx(690.0, abs=5.0)
    twice = text(*np.vstack([oval(), oval() + 0.2]).T, header="x_m,y_m")
    assert parse_centreline(twice, "t.csv", closed=False).length == pytest.approx(2 * 690.4, abs=8.0)


def test_elevation_that_scatters_is_smoothed_and_said() -> None:
    """A receiver's metre of noise would be felt as 2 m/s² at 30 m/s; the hill beneath it stays."""
    rng = np.random.default_rng(2)
    x = np.arange(0.0, 2000.0, 8.0)
    hill = 10.0 * np.sin(2.0 * np.pi * x / 1000.0)
    path = parse_centreline(text(x, 0.0 * x, hill + rng.normal(0.0, 1.0, 250), header="x_m,y_m,ele"), "t.csv")
    assert "the elevation scatters by" in path.notes[-1]
    inner = slice(400, -400)
    assert_allclose(path.elevation[inner], 10.0 * np.sin(2.0 * np.pi * path.way / 1000.0)[inner], atol=1.0)
    assert np.abs(path.crest[inner]).max() * 30.0**2 < 0.8


def test_elevation_and_banking_are_taken_over_and_smoothed() -> None:
    x = np.arange(0.0, 1000.0, 10.0)
    z, bank = 2.0 * np.sin(2.0 * np.pi * x / 500.0), np.full(len(x), 3.0)
    path = parse_centreline(text(x, 0.0 * x, z, bank, header="x_m,y_m,z_m,banking_deg"), "hill.csv")
    assert not path.closed
    assert_allclose(path.banking, np.radians(3.0), atol=1e-12)
    inner = slice(100, -100)
    assert_allclose(path.elevation[inner], 2.0 * np.sin(2.0 * np.pi * path.way / 500.0)[inner], atol=0.06)


TURN = np.linspace(-np.pi / 2, np.pi / 2, 9)
HAIRPIN = np.vstack(
    [
        np.c_[np.linspace(0.0, 99.0, 67), np.full(67, -2.5)],
        np.c_[100.0 + 2.5 * np.cos(TURN), 2.5 * np.sin(TURN)],
        np.c_[np.linspace(99.0, 0.0, 67), np.full(67, 2.5)],
    ]
)


@pytest.mark.parametrize(
    ("file", "sentence"),
    [
        (
            text(*ring(), header="road,track"),
            "column x_m of t.csv is missing, must be there, as in x_m, y_m",
        ),
        (text(*ring(6), header="x_m,y_m"), "number of points in t.csv is 5, must be at least 8"),
        (text(*np.repeat(ring(6), 2, axis=1), header="x_m,y_m"), "number of points in t.csv is 5, must be"),
        (
            text(*ring(), header="x_m,y_m").replace("100.000000", "nan", 1),
            "is 'nan', must be a finite number",
        ),
        (text(*ring(), ring()[0], header="x_m,y_m,w_tr_left_m"), "width of t.csv is "),
        (
            text(*ring(200, 2.0), header="x_m,y_m"),
            "length of the road in t.csv is 12.5 m, must be between 20 and 100000 m (degrees belong into",
        ),
        (text(*ring(radius=2e5), header="x_m,y_m"), "m, must be between 20 and 100000 m (is it in mm?)"),
        (
            text(*HAIRPIN.T, header="x_m,y_m"),
            "m, must be at least 4 m (where points are not exact, --smoothing METRES helps)",
        ),
        (
            text(*(np.array(ring()) + np.random.default_rng(0).normal(0, 20, (2, 125))), header="x_m,y_m"),
            "m RMS, must be at most 10 m for a road to be found from them",
        ),
    ],
)
def test_a_centreline_that_is_none_is_refused(file: str, sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_centreline(file, "t.csv")
    assert sentence in str(caught.value)

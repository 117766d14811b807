import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core.errors import InputError
from otolith.vehicle import parse_centreline, road

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


def test_elevation_and_banking_are_taken_over_and_smoothed() -> None:
    x = np.arange(0.0, 1000.0, 10.0)
    z, bank = 2.0 * np.sin(2.0 * np.pi * x / 500.0), np.full(len(x), 3.0)
    path = parse_centreline(text(x, 0.0 * x, z, bank, header="x_m,y_m,z_m,banking_deg"), "hill.csv")
    assert not path.closed
    assert_allclose(path.banking, np.radians(3.0), atol=1e-12)
    inner = slice(100, -100)
    assert_allclose(path.elevation[inner], 2.0 * np.sin(2.0 * np.pi * path.way / 500.0)[inner], atol=0.06)


@pytest.mark.parametrize(
    ("file", "sentence"),
    [
        (text(*ring(), header="x,y"), "column x_m of t.csv is missing, must be there, as in x_m, y_m"),
        (text(*ring(6), header="x_m,y_m"), "number of points in t.csv is 5, must be at least 8"),
        (text(*np.repeat(ring(), 2, axis=1), header="x_m,y_m"), "point in line 3 of t.csv is the same as"),
        (
            text(*ring(), header="x_m,y_m").replace("100.000000", "nan", 1),
            "is 'nan', must be a finite number",
        ),
        (text(*ring(), ring()[0], header="x_m,y_m,w_tr_left_m"), "width of t.csv is "),
        (text(*ring(200, 2.0), header="x_m,y_m"), "length of road t is 12."),
    ],
)
def test_a_centreline_that_is_none_is_refused(file: str, sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_centreline(file, "t.csv")
    assert sentence in str(caught.value)

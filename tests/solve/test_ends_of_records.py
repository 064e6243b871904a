"""A record that ends with the run, in mid-motion: what comes after its last row must not matter."""

import numpy as np
import pytest
from engine_runs import run_text

LAWS = {
    "elastic": 'law = "linear"\nEA = "100 kN"',
    "rods": 'law = "inextensible"',
    "elastic rods": 'law = "inextensible"\nEA = "1 MN"',
}
LINE = """
gravity = 9.81
[materials.rope]
LAW
[lines.rope]
material = "rope"
length = "10 m"
segments = 4
mass = "2 kg/m"
start = { fixed = [0, 0, 0] }
end = END
[solver]
step = "2 ms"
[output]
duration = "0.5 s"
every = "50 ms"
"""
SHIP = '[bodies.ship]\nposition = ["6 m", 0, "4 m"]\npoints = { bow = [0, 0, 0] }\nmotion = { MOTION }\n'


def ended(folder, text, rows):
    """The run with a record of so many rows, of which the last three are of one straight way."""
    time = 0.1 * np.arange(rows)
    way = 0.2 * np.sin(2.0 * np.pi * time / 1.7)
    way[6:] = 2.0 * way[5] - way[4]
    path = f"time = {time.tolist()}, position = {[[6.0 + float(x), 0.0, 4.0] for x in way]}"
    text = text.replace("PATH", path).replace(
        "MOTION", f"time = {time.tolist()}, surge = {way.tolist()}"
    )
    return run_text(folder, text)


@pytest.mark.parametrize(
    ("law", "end"),
    [
        ("elastic", "end"),
        pytest.param("rods", "ship", marks=pytest.mark.slow),
        pytest.param("rods", "end", marks=pytest.mark.slow),
        pytest.param("elastic", "ship", marks=pytest.mark.slow),
        pytest.param("elastic rods", "end", marks=pytest.mark.slow),
        pytest.param("elastic rods", "ship", marks=pytest.mark.slow),
    ],
)
@pytest.mark.slow
def test_what_comes_after_the_run_does_not_matter(tmp_path, law, end):
    text = LINE.replace("LAW", LAWS[law])
    text = (
        text.replace("END", "{ motion = { PATH } }")
        if end == "end"
        else text.replace("END", '"ship.bow"') + SHIP
    )
    with_run, longer = (ended(tmp_path, text, rows) for rows in (6, 7))
    assert with_run.statuses == longer.statuses == ["OK"]
    for name in ("position", "velocity", "tension", "end_tension"):
        np.testing.assert_allclose(with_run[name], longer[name], rtol=1e-7, atol=1e-9)
    for term in with_run.energy:
        np.testing.assert_allclose(with_run.energy[term], longer.energy[term], rtol=1e-7, atol=1e-7)
    assert np.ptp(with_run["velocity"][0, -1, -1]) > 0.05  # it moves at the end

"""What energies a picture shows does not depend on where heights are counted from."""

import numpy as np
import pytest
from engine_runs import fixed, line_text, run_text

from lumpedcable.view import figures_of

FALLS = """
gravity = "9.81 m/s2"

[materials.rope]
law = "linear"
EA = "50 kN"

[events.parts]
breaks = "rope.end"
time = "20 ms"

[solver]
courant = 0.1

[output]
duration = "0.2 s"
every = "10 ms"
"""


def _pictures(folder, top):
    ends = fixed(0, 0, top), fixed(0, 0, top - 2.1)
    run_text(folder, FALLS + line_text("rope", "rope", 2, 1, 0.5, *ends))
    return figures_of(folder / "result.h5")


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    return [_pictures(tmp_path_factory.mktemp("falls"), top) for top in (0.0, 4000.0)]


def _curves(pictures):
    ax = next(ax for ax in pictures["energy"].axes if "energy" in ax.get_ylabel())
    return {line.get_color() + str(line.get_linestyle()): line.get_ydata() for line in ax.lines}


@pytest.mark.slow
def test_heights_count_from_the_start(pictures):
    low, high = map(_curves, pictures)
    assert low.keys() == high.keys()
    assert low
    assert all(np.ptp(values) > 0.0 for values in low.values())
    for name, values in low.items():
        assert high[name] == pytest.approx(values, rel=1e-6, abs=1e-6 * np.abs(values).max())
    labels = [t.get_text() for legend in pictures[0]["energy"].legends for t in legend.get_texts()]
    assert "potential energy of weight less buoyancy, less that at the start" in labels


def test_a_line_of_one_segment_has_a_tension_to_be_seen(pictures):
    (name,) = (n for n in pictures[0] if n.startswith("tension") and "range" not in n)
    ax = pictures[0][name].axes[0]
    (family,) = ax.collections
    along = family.get_segments()[0]
    assert along[:, 0] == pytest.approx([0.0, 2.0])
    assert along[0, 1] == along[1, 1] == pytest.approx(50e3 * 0.05 / 1e3, rel=1e-3)  # kN

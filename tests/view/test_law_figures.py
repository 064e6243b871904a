"""The picture of tension laws that a fit found."""

import numpy as np
import pytest

from lumpedcable.view.fit import FitPictures, Law, law_figure


@pytest.mark.parametrize("highest", [40e3, 70.4e3])
def test_all_that_a_bench_measured_is_in_the_picture(highest):
    # loops of what relaxes rise above the law of slow loads
    strain = np.linspace(0.0, 0.1, 11)
    data = ("bench", strain, np.linspace(0.0, highest, 11))
    law = Law("rope", strain, 3e5 * strain, 5e5 * strain, 0.0 * strain, [data])
    figure = law_figure(FitPictures("a rope", [], [], np.zeros((0, 0)), [law], [], [], 0.95))
    (ax,) = figure.axes
    assert ax.get_ylabel() == "tension (kN)"
    assert ax.get_ylim()[1] == pytest.approx(1.15e-3 * max(highest, 50e3))

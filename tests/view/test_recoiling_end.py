"""How far a broken end has come is counted from where its break began, as the table has it."""

import pytest
from engine_runs import run_text

from lumpedcable.results import open_result
from lumpedcable.view.sampling import RecoilingEnd

TOWED = """
[materials.wire]
law = "linear"
EA = "1 MN"

[lines.rope]
material = "wire"
length = "10 m"
segments = 10
mass = "1 kg/m"
start = { fixed = [0, 0, 0] }
end = { motion = { position = [10.01, 0, 0], velocity = [5, 0, 0] } }

[events.snap]
breaks = "rope"
place = "5 m"
start = "30 ms"
time = "1 ms"

[output]
duration = "60 ms"
every = "10 ms"
"""


@pytest.mark.slow
def test_it_is_counted_from_where_the_break_began(tmp_path):
    run_text(tmp_path, TOWED)
    with open_result(tmp_path / "result.h5") as result:
        for name, numbers in ((name, result.summary()[name]) for name in result.ends):
            way = RecoilingEnd(result, name).displacement(0)
            assert way[3] == 0.0  # at 30 ms
            assert way[0] > 0.01
            assert way[-1] == pytest.approx(numbers["end_displacement"][0], rel=1e-6)

"""When a body comes to rest."""

import pytest
from engine_runs import run_text, sliding_block


@pytest.mark.parametrize("step", [pytest.param("0.5 ms", marks=pytest.mark.slow), "1 ms"])
def test_a_body_with_an_elastic_line_stops_when_coulomb_says(tmp_path, step):
    # 0.4 g takes 0.2548 s for 1 m/s, and the line is a millionth of the block; what is left of the speed
    # then is rounding, which is not 0 for twenty steps
    text = sliding_block(speed=1, step=step, duration="0.4 s", every="10 ms")
    text = text.replace('law = "inextensible"', 'law = "linear"\nEA = 10')
    ran = run_text(tmp_path, text.replace("[output]", '[output]\nstop = "block"'))
    assert ran.statuses == ["OK"]
    assert ran.outcomes[0].stop_time == pytest.approx(1.0 / (0.4 * 9.81), rel=1e-6)

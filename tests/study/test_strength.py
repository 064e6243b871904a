"""The largest tension over the breaking strength: by hand, in the file, in the table, in remarks."""

from contextlib import redirect_stdout
from io import StringIO

import numpy as np
import pytest
from engine_runs import HOOKE, fixed, line_text, study_of

from lumpedcable.results import open_result
from lumpedcable.status import Status
from lumpedcable.study.plan import plan_of, structure_of
from lumpedcable.study.report import results_table
from lumpedcable.study.run import run_study

# held at 50 kN and not let go
STILL = HOOKE[: HOOKE.index("[events")] + HOOKE[HOOKE.index("[output]") :]
STRONG = STILL.replace('EA = "1 MN"', 'EA = "1 MN"\nbreaking_strength = "80 kN"')
SHORT = "output.duration=20 ms"


def run(folder, text, *overrides):
    study = study_of(folder, text, *overrides)
    return study, run_study(study, folder / "result.h5")


def table_of(folder, study, outcomes):
    with redirect_stdout(StringIO()) as out:
        results_table(study, folder / "result.h5", outcomes)
    return out.getvalue()


@pytest.mark.parametrize("method", ["leapfrog", "rk4"])
@pytest.mark.parametrize("keep", ["fields", "summaries"])
def test_it_is_the_pretension_over_the_strength(tmp_path, method, keep):
    step = () if method == "leapfrog" else ("solver.step=1 ms",)
    more = (SHORT, f"solver.method={method}", f"output.keep={keep}", *step)
    study, outcomes = run(tmp_path, STRONG, *more)
    assert outcomes[0].utilisation == pytest.approx(50 / 80, rel=1e-9)
    assert outcomes[0].message == "ok"
    with open_result(tmp_path / "result.h5") as result:
        np.testing.assert_array_equal(
            result.summary()["run"]["utilisation"], [outcomes[0].utilisation]
        )
        assert result.summary_attributes("run", "utilisation")["units"] == "1"
        if keep == "fields":
            assert result.line("rope").breaking_strength() == 80e3
    text = table_of(tmp_path, study, outcomes)
    assert "sation" in text
    assert "0.625" in text


def test_a_swept_strength_moves_nothing_and_needs_no_other_start(tmp_path):
    text = STRONG + '[sweep]\n"materials.hooke.breaking_strength" = ["80 kN", "40 kN", "25 kN"]\n'
    study, outcomes = run(tmp_path, text, SHORT)
    used = [outcome.utilisation for outcome in outcomes]
    np.testing.assert_allclose(used, [50 / 80, 50 / 40, 50 / 25], rtol=1e-9)
    assert study.runs.moved == frozenset()
    assert [outcome.message == "ok" for outcome in outcomes] == [True, False, False]
    # at the start already, and everywhere in a straight line without weight
    assert 'line "rope" bears 50 kN at ' in outcomes[1].message
    assert "1.25 times its breaking strength of 40 kN: beyond it by 0 s" in outcomes[1].message
    assert "run 2: " in table_of(tmp_path, study, outcomes)
    with open_result(tmp_path / "result.h5") as result:
        line = result.line("rope")
        assert [line.breaking_strength(k) for k in range(3)] == [80e3, 40e3, 25e3]
        assert np.ptp(line.tension(), axis=0).max() == 0.0


# two taut lines side by side: strains of 0.01 and 0.02, tensions of 10 and 40 kN
PAIR = "\n".join(
    [
        "[materials.thin]\nlaw = 'linear'\nEA = 1e6\nbreaking_strength = 50e3",
        "[materials.thick]\nlaw = 'linear'\nEA = 2e6\nbreaking_strength = 100e3",
        line_text("a", "thin", 10.0, 4, 1.0, fixed(0, 0, 0), fixed(10.1, 0, 0)),
        line_text("b", "thick", 10.0, 4, 1.0, fixed(0, 1, 0), fixed(10.2, 1, 0)),
        '[output]\nduration = "10 ms"\nevery = "1 ms"\n',
    ]
)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["leapfrog", "rk4"])
def test_each_line_is_compared_with_its_own(tmp_path, method):
    more = (f"solver.method={method}", "solver.step=0.5 ms", "output.keep=summaries")
    _, (outcome,) = run(tmp_path, PAIR, *more)
    assert outcome.utilisation == pytest.approx(0.4)
    # the thin one bears less, but of its own strength more
    _, (outcome,) = run(tmp_path, PAIR, *more, "materials.thin.breaking_strength=8 kN")
    assert outcome.utilisation == pytest.approx(10 / 8)
    assert 'line "a" bears 10 kN' in outcome.message
    # a material that has none is compared with nothing
    thick = PAIR.replace("\nbreaking_strength = 100e3", "")
    _, (outcome,) = run(tmp_path, thick, *more)
    assert outcome.utilisation == pytest.approx(0.2)
    both = ("materials.thin.breaking_strength=8 kN", "materials.thick.breaking_strength=8 kN")
    _, (outcome,) = run(tmp_path, PAIR, *more, *both)
    assert outcome.utilisation == pytest.approx(5.0)
    assert 'line "b" bears 40 kN' in outcome.message
    assert "so is another line" in outcome.message


PULLED = """
[materials.cord]
law = "linear"
EA = "1 MN"
max_strain = 0.3
breaking_strength = "250 kN"
[lines.rope]
material = "cord"
length = 10
segments = 8
mass = "1 kg/m"
start = { fixed = [0, 0, 0] }
end = { motion = { position = [10, 0, 0], velocity = [10, 0, 0] } }
[output]
duration = "400 ms"
every = "2 ms"
"""


def test_where_and_when_it_was_first_beyond(tmp_path):
    # the tension rises by 2 kN with each wave of 20 ms to and fro: 250 kN between 0.23 and 0.25 s
    fine = PULLED.replace("0.3\n", "0.5\n")
    _, (outcome,) = run(tmp_path, fine)
    assert outcome.status is Status.OK
    assert outcome.utilisation == pytest.approx(400 / 250, abs=20 / 250)
    by = float(outcome.message.split("beyond it by ")[1].removesuffix(" ms"))
    assert 228 <= by <= 254
    place = float(outcome.message.split(" at ")[1].split(" m,")[0])
    assert np.isclose(place % 1.25, 0.625)  # the middle of a segment
    with open_result(tmp_path / "result.h5") as result:
        line = result.line("rope")
        most = line.field("peak_tension", 0)
        assert line.unstretched_segment(0)[most.argmax()] == pytest.approx(place)


HANGING = """
gravity = 9.81
[materials.chain]
law = "linear"
EA = "1 GN"
breaking_strength = "1 MN"
[lines.chain]
material = "chain"
length = 1000
segments = 10
mass = "105 kg/m"
start = { fixed = [0, 0, 0] }
end = "free"
[output]
duration = "2 s"
every = "1 s"
"""


@pytest.mark.parametrize("overrides", [(), pytest.param(("output={}",), marks=pytest.mark.slow)])
def test_an_end_bears_more_than_the_middle_of_its_segment(tmp_path, overrides):
    weight = 105 * 9.81 * 1000
    _, (outcome,) = run(tmp_path, HANGING, *overrides)
    assert outcome.utilisation == pytest.approx(weight / 1e6, rel=1e-6)
    assert 'line "chain" bears 1.03 MN' in outcome.message
    if not overrides:
        assert " at 0 m, 1.03 times its breaking strength" in outcome.message


def test_of_a_run_that_goes_wrong_it_is_that_of_before(tmp_path):
    # strained beyond 0.3 it goes on to 400 kN, which are none of a law for less than 300
    _, (outcome,) = run(tmp_path, PULLED)
    assert outcome.status is Status.STRAIN_EXCEEDED
    assert 1.0 < outcome.utilisation <= 300 / 250 * 1.001
    assert 'line "rope" bears' in outcome.message
    pull = 'start = { held = { pretension = "40 kN", direction = [-1, 0, 0] } }'
    torn = STRONG.replace("start = { fixed = [0, 0, 0] }", pull)
    _, (outcome,) = run(tmp_path, torn, SHORT)
    assert outcome.status is Status.STATICS_NOT_CONVERGED
    assert np.isnan(outcome.utilisation)


def test_without_the_key_there_is_none(tmp_path):
    study, outcomes = run(tmp_path, STILL, SHORT)
    assert np.isnan(outcomes[0].utilisation)
    assert "sation" not in table_of(tmp_path, study, outcomes)
    with open_result(tmp_path / "result.h5") as result:
        assert "utilisation" not in result.summary()["run"]
        assert not result.line("rope").has("breaking_strength")


def test_a_strength_is_no_part_of_the_program(tmp_path):
    bare, strong = (study_of(tmp_path, text, SHORT).scene for text in (STILL, STRONG))
    assert strong.numbers() == bare.numbers()
    assert structure_of(strong) == structure_of(bare)
    one, other = (plan_of(scene, structure_of(scene).layout) for scene in (bare, strong))
    assert one == other


# the top one of four rods bears the lumps below it: 8.75 of 10 kg
HANGS = "gravity = 9.81\n" + "\n".join(
    [
        "[materials.chain]\nlaw = 'inextensible'\nbreaking_strength = 50",
        line_text("chain", "chain", 10.0, 4, 1.0, fixed(0, 0, 0), '"free"'),
        "[solver]\nstep = '1 ms'\n[output]\nduration = '10 ms'\nevery = '5 ms'\n",
    ]
)


@pytest.mark.slow
def test_of_inextensible_lines_too(tmp_path):
    _, (outcome,) = run(tmp_path, HANGS)
    assert outcome.utilisation == pytest.approx(10 * 9.81 / 50, rel=1e-6)
    assert 'line "chain" bears 98.1 N at 0 m' in outcome.message

"""Bad fit files and bad data end in one message each, with its place, and leave nothing behind."""

import pickle

import pytest
from command_line import refused
from fit_files import BENCH, SCENE, free

import lumpedcable as lc
from lumpedcable.scene import SceneError

GOOD = 'scene = "scene.toml"\n' + free([2e5], ["materials.nylon.p1"]) + BENCH
TABLE = "strain (%),load\n1,2\n2,3.5\n3,5\n"
RECORD = (
    'scene = "scene.toml"\n'
    + free([2e5], ["materials.nylon.p1"])
    + """
[experiments.test]
file = "test.csv"
time = { column = "t", unit = "ms" }
observe = [{ quantity = "tension", at = "rope.start", column = "F" }]
"""
)
MOVED = SCENE.split("[events.break]")[0].replace(
    'held = { pretension = "45 kN", direction = [1, 0, 0] }',
    'motion = { time = [0, "10 ms", "20 ms"], position = [[61, 0, 0], [61, 0, 0], [62, 0, 0]] }',
)
MOVED += '[output]\nduration = "20 ms"\nevery = "1 ms"\n'
TIMES = "t,F\n1,2\n2,3.5\n3,5\n"
SMOOTH = (
    """scene = "scene.toml"
[set]
"materials.nylon" = { law = "table", strain = [0, 0.1, 0.3], tension = [0, 1e5, 4e5] }
[free]
"materials.nylon.tension" = { smooth = 0.5 }
"""
    + BENCH
)

# (fit file, bench.csv or test.csv, what must be said)
MISTAKES = {
    "no such key": (GOOD.replace("p1", "p9"), TABLE, 'found "materials.nylon.p9"'),
    "whole number": (GOOD.replace("materials.nylon.p1", "lines.rope.segments"), TABLE,
                     "varies smoothly"),
    "method": (GOOD.replace("materials.nylon.p1", "solver.courant"), TABLE, "number of the physics"),
    "not used": (GOOD.replace("materials.nylon.p1", "lines.rope.mass"), TABLE,
                 'an experiment depends on, found "lines.rope.mass"'),
    "not used, of the material": (GOOD.replace("p1", "max_strain").replace("200000.0", "0.4"), TABLE,
                                  'depends on, found "materials.nylon.max_strain"'),
    "not used by a record either": (RECORD.replace("p1", "max_strain").replace("200000.0", "0.4"),
                                    TIMES, 'depends on, found "materials.nylon.max_strain"'),
    "not used by a bench at rest": (
        GOOD.replace("[free]", '[set]\n"materials.nylon.damping" = "1 kN s"\n[free]')
        .replace("p1", "damping"), TABLE, 'depends on, found "materials.nylon.damping"'),
    "a value of its own for what is shared": (
        RECORD + RECORD[RECORD.index("[exp"):].replace(".test]", ".more]")
        + 'set = { "materials.nylon.p1" = 3e5 }\n', TIMES,
        'one value of "materials.nylon.p1" to begin with, found one in "test" and another in "more"'),
    "unit of a start": (GOOD.replace("start = 200000.0", 'start = "2 m"'), TABLE,
                        "expected a force (N), found a length (m)"),
    "start beyond a bound": (GOOD.replace("start = 200000.0", "start = 2e5, high = 1e5"), TABLE,
                             "expected a start between the bounds"),
    "bounds that cross": (GOOD.replace("start = 200000.0", 'low = "200 kN", high = "100 kN"'), TABLE,
                          'p1".high: expected high above low = 200 kN, found '
                          "100 kN"),
    "a high below what the scene allows": (
        RECORD.replace("materials.nylon.p1", "lines.rope.mass").replace("200000.0", '2, high = -1'),
        TIMES, "high: expected high above 0 kg/m, found -1 kg/m"),
    "missing column": (GOOD, TABLE.replace("load", "laod"), 'did you mean "laod"?'),
    "unit of a column by half its name": (
        GOOD.replace('unit = "kN"', 'unit = "mm"'), TABLE.replace("load", "load (kN)"),
        'expected a unit of a force (N), found "mm"'),
    "a column misspelt": (GOOD.replace('"load"', '"laod"'), TABLE,
                          'experiments.bench.tension.column: expected a column of bench.csv, '
                          'found "laod"; did you mean "load"?'),
    "a column unlike any": (RECORD.replace('"F"', '"colour"'), TIMES,
                            'experiments.test.observe.0.column: expected a column of test.csv, '
                            'found "colour"; it has t, F'),
    "no scene": (GOOD.replace('"scene.toml"', '""'), TABLE,
                 'scene: expected a scene file, found the folder "."'),
    "unit of a column": (GOOD.replace('unit = "kN"', 'unit = "mm"'), TABLE,
                         'expected a unit of a force (N), found "mm"'),
    "two units": (GOOD.replace("strain (%)\"", "strain (%)\", unit = \"\""), TABLE,
                  'the unit in the column\'s name, "%", found ""'),
    "brackets that are no unit": (GOOD.replace('"load", unit = "kN"', '"load (raw)"'),
                                  TABLE.replace("load", "load (raw)"),
                                  'expected a unit of a force (N), found unknown unit "raw"'),
    "brackets of two units": (GOOD.replace('"load", unit = "kN"', '"load (N) as (kN)"'),
                              TABLE.replace("load", "load (N) as (kN)"),
                              'one unit in brackets, found "N" and "kN"'),
    "a column that is there twice": (GOOD, "strain (%),load,load\n1,2,3\n2,3,4\n3,4,5\n",
                                     'tension.column: expected one column "load" of bench.csv, '
                                     "found 2"),
    "thousands separators": (GOOD, TABLE.replace("3.5", "3,500"),
                             "expected 2 cells, as in the header, found 3 in bench.csv:3; write "
                             "numbers with a decimal point, without separators of thousands"),
    "decimal commas": (GOOD, TABLE.replace("2,3.5", "2,0,3,5"), "found 4 in bench.csv:3"),
    "semicolons": (GOOD, TABLE.replace(".", ",").replace(",l", ";l").replace("\n1,", "\n1;"),
                   "experiments.bench.file: expected columns separated by commas, and numbers with a "
                   "decimal point, found semicolons in bench.csv:1"),
    "tabs": (GOOD, TABLE.replace(",", "\t"), "decimal point, found tabs in bench.csv:1"),
    "an error of a spreadsheet": (GOOD, TABLE.replace("2,3.5", "#N/A,3.5"),
                                  'in column strain (%), found "#N/A" in bench.csv:3'),
    "a dead channel": (GOOD + 'noise = "1 %"\n', "strain (%),load\n1,0\n2,0\n3,0\n",
                       "experiments.bench.noise: expected a value other than 0 in column load"),
    "a dead channel of a record": (RECORD.replace('"F" }', '"F", noise = "1 %" }'),
                                   "t,F\n1,0\n2,0\n3,0\n", "a value other than 0 in column F"),
    "a bench of what keeps its length": (
        GOOD.replace("scene.toml", "swept.toml").replace('"nylon"', '"stiff"'), TABLE,
        'experiments.bench.material: expected a material whose tension follows from its strain, '
        'found "stiff"'),
    "outliers without a noise": (GOOD + '[method]\nloss = "huber"\n', TABLE,
                                 "method.loss: expected the noise of every column, since huber"),
    "smooth without a noise": (SMOOTH, TABLE, "expected the noise of every column, against which"),
    "smooth about no slope": (SMOOTH.replace("smooth", 'start = "100 kN", smooth')
                              + 'noise = "1 kN"\n', TABLE,
                              "tensions that start at a slope, of whose mean this is a share, "
                              "found 100 kN at both ends"),
    "a bound below what the scene allows": (
        RECORD.replace("materials.nylon.p1", "lines.rope.mass")
        .replace("200000.0", '2, low = "-1 kg/m"'), TIMES,
        'low: expected a non-negative mass per length (kg/m), found "-1 kg/m"'),
    "nan": (GOOD, TABLE.replace("3.5", "nan"), 'column load, found "nan" in bench.csv:3'),
    "empty cell": (GOOD, TABLE.replace("3.5", ""), "found nothing in bench.csv:3"),
    "a load of a galaxy": (GOOD, TABLE.replace("3.5", "-1e200"),
                           "experiments.bench.tension.column: expected values up to 1e+100 N in "
                           "column load, found -1e+203 N in bench.csv:3"),
    "a load of no number": (GOOD, TABLE.replace("3.5", "1e306"),
                            "found what is too large for a number in bench.csv:3"),
    "too few rows": (GOOD, "strain (%),load\n1,2\n", "at least 2 rows"),
    "too few values": (
        'scene = "scene.toml"\n' + free([2e5, 10, -2, 2e5], [f"materials.nylon.p{k}" for k in
                                                             (1, 2, 3, 4)]) + BENCH,
        TABLE, "found 3 values for 4 numbers"),
    "no tensions": (GOOD, "strain (%),load\n1,0\n2,0\n3,0\n",
                    'expected tensions, found nothing but 0 in column load of bench.csv'),
    "strain beyond": (GOOD, TABLE.replace("3,5", "60,5"),
                      "max_strain of materials.nylon, 0.5, found 0.6 in bench.csv:4"),
    "no file": (GOOD.replace("bench.csv", "bnech.csv"), TABLE, "expected a file, found none"),
    "no material": (GOOD.replace('"nylon"', '"nylo"'), TABLE, 'did you mean "nylon"?'),
    "noise": (GOOD + 'noise = "2 m"\n', TABLE, "expected a positive force (N) or a percentage"),
    "unknown key": (GOOD + "nosie = 1\n", TABLE, 'did you mean "noise"?'),
    "certainty": (GOOD + "[method]\nconfidence = 1\n", TABLE,
                  "method.confidence: expected less than 1, found 1"),
    "certainty to rounding": (GOOD + "[method]\nconfidence = 0.9999999999999999\n", TABLE,
                              "expected less than 1, found 0.99999999999999989, which is 1 to"),
    "a noise beyond the column": (GOOD + "noise = 1e300\n", TABLE,
                                  "experiments.bench.noise: expected a noise from 0.005 uN to 5 GN, "
                                  "since column load goes up to 5 kN, found "),
    "a noise of nothing": (GOOD + "noise = 1e-300\n", TABLE,
                           "experiments.bench.noise: expected a noise from 0.005 uN"),
    "a noise of nothing in a record": (RECORD.replace('"F" }', '"F", noise = "1e-300 %" }'), TIMES,
                                       "experiments.test.observe.0.noise: expected a noise from"),
    "starts without bounds": (GOOD + "[method]\nstarts = 4\n", TABLE, "expected low and high"),
    "time again": (RECORD, TIMES.replace("3,5", "2,5"), "found 2 ms again in test.csv:4"),
    "time back": (RECORD, TIMES.replace("3,5", "1.5,5"), "found 1.5 ms after 2 ms in test.csv:4"),
    "time before 0": (RECORD, TIMES.replace("1,2", "-1,2"), "found -1 ms in test.csv:2"),
    "milliseconds taken for seconds": (
        RECORD.replace('"t", unit = "ms"', '"t (s)"'), TIMES.replace("t,", "t (s),"),
        "fit.toml:7: experiments.test.time: expected times of about output.duration, 20 ms, found 3 s "
        "at the end of column t (s) in test.csv: correct its unit, or give a longer output.duration "
        "in set"),
    "no line": (RECORD.replace("rope.start", "rop.start"), TIMES, 'did you mean "rope"?'),
    "no end of a line": (RECORD.replace("rope.start", "rope.strat"), TIMES,
                         'found "rope.strat"; did you mean "rope.start"?'),
    "beyond the line": (RECORD.replace("rope.start", "rope@70 m"), TIMES, "found 70 m"),
    "data with a sign of what has none": (
        RECORD.replace("tension", "velocity").replace("rope.start", "rope.end"),
        TIMES.replace("3,5", "3,-5"),
        'observe.0.component: expected "x", "y" or "z" for data of a velocity that are negative, '
        "down to -5 m/s; without it its size is meant"),
    "component": (RECORD.replace('"F" }', '"F", component = "x" }'), TIMES, "none for a tension"),
    "setting": (RECORD.replace("file =", 'set = { pretensoin = "9 kN" }\nfile ='), TIMES,
                'did you mean "lines.rope.end.held.pretension"?'),
    "out of reach": (RECORD.replace("file =", 'set = { pretension = "9 MN" }\nfile ='), TIMES,
                     "9 MN"),
    "sweep": (RECORD.replace("scene.toml", "swept.toml"), TIMES, "a sweep of 2: set"),
    "a motion that ends before the data": (
        RECORD.replace("scene.toml", "moved.toml"), TIMES.replace("3,5", "30,5"),
        "fit.toml:7: experiments.test.time: lines.rope.end.motion.time: expected a record until the "
        "data end at 30 ms, or one that ends at rest, found its last time at 20 ms"),
}  # fmt: skip


@pytest.mark.parametrize(("text", "data", "said"), MISTAKES.values(), ids=MISTAKES.keys())
def test_a_mistake_is_told_with_its_place(tmp_path, text, data, said):
    (tmp_path / "scene.toml").write_text(SCENE)
    sweep = '[sweep]\n"lines.rope.end.held.pretension" = ["45 kN", "50 kN"]\n'
    stiff = '[materials.stiff]\nlaw = "inextensible"\n'
    (tmp_path / "swept.toml").write_text(SCENE + stiff + sweep)
    (tmp_path / "moved.toml").write_text(MOVED)
    (tmp_path / ("test.csv" if "test.csv" in text else "bench.csv")).write_text(data)
    (tmp_path / "fit.toml").write_text(text)
    told = refused(tmp_path, "fit", "fit.toml")
    assert said in told
    assert all(line.startswith("fit.toml:") for line in told.splitlines())


@pytest.mark.parametrize("start", ["1e308", "-1e308", "1e200"])
def test_a_start_from_which_everything_overflows(tmp_path, start):
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "bench.csv").write_text(TABLE)
    (tmp_path / "fit.toml").write_text(GOOD.replace("200000.0", start))
    told = refused(tmp_path, "fit", "fit.toml")
    assert told.startswith("fit.toml: free: expected start values from which")
    assert told.count("\n") == 1


def test_a_record_that_would_never_end(tmp_path):
    # a line without mass to speak of: waves of 1e15 times their speed
    (tmp_path / "scene.toml").write_text(SCENE.replace("2.238 kg/m", "2e-30 kg/m"))
    (tmp_path / "test.csv").write_text(TIMES)
    (tmp_path / "fit.toml").write_text(RECORD)
    told = refused(tmp_path, "fit", "fit.toml")
    assert told.startswith(
        'scene.toml: experiment "test", at the start values: more steps are needed'
    )


def test_the_good_files_are_good(tmp_path):
    from lumpedcable.fitting.load import load_fit

    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "bench.csv").write_text(TABLE)
    (tmp_path / "test.csv").write_text(TIMES)
    (tmp_path / "moved.toml").write_text(MOVED)
    long = 'set = { "output.duration" = "1 s" }\n[free]'
    for text in (
        GOOD,
        RECORD,
        RECORD.replace("scene.toml", "moved.toml"),
        RECORD.replace('"ms"', '"s"').replace("[free]", long),
    ):
        (tmp_path / "fit.toml").write_text(text)
        assert load_fit(tmp_path / "fit.toml").problem.points == 3


@pytest.mark.parametrize(
    ("name", "newtons"),
    [("load (kN) filtered", 1e3), ("F [N]", 1.0), ("(kN) load (end 2)", 1e3), ("load", 1.0)],
)
def test_the_unit_in_brackets_is_read_wherever_it_stands(tmp_path, name, newtons):
    from lumpedcable.fitting.load import load_fit

    (tmp_path / "scene.toml").write_text(SCENE)
    # an empty cell too many, as a spreadsheet leaves it, is no number
    (tmp_path / "bench.csv").write_text(f"strain (%),{name}\n1,2\n2,3.5,\n3,5\n")
    (tmp_path / "fit.toml").write_text(GOOD.replace('"load", unit = "kN"', f'"{name}"'))
    (series,) = load_fit(tmp_path / "fit.toml").problem.series
    assert series.values.tolist() == [2.0 * newtons, 3.5 * newtons, 5.0 * newtons]


def test_a_place_that_is_not_there_is_told_to_programs_as_any_fault_of_a_scene(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE)
    with pytest.raises(SceneError, match=r'found "rope.strat"; did you mean "rope.start"') as told:
        lc.sensitivity(tmp_path / "scene.toml", "max tension at rope.strat")
    assert str(pickle.loads(pickle.dumps(told.value))) == str(told.value)

"""Settings that only a sweep gives: what is wrong with them is told where they stand."""

import good_scenes
import pytest
from swept_rope import LIST, REFERENCE, faults

from lumpedcable.scene import SceneError, load_study


@pytest.mark.parametrize(
    ("sweep", "line"),
    [
        ('"solver.rtol" = [1e-6, 1e-8]', '"solver.rtol"'),
        ('"solver.rtol" = [\n  1e-6,\n  1e-8,\n]', "  1e-6,"),
        (
            '"gravity" = [9.81, 1.62]\n"solver.rtol" = { from = 1e-8, to = 1e-6, count = 2 }',
            '"solver.rtol"',
        ),
    ],
)
def test_a_number_that_does_not_fit_is_told_in_its_line(tmp_path, sweep, line):
    text = good_scenes.ROPE[:REFERENCE].replace(LIST, "") + f"[sweep]\n{sweep}\n"
    with pytest.raises(SceneError) as caught:
        load_study(good_scenes.write(tmp_path, text))
    (fault,) = [fault for fault in caught.value.faults if "no rtol" in fault.message]
    assert text.splitlines()[fault.line - 1].startswith(line)
    assert fault.key.startswith('sweep."solver.rtol"')
    assert len(caught.value.faults) == 1


@pytest.mark.parametrize(
    "key", ["solver.method", "solver.waves", "solver", "lines.rope.end.held", "materials.nylon.law"]
)
def test_what_is_no_number_is_told_as_such_whether_it_is_given_or_not(tmp_path, key):
    told = faults(tmp_path, f'[sweep]\n"{key}" = ["rk4", "leapfrog"]\n')
    words = f'expected the full path of a number of the scene, found "{key}", which is no number'
    assert [message for _, message in told] == [words]


@pytest.mark.parametrize("key", ["lines.rop.length", "lengt", "materials.rop.EA"])
def test_what_is_not_there_has_a_hint(tmp_path, key):
    ((_, message),) = faults(tmp_path, f'[sweep]\n"{key}" = [1, 2]\n')
    assert "which is no number" not in message

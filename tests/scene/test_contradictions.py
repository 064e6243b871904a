"""What a scene says twice, or cannot mean: told when it is read, where it was silently lost before."""

import pytest

from lumpedcable.scene import SceneError, load_study
from lumpedcable.scene.outcomes import QUANTITIES, SUMMARIES, TAKEN

LINE = """\
gravity = "9.81 m/s2"

[water]
density = "1025 kg/m3"

[materials.wire]
law = "linear"
EA = "10 MN"

[lines.rope]
material = "wire"
length = "60 m"
segments = 10
mass = "5 kg/m"
diameter = "50 mm"
start = { fixed = [0, 0, 0] }
end = { fixed = ["55 m", 0, 0] }

[events.break]
breaks = "rope.end"
time = "5 ms"

[output]
duration = "20 ms"
every = "10 ms"
"""


def read(folder, text, *sets):
    (folder / "scene.toml").write_text(text)
    return load_study(folder / "scene.toml", sets)


def faults(folder, text, *sets):
    with pytest.raises(SceneError) as caught:
        read(folder, text, *sets)
    return [(fault.key, fault.message) for fault in caught.value.faults]


@pytest.mark.parametrize("name", ["peak_tension", "energy_closure", "solver_steps", "reach"])
def test_a_measure_is_not_called_like_a_number_of_the_run(tmp_path, name):
    # /summary has one number of a name, and a reference means one of them
    ((key, message),) = faults(tmp_path, f'{LINE}[measures.{name}]\ntension = "rope@30 m"\n')
    assert key == f"measures.{name}"
    assert f'expected another name, found "{name}"' in message
    read(tmp_path, f'{LINE}[measures.my_{name}]\ntension = "rope@30 m"\n')


def test_the_names_that_are_taken_are_all_that_a_run_writes():
    assert {*SUMMARIES, *QUANTITIES, "solver_steps"} == TAKEN

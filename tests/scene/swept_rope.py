"""The rope of `good_scenes` with other sweeps, for tests of these."""

import good_scenes
import pytest

from lumpedcable.scene import SceneError, load_study

PRETENSION = "lines.rope.end.held.pretension"
TIME = "events.break.time"
HOLD = "lines.rope.start.fixed.2"
LIST = f'[sweep]\n"{PRETENSION}" = ["45 kN", "180 kN"]\n'
REFERENCE = good_scenes.ROPE.index("[references.paper]")


def study_of(folder, sweep, overrides=()):
    """The rope with another sweep (and no references, which belong to its own)."""
    text = good_scenes.ROPE[:REFERENCE].replace(LIST, "")
    return load_study(good_scenes.write(folder, text + sweep), overrides)


def faults(folder, sweep):
    with pytest.raises(SceneError) as caught:
        study_of(folder, sweep)
    return [(fault.key, fault.message) for fault in caught.value.faults]


def values(study, key):
    return [study.runs.values(run)[key] for run in range(len(study.runs))]

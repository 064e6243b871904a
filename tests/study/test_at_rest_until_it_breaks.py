"""A line stays at rest until it breaks, whatever loads it, and its wave is then its own."""

import numpy as np
import pytest
from engine_runs import line_text, run_text

WIRE = """
gravity = 9.80665
[materials.wire]
law = "linear"
EA = "10 MN"
{cut}
"""
BREAK = """
[events.break]
breaks = "{place}"
start = "0.5 s"
time = "20 ms"
[output]
duration = "0.6 s"
every = "20 ms"
"""
TOP, HIGH, HELD = (
    "{ fixed = [0, 0, 0] }", "{ fixed = [95, 0, 10] }",
    "{ held = { pretension = 10000, direction = [0, 0, -1] } }",
)  # fmt: skip
CURRENT = "[water]\ndensity = 1025\ncurrent = { velocity = [1, 0.3, 0] }\n"
DRAG = "drag = { normal = 1.2, tangential = 0.1 }"
BED = "[seabed]\nheight = -20\nstiffness = 1e5\ndamping = 1e4\n"


def line(start=TOP, end=HIGH, name="line", length=100, segments=20, more=""):
    return line_text(name, "wire", length, segments, 20, start, end, f"diameter = 0.05\n{more}")


SCENES = {
    "hanging": (line(end=HELD), "line.end"),
    "sagging": (line(), "line.end"),
    "pulled aslant": (line(end=HELD.replace("[0, 0, -1]", "[1, 0, 0.2]")), "line.end"),
    "along it": (line(), "line@35 m"),
    "graded": (line(more="grading = 4"), "line.end"),
    "on a bed": (BED + line(end="{ fixed = [85, 0, -20] }"), "line.start"),
    "in a current": (CURRENT + line(more=DRAG), "line.end"),
    "two of them": (
        line(end='"other.start"', length=60, segments=12)
        + line('"free"', HIGH, "other", length=40),
        "other.end",
    ),
    # a graded line on a bed in a current that breaks along it, and at its start as well
    "all at once": (
        BED + CURRENT + line(end="{ fixed = [90, 0, -20] }", more="grading = 4\n" + DRAG)
        + '[events.too]\nbreaks = "line.start"\nstart = "0.51 s"\ntime = "9 ms"\n',
        "line@20 m",
    ),
}  # fmt: skip


def variants():
    """Each with lines that fall slack and with others; all but one are slow."""
    for name, scene in SCENES.items():
        marks = () if name == "pulled aslant" else pytest.mark.slow
        yield pytest.param(scene, True, id=f"{name}-tension only", marks=marks)
        yield pytest.param(scene, False, id=f"{name}-linear", marks=pytest.mark.slow)


@pytest.mark.parametrize(("scene", "slack"), list(variants()))
@pytest.mark.slow
def test_it_stays_at_rest(tmp_path, scene, slack):
    parts, place = scene
    text = WIRE.format(cut="tension_only = true" if slack else "") + parts
    ran = run_text(tmp_path, text + BREAK.format(place=place))
    assert ran.statuses == ["OK"]
    broken = ran.time > 0.49
    for found in ran.lines.values():
        tension = found["tension"][0]
        # statics leave some billionths of the largest force
        np.testing.assert_allclose(tension[~broken], tension[:1].repeat(25, 0), atol=1e-3)
        assert np.abs(found["velocity"][0][~broken]).max() < 1e-9
    assert any(np.ptp(found["tension"][0], axis=0).max() > 1e3 for found in ran.lines.values())


def test_weight_changes_nothing_of_a_wave_in_a_linear_line(tmp_path):
    # superposition: what a hanging line's tension has more than at rest is that of one of no weight to
    # speak of, 2e-6 N, through the break, the wall's answer and the end's
    with_weight = WIRE.format(cut="") + line(end=HELD) + BREAK.format(place="line.end")
    weightless = with_weight.replace("gravity = 9.80665", "gravity = 1e-9")
    changes = []
    for name, text in (("heavy", with_weight), ("light", weightless)):
        folder = tmp_path / name
        folder.mkdir()
        ran = run_text(folder, text)
        changes.append(ran["tension"][0] - ran["tension"][0, :1])
    assert np.abs(changes[1]).max() > 9e3
    np.testing.assert_allclose(changes[0], changes[1], atol=1e-3)

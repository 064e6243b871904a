"""Free numbers that lead out of the line or plane that their scene lies in."""

import jax
import numpy as np
import pytest
from engine_runs import study_of
from fit_files import fit_of

import lumpedcable as lc
from lumpedcable.fitting.arrays import arrays_of
from lumpedcable.fitting.axes import axes_reached, axes_seen, changed_scenes
from lumpedcable.fitting.residual import predict
from lumpedcable.fitting.run import fit_problem
from lumpedcable.fitting.scalar import read_scalar
from lumpedcable.fitting.sensitivity import scalar_slopes
from lumpedcable.model.coordinates import coordinates_of
from lumpedcable.scene import SceneError

# a wire in the plane of x and z, 22 m long between ends 20 m apart at the same height
HUNG = """
gravity = 9.81
[materials.wire]
law = "linear"
EA = "1 MN"
[lines.rope]
material = "wire"
length = 22
segments = 4
mass = 2
start = { fixed = [0, 0, 0] }
end = { fixed = [20, 0, 0] }
[output]
"""
MOVING = HUNG + "duration = 0.02\nevery = 0.01\n"
ASLANT = HUNG.replace("[20, 0, 0]", "[12, 16, 0]")
WATER = "[water]\ndensity = 1025\ncurrent = { velocity = [1, 0, 0] }\n"
DRAG = "diameter = 0.03\ndrag = { normal = 1, tangential = 0 }"
DRAGGED = HUNG.replace("mass = 2", f"mass = 2\n{DRAG}") + WATER
END = "lines.rope.end.fixed"


@pytest.mark.parametrize(
    ("text", "key", "dimensions"),
    [
        (HUNG, f"{END}.0", 2),
        (HUNG, f"{END}.1", 3),
        (HUNG, f"{END}.2", 2),
        (HUNG, "materials.wire.EA", 2),
        (DRAGGED, "water.current.velocity.0", 2),
        (DRAGGED, "water.current.velocity.1", 3),
        (ASLANT, f"{END}.0", 3),
        (ASLANT, f"{END}.2", 2),
        (ASLANT, "lines.rope.mass", 2),
        # upright and taut, also where it would be slack as long as it may become
        (HUNG.replace("[20, 0, 0]", "[0, 0, -22.1]"), "lines.rope.length", 1),
        (HUNG.replace("[20, 0, 0]", "[0, 0, -22.1]"), f"{END}.2", 1),
        (HUNG.replace("[20, 0, 0]", "[0, 0, -22.1]"), f"{END}.0", 2),
        # however large the numbers are, and however small beside the others of their vector
        (HUNG.replace("[20, 0, 0]", "[1e308, 0, 0]"), f"{END}.1", 3),
        (HUNG.replace("[20, 0, 0]", "[1e9, 1e-6, 0]"), f"{END}.1", 3),
    ],
)
def test_the_axes_hold_a_free_number_and_no_more(tmp_path, text, key, dimensions):
    scene = study_of(tmp_path, text).scene
    assert coordinates_of([scene], changed_scenes(scene, [key])).dimensions == dimensions


def test_what_is_alike_on_both_sides_of_a_plane_needs_no_more_axes(tmp_path):
    scene, keys = study_of(tmp_path, HUNG).scene, [f"{END}.{k}" for k in range(3)]
    found = [axes_seen(scene, keys, component).dimensions for component in (None, 0, 1, 2)]
    assert found == [2, 2, 3, 2]
    assert axes_seen(scene, keys[::2], 1).dimensions == 2
    # along x and y it lies aslant; the scene's own dimensions are for the scene
    scene = study_of(tmp_path, ASLANT, "dimensions=2").scene
    found = [axes_seen(scene, keys, component).dimensions for component in (None, 0, 1, 2)]
    assert found == [2, 3, 3, 2]


UPRIGHT = HUNG.replace("[20, 0, 0]", "[0, 0, -22.1]")


@pytest.mark.parametrize(
    ("text", "keys", "dimensions"),
    [
        (HUNG, [f"{END}.0", "lines.rope.mass"], 2),
        (HUNG, [f"{END}.0", f"{END}.1"], 3),
        (DRAGGED, ["water.current.velocity.1"], 3),
        # at other values it may be slack
        (UPRIGHT, ["lines.rope.length"], 2),
        (UPRIGHT, [f"{END}.2"], 2),
        (UPRIGHT, ["materials.wire.EA", "lines.rope.mass"], 1),
        (f"dimensions = 1\n{UPRIGHT}", ["lines.rope.length"], 1),
        (UPRIGHT.replace("gravity = 9.81\n", ""), ["lines.rope.length", f"{END}.2"], 1),
    ],
)
def test_the_axes_hold_all_that_numbers_can_come_to_and_no_more(tmp_path, text, keys, dimensions):
    assert axes_reached(study_of(tmp_path, text).scene, keys).dimensions == dimensions


@pytest.mark.parametrize(("text", "component"), [(MOVING, 1), (ASLANT, 0)])
@pytest.mark.slow
def test_the_middle_of_a_wire_follows_its_ends_out_of_the_plane(tmp_path, text, component):
    study, keys = study_of(tmp_path, text), tuple(f"{END}.{k}" for k in range(2))
    scalar = read_scalar(f"last position at rope@11m in {'xyz'[component]}", study.scene)
    values = np.array([study.scene.numbers()[key] for key in keys])
    value, _, slopes = scalar_slopes(study, scalar, keys, values)
    # between ends of one height it hangs alike towards both, whichever way they are apart
    assert value == pytest.approx(0.5 * values[component], abs=1e-9)
    assert slopes == pytest.approx(0.5 * np.eye(2)[component], abs=1e-9)


# a string without weight, taut: T = EA (d/L - 1)
LENGTH, PULLED_TO = 19.0, 15.0
STRING = (
    HUNG.replace("gravity = 9.81\n", "").replace("length = 22", f"length = {LENGTH}")
    .replace("[20, 0, 0]", "[12, 16, 0]").replace("segments = 4", "segments = 1")
)  # fmt: skip
FIT = f"""
scene = "scene.toml"
[free]
"{END}.0" = {{ low = 5, high = 17 }}
[experiments.a]
file = "a.csv"
time = {{ column = "t" }}
observe = [{{ quantity = "tension", at = "rope.start", column = "T", noise = 1000 }}]
[method]
starts = 1
"""


def tension(x):
    """Tension (N) of the string with its end at x (m)."""
    return 1e6 * (np.hypot(x, 16.0) / LENGTH - 1.0)


def write_tensions(folder):
    T = tension(PULLED_TO)
    (folder / "a.csv").write_text(f"t,T\n0.01,{float(T)!r}\n0.02,{float(T)!r}\n")


@pytest.mark.slow
def test_a_fit_moves_the_end_of_a_line_aslant(tmp_path):
    write_tensions(tmp_path)
    spec, arrays = arrays_of(fit_of(tmp_path, FIT, STRING).problem)
    said = jax.jit(predict, static_argnums=0)
    for x in (11.0, 12.0, PULLED_TO):
        (model,) = np.asarray(said(spec, arrays, np.array([x])).groups[0])[0]
        assert model == pytest.approx(np.full(2, tension(x)), rel=1e-9)


@pytest.mark.slow
def test_a_fit_finds_the_end_of_a_line_aslant(tmp_path):
    write_tensions(tmp_path)
    found = fit_problem(fit_of(tmp_path, FIT, STRING).problem)
    assert found.values == pytest.approx([PULLED_TO], rel=1e-9)


def test_free_numbers_that_lead_out_of_the_dimensions_asked_for_are_refused(tmp_path):
    write_tensions(tmp_path)
    problem = fit_of(tmp_path, FIT, f"dimensions = 1\n{STRING}").problem
    with pytest.raises(SceneError, match="dimensions: expected at least 2"):
        fit_problem(problem)


@pytest.mark.slow
def test_a_response_moves_the_end_of_a_string_anywhere(tmp_path):
    path = tmp_path / "string.toml"
    path.write_text(STRING)
    found = lc.response(path, [f"{END}.{k}" for k in range(3)], "max tension at rope.end")
    for x in ([12.0, 16.0, 0.0], [3.0, -4.0, 21.0], [0.0, 0.0, -20.0]):
        far = np.linalg.norm(x)
        value, slopes = jax.value_and_grad(found)(np.array(x))
        assert value == pytest.approx(1e6 * (far / LENGTH - 1.0), rel=1e-9)
        assert slopes == pytest.approx(1e6 / LENGTH * np.array(x) / far, abs=1e-3)


PULL = 30e3
FAR = LENGTH * (1.0 + PULL / 1e6)  # where the end is then
PULLED = (
    STRING.partition("end = ")[0]
    + f"end = {{ held = {{ pretension = {PULL}, direction = [1, 0, 0] }} }}\n[output]\n"
)


def test_a_fit_turns_a_pull_at_its_strength(tmp_path):
    (tmp_path / "a.csv").write_text("t,y\n0.01,5\n0.02,5\n")
    text = FIT.replace(f"{END}.0", "lines.rope.end.held.direction.1").replace("5, high = 17", "-9")
    seen = 'quantity = "position", at = "rope.end", component = "y", column = "y"'
    text = text.replace('quantity = "tension", at = "rope.start", column = "T"', seen)
    spec, arrays = arrays_of(
        fit_of(tmp_path, text, PULLED + STRING.partition("[output]")[2]).problem
    )
    said = jax.jit(predict, static_argnums=0)
    for y in (0.75, -2.4):
        (model,) = np.asarray(said(spec, arrays, np.array([y])).groups[0])[0]
        assert model == pytest.approx(np.full(2, FAR * y / np.hypot(1.0, y)), rel=1e-9)


def test_a_response_turns_a_pull_at_its_strength(tmp_path):
    place = tmp_path / "pulled.toml"
    place.write_text(PULLED)
    found = lc.response(place, ["direction.0", "direction.1"], "last position at rope.end in y")
    for x in ([1.0, 0.0], [3.0, 4.0], [0.1, -0.1]):
        value, slopes = jax.value_and_grad(found)(np.array(x))
        # y = FAR x1 / |x|, and so its slopes
        size = np.hypot(x[0], x[1])
        assert value == pytest.approx(FAR * x[1] / size, rel=1e-9, abs=1e-12)
        wanted = FAR / size**3 * np.array([-x[0] * x[1], x[0] ** 2])
        np.testing.assert_allclose(slopes, wanted, rtol=1e-9, atol=1e-9)


@pytest.mark.slow
def test_a_response_to_a_current_across_is_that_of_a_run(tmp_path):
    path, key = tmp_path / "dragged.toml", "water.current.velocity"
    short = {"output.duration": 0.01, "output.every": 0.01}
    path.write_text(DRAGGED)
    found = lc.response(path, [f"{key}.0", f"{key}.1"], "last position at rope@11m in y", short)
    for x in ([1.0, 0.0], [0.5, 2.0]):
        ran = lc.run(path, short | {key: [*x, 0.0], "dimensions": 3}).line("rope")
        middle = float(ran.position.isel(run=0, time=-1, node=2, xyz=1))
        assert float(found(x)) == pytest.approx(middle, rel=1e-9, abs=1e-9)


@pytest.mark.slow
def test_a_response_of_an_upright_line_that_becomes_slack_is_that_of_a_run(tmp_path):
    path, key = tmp_path / "upright.toml", "lines.rope.length"
    path.write_text(UPRIGHT)
    found = lc.response(path, [key], "last tension at rope.start")
    ran = lc.run(path, {key: 24.0}).line("rope")
    assert float(found([24.0])) == pytest.approx(float(ran.start_tension[0, -1]), rel=1e-9)


def test_a_response_that_leads_out_of_the_dimensions_asked_for_is_refused(tmp_path):
    path = tmp_path / "flat.toml"
    path.write_text(f"dimensions = 2\n{HUNG}")
    told = f"dimensions: expected at least 3, .* found 2 where {END}.1 vary"
    with pytest.raises(SceneError, match=told):
        lc.response(path, [f"{END}.1"])

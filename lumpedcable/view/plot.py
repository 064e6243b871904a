"""Draws all the figures a results file calls for."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import chain, count
from pathlib import Path

from matplotlib.figure import Figure

from lumpedcable.results.errors import ResultError
from lumpedcable.results.reader import ResultFile
from lumpedcable.results.sound import SoundFile
from lumpedcable.view import style
from lumpedcable.view.bodies import body_figure, has_payout, payout_figure
from lumpedcable.view.energy import energy_figure
from lumpedcable.view.general import end_tension_figure, has_end_tension, shape_figure
from lumpedcable.view.groups import Group, alone, file_tag, groups
from lumpedcable.view.maps import ENOUGH, FEWEST, map_figures
from lumpedcable.view.measures import MOST_BARS, bars_figure, measure_figure
from lumpedcable.view.moments import has_moments, moment_figure
from lumpedcable.view.ranges import has_range, range_figure
from lumpedcable.view.recoil import (
    end_displacement_figure,
    end_speed_figure,
    tension_figure,
    velocity_figure,
    xt_figure,
)
from lumpedcable.view.rest import rest_figure
from lumpedcable.view.sampling import RecoilingEnd
from lumpedcable.view.swept import swept_figure, swept_planes

Draw = Callable[[], Figure]


def plot_result(
    path: str | Path,
    outdir: str | Path,
    formats: Sequence[str] = ("png",),
    run: int | None = None,
) -> list[Path]:
    """Draw the figures of a results file, finished or not.

    Where a line parts: tension and velocity along it, speed and way of the broken end, the x-t
    diagram, and what it sweeps, from the side and from above, unless it recoils along itself;
    otherwise tension at the ends, also where none is kept along it, and shapes. Of lines that do not
    part the range of the tension along them, of lines that bend their bending moments, of those on
    winches what is paid out. Energies always. Of a scene at rest: the shape of each cable with its
    numbers, and moments. Figures whose fields the file does not hold are left out. A run that went
    wrong is drawn until then. Where several numbers are swept there is one set of figures for each
    value of the last, and its name ends in that value: tension_break_time_5ms.png. Where two or more
    of them take three values or more, or of enough draws: maps of the numbers of the runs over every
    pair.

    Args:
        path: the results file, or the folder of a study.
        outdir: folder for the figures, made if it does not exist.
        formats: any of "png", "pdf", "svg".
        run: this run alone, from 0, without what compares runs; its number ends the names of the files,
            tension_run_3.png, where there are others. All if None.

    Returns:
        The files made.

    Raises:
        ResultError: the file cannot be read, has no such run, or holds nothing to draw.
        OutputError: the figures cannot be written there, or not in that format.
    """
    folder = Path(outdir)
    made: list[Path] = []
    with SoundFile.open(path) as result:
        if run is not None:
            result.hold(run)
        style.ready(folder, formats)
        for name, draw in _every(result, run):
            made += style.save(draw, folder / name, formats)
    if not made:
        raise _nothing(path)
    return made


def figures_of(path: str | Path) -> dict[str, Figure]:
    """The figures of a results file by the names that `plot_result` gives their files.

    Raises:
        ResultError: the file cannot be read, or holds nothing to draw.
    """
    with SoundFile.open(path) as result, style.styled():
        made = {name: style.literal(draw()) for name, draw in _every(result, None)}
    if not made:
        raise _nothing(path)
    return made


def _every(result: SoundFile, run: int | None) -> Iterator[tuple[str, Callable[[], Figure]]]:
    """Names of files without endings, no two alike, and makers of figures, of all runs or one."""
    used: set[str] = set()

    def other(name: str) -> str:
        """The name, or with a number what would be that of another figure."""
        names = chain([name], (f"{name}_{k}" for k in count(2)))
        free = next(one for one in names if one not in used)
        used.add(free)
        return free

    for name, draw in _whole_figures(result) if run is None else ():
        yield other(name), draw
    some = groups(result) if run is None else [alone(result, run)]
    for group in some if _has_histories(result) else ():
        for name, draw in _figures(result, group):
            yield other("_".join(filter(None, [name, group.tag]))), draw


def _nothing(path: str | Path) -> ResultError:
    return ResultError(
        f"{path} holds neither histories nor a sweep to draw; a map needs two swept numbers of "
        f"{FEWEST} values or more each, or {ENOUGH} draws"
    )


def _whole_figures(result: ResultFile) -> Iterator[tuple[str, Draw]]:
    """Names and makers of the figures that show all runs at once."""
    yield from map_figures(result)
    for name in result.measured if 1 < result.runs <= MOST_BARS else ():
        yield f"bars_{file_tag(name)}", partial(bars_figure, result, name)


def _has_histories(result: ResultFile) -> bool:
    """Whether anything but numbers of whole runs is kept."""
    fields = any(result.line(name).fields for name in result.lines)
    return fields or bool(result.energy_terms) or bool(result.bodies) or bool(result.measures())


def _figures(result: SoundFile, group: Group) -> Iterator[tuple[str, Draw]]:
    """Names and makers of the figures of one group, as far as the file holds their fields."""
    for cable in result.cables:
        which = f"_{file_tag(cable)}" if len(result.cables) > 1 else ""
        yield f"rest{which}", partial(rest_figure, result, cable, group)
    bent = [name for name in result.lines if has_moments(result.line(name))]
    if bent:
        yield "bending_moment", partial(moment_figure, result, bent, group)
    if result.cables:
        return  # what does not move has no history
    ends = [RecoilingEnd(result, name) for name in result.ends]
    for end in ends:
        which = f"_{file_tag(end.name)}" if len(ends) > 1 else ""
        tension, velocity = end.line.has("tension"), end.line.has("velocity")
        if tension:
            yield f"tension{which}", partial(tension_figure, result, end, group)
        if velocity and end.line.has("position"):
            yield f"velocity{which}", partial(velocity_figure, result, end, group)
        if end.has_speed:
            yield f"end_speed{which}", partial(end_speed_figure, result, end, group)
        if end.has_place:
            draw = partial(end_displacement_figure, result, end, group)
            yield f"end_displacement{which}", draw
        if tension:
            yield f"xt{which}", partial(xt_figure, result, end, group)
    lines = [result.line(name) for name in result.lines]
    seen = [line for line in lines if line.has("position") and line.has("velocity")]
    for name, plane in swept_planes(seen, group).items() if ends and seen else ():
        yield name, partial(swept_figure, result, seen, plane, group)
    along = any(end.line.has("tension") for end in ends)
    if not along and any(has_end_tension(line) for line in lines):
        yield "end_tension", partial(end_tension_figure, result, group)
    parting = {end.line.name for end in ends}
    whole = [line.name for line in lines if has_range(line) and line.name not in parting]
    if whole:
        yield "tension_range", partial(range_figure, result, whole, group)
    if not ends and any(line.has("position") for line in lines):
        yield "shape", partial(shape_figure, result, group)
    for name in (name for name in result.lines if has_payout(result.line(name))):
        yield f"payout_{file_tag(name)}", partial(payout_figure, result, name, group)
    for name in result.bodies:
        yield f"body_{file_tag(name)}", partial(body_figure, result, name, group)
    for name in result.measures():
        yield f"measure_{file_tag(name)}", partial(measure_figure, result, name, group)
    if result.energy_terms:
        yield "energy", partial(energy_figure, result, group)

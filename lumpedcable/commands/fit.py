"""Commands that learn from data and tell what depends on what: fit, sensitivity."""

from __future__ import annotations

from pathlib import Path

from lumpedcable.commands.console import (
    Formats,
    OneRun,
    Output,
    Set,
    Timed,
    checked,
    fail,
    study_of,
    told,
)
from lumpedcable.timings import Timings, command_timings

__all__ = ["fit", "sensitivity"]


def fit(
    file: Path,
    /,
    *,
    output: Output = None,
    format_: Formats = None,
    timings: Timed = False,
) -> None:
    """Find numbers of a scene from measurements, and say how sure they are.

    Prints a table, writes the fitted scene (ready for run), the numbers (fit.json) and pictures. The
    exit code is 1 where no search came to its end.

    Parameters
    ----------
    file
        Fit file (TOML): a scene, its free numbers, experiments with their data.
    output
        Folder for what is made; the file's name in this folder if not given.
    format_
        png (default), svg or pdf; may be given several times.
    timings
        Print the wall time of each stage, from the start of the command.
    """
    clock = command_timings()
    from lumpedcable.fitting.load import load_fit
    from lumpedcable.study.compiling import heard

    clock.mark("load")
    with told():
        study = load_fit(file)
    folder, formats = checked(output or Path(file.stem)), tuple(format_ or ["png"])
    clock.mark("read")

    with heard(clock):
        found = (_fit_ropes if study.ropes else _fit_one)(study, folder, formats, clock)
    if timings:
        print(*clock.lines(), sep="\n")
    if not found:
        raise SystemExit(1)


def _fit_one(study, folder: Path, formats: tuple[str, ...], clock: Timings) -> bool:
    """The fit of a `FitStudy` of one rope; whether its search came to its end."""
    from lumpedcable.fitting.report import print_fit
    from lumpedcable.fitting.whole import fit_study
    from lumpedcable.fitting.write import pictures_of, write_fit
    from lumpedcable.view import plot_fit
    from lumpedcable.view.fit import pictures_from

    with told():
        fitted, others = fit_study(study)
        clock.mark("fit")
        print_fit(fitted, others)
        made, wrong = write_fit(fitted, others, folder)
        made += plot_fit(pictures_from(pictures_of(fitted)), folder, formats)
    for message in wrong:
        print(f"the fitted scene cannot be run as it is: {message}")
    for path in made:
        print(path)
    clock.mark("tell")
    return fitted.converged


def _fit_ropes(study, folder: Path, formats: tuple[str, ...], clock: Timings) -> bool:
    """The same fit to every rope of a `FitStudy`; whether all searches came to their end."""
    from lumpedcable.fitting.profile import with_profiles
    from lumpedcable.fitting.report import print_ropes
    from lumpedcable.fitting.ropes import fit_ropes
    from lumpedcable.fitting.write import pictures_of, ropes_picture, write_ropes
    from lumpedcable.view import plot_fit
    from lumpedcable.view.fit import pictures_from, plot_ropes

    with told():
        fits = fit_ropes(study.ropes)
        if len(fits) == 1:
            fits = {name: with_profiles(fitted) for name, fitted in fits.items()}
        clock.mark("fit")
        print_ropes(fits, study.problem.title)
        made, wrong = write_ropes(fits, folder)
        picture = ropes_picture(fits, study.problem.title)
        made += plot_ropes(**picture, folder=folder, formats=formats)
        if len(fits) == 1:  # of many it would be thousands
            for name, fitted in fits.items():
                made += plot_fit(pictures_from(pictures_of(fitted)), folder / name, formats)
    for message in wrong:
        print(f"the fitted scene cannot be run as it is: {message}")
    for path in made:
        print(path)
    clock.mark("tell")
    return all(fitted.converged for fitted in fits.values())


def sensitivity(
    scene: Path,
    /,
    *,
    of: str | None = None,
    output: Output = None,
    set_: Set = None,
    run_: OneRun = 0,
    format_: Formats = None,
) -> None:
    """Tell what a result depends on: its derivative by every number of the scene.

    Prints a table, draws bars (sensitivity.png) and writes the numbers (sensitivity.json). The exit
    code is 1 where the run fails.

    Parameters
    ----------
    scene
        Scene file (TOML).
    of
        The result: max, min, mean, std, first or last; tension, velocity, displacement or position;
        at a place; in x, y or z. "max velocity at rope.end" is the peak speed of the end, and what is
        taken where that end breaks. "max displacement at ship" is the travel of a body. Or a measure of
        the scene, "min h_w"; or "stop time", when the body of output.stop comes to rest; or "peak
        tension at ship.bow", the largest of every step at the end of a rod.
    output
        Folder for picture and numbers; the scene's name in this folder if not given.
    set_
        KEY=VALUE: another value for any key of the scene.
    run_
        Which run of a sweep, from 0.
    format_
        png (default), svg or pdf; may be given several times.
    """
    study = study_of(scene, set_, run_)
    folder = checked(output or Path(scene.stem))

    from lumpedcable.fits import study_sensitivity
    from lumpedcable.fitting.scalar import AskedError

    with told():
        try:
            found = study_sensitivity(study, of, run_)
        except AskedError as error:
            fail(f"--of: {error}")
        made = found.plot(folder, tuple(format_ or ["png"])) + found.save(folder)
    found.report()
    for path in made:
        print(path)
    if found.status != "ok":
        raise SystemExit(1)

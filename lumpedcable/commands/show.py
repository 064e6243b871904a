"""Commands that show results to people and to other programs: plot, view, animate, export."""

from __future__ import annotations

from pathlib import Path

from lumpedcable.commands.console import (
    Formats,
    OneRun,
    Output,
    Set,
    SomeRun,
    Whole,
    bare_name,
    fail,
    study_of,
    told,
)

__all__ = ["animate", "export", "plot", "view"]


def plot(
    result: Path,
    /,
    *,
    output: Output = None,
    run_: SomeRun = None,
    format_: Formats = None,
) -> None:
    """Draw the pictures of a results file.

    Parameters
    ----------
    result
        Results file (HDF5), finished or .partial, or the folder of a study.
    output
        Folder for the pictures; the file's name without .h5, or the folder of the study, if not given.
    run_
        Draw this run alone, from 0.
    format_
        png (default), svg or pdf; may be given several times.
    """
    from lumpedcable.view import plot_result

    with told():
        folder = output or (result if result.is_dir() else result.parent / bare_name(result))
        for path in plot_result(result, folder, tuple(format_ or ["png"]), run_):
            print(path)


def view(
    file: Path,
    /,
    *,
    output: Output = None,
    set_: Set = None,
    run_: SomeRun = None,
    port: Whole = 0,
    browser: bool = True,
) -> None:
    """Open a page: the moving scene of a results file, or a scene at rest that follows its sliders.

    Parameters
    ----------
    file
        Results file (HDF5), finished or .partial, the folder of a study, or scene file (TOML).
    output
        Of a results file: HTML file to write instead; it has everything in it and works offline.
    set_
        Of a scene: KEY=VALUE, another value for any key.
    run_
        Which run, from 0: the one at rest, or the one that a results file opens with; the first if not
        given.
    port
        Of this machine's own address 127.0.0.1; a free one if not given.
    browser
        Open the page, or only say where it is.
    """

    def say(url: str) -> None:
        print(f"{url}  (Ctrl-C to end)", flush=True)

    is_scene = file.suffix == ".toml"
    if is_scene and output is not None:
        fail(f"--output: expected a results file to write as a page, found the scene {file}")
    if not is_scene and set_:
        fail(f"--set: expected a scene (*.toml), found {file}")
    study = study_of(file, set_, run_ or 0) if is_scene else None

    from lumpedcable.page.open import serve_recorded, serve_scene, write_recorded

    with told():
        if study is not None:
            serve_scene(study, run_ or 0, port, browser, say)
        elif output is not None:
            print(write_recorded(file, output, run_))
        else:
            serve_recorded(file, run_, port, browser, say)


def animate(
    result: Path,
    /,
    *,
    output: Output = None,
    run_: OneRun = 0,
    seconds: float = 8.0,
    fps: Whole = 15,
) -> None:
    """Write a run as a film: the line coloured by tension, and its tension along it.

    Parameters
    ----------
    result
        Results file (HDF5), finished or .partial, or the folder of a study.
    output
        File to write, *.gif or (with the extra video) *.mp4; the results' name with .gif if not given.
    run_
        Which run, from 0.
    seconds
        How long the film lasts, in s.
    fps
        Frames in a second.
    """
    from lumpedcable.page.filmed import beside_lines
    from lumpedcable.view import animate_result

    with told():
        target = output or result.parent / f"{bare_name(result)}.gif"
        print(animate_result(result, target, run_, seconds, fps, beside_lines))


def export(
    result: Path,
    /,
    *,
    to: str,
    output: Output = None,
    run_: SomeRun = None,
) -> None:
    """Write a results file in the format of other programs.

    Parameters
    ----------
    result
        Results file (HDF5), finished or .partial, or the folder of a study.
    to
        vtkhdf (ParaView), gltf (Blender, browsers), csv (histories; where none are kept, the numbers
        that sum up each run), moordyn (text tables).
    output
        File to write; the results' name with the format's own end if not given.
    run_
        Which run, from 0; the first if not given, for csv all.
    """
    from lumpedcable.export import export_result

    with told():
        for path in export_result(result, to, output, run_):
            print(path)

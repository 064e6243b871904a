"""Pages written and served: what `lumpedcable view` does."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from lumpedcable.page.document import document, save
from lumpedcable.page.recorded import recorded
from lumpedcable.results.errors import OutputError
from lumpedcable.results.target import check_folder, followed

if TYPE_CHECKING:
    from lumpedcable.scene import Study

__all__ = ["serve_recorded", "serve_scene", "write_recorded"]


def write_recorded(result: Path, target: Path, run: int | None = None) -> Path:
    """Write the page of a results file, with everything in it.

    Raises:
        ResultError: the file cannot be read or shows nothing.
        OutputError: the page cannot be written there.
    """
    check_folder(followed(target).parent, target)
    payload = recorded(result, run)
    if target.is_dir():
        raise OutputError(f"--output: expected a file name, found the folder {target}")
    if target.exists() and os.path.samefile(target, result):
        raise OutputError(f"--output: expected another file than the results, found {target}")
    save(document(payload, payload.pack.text()), target)
    return target


def serve_scene(
    study: Study, run: int, port: int, browser: bool, on_start: Callable[[str], None]
) -> None:
    """Serve the live page of a scene on 127.0.0.1 until it is interrupted.

    Args:
        study: the scene as read.
        run: which run of its sweep.
        port: 0 for a free one.
        browser: open the page there.
        on_start: told the address when the page is there.

    Raises:
        SceneError: the scene cannot be laid out.
        OutputError: the extra is not installed, or the port is taken.
    """
    from lumpedcable.page.live import live_page
    from lumpedcable.page.server import application, serve

    serve(application(*live_page(study, run)), port, browser, on_start)


def serve_recorded(
    result: Path, run: int | None, port: int, browser: bool, on_start: Callable[[str], None]
) -> None:
    """Serve the page of a results file on 127.0.0.1 until it is interrupted.

    Args:
        result: the file, read once.
        run: the one that the page opens with; the first if None.
        port: 0 for a free one.
        browser: open the page there.
        on_start: told the address when the page is there.

    Raises:
        ResultError: the file cannot be read or shows nothing.
        OutputError: the extra is not installed, or the port is taken.
    """
    from lumpedcable.page.server import application, serve

    payload = recorded(result, run)
    text = document(payload, payload.pack.text())
    serve(application(text), port, browser, on_start)

"""Makes the gallery: every scene of `configs/` with a picture, run when the documentation is built.

A Sphinx extension. Pictures are kept in `_build/gallery` by the text of their scene, so that the next
build runs only what has changed. LUMPEDCABLE_GALLERY may name scenes, e.g. "peers/catenary", to run
no others.
"""

import hashlib
import os
import re
import shutil
import tempfile
import tomllib
from pathlib import Path

HERE = Path(__file__).parent
CONFIGS = HERE.parent / "configs"
KEPT = HERE / "_build" / "gallery"
PAGE = HERE / "gallery.md"
HEAD = """\
# Gallery

Every scene of `configs/`, as it is, with one of the pictures that `lumpedcable plot` draws of it. Run
one with `lumpedcable run configs/NAME.toml`, a fit (`configs/fit/`) with `lumpedcable fit`, a study
(`configs/studies/`) with `lumpedcable study`; see it move with `lumpedcable view`. The pictures of the
three largest sweeps are of a part of their runs.
"""
# of the figures of a run, the one that shows most; the first of these that there is
BEST = ("rest", "measure", "body_ship", "xt", "shape", "end_tension", "map_reach", "energy")
# where another one shows more
PICKED = {
    "hard/light-in-current": "velocity",
    "hard/snap": "end_tension",
    "hard/stiff-bending": "velocity",
    "highline/span5": "shape",
    "peers/chain-in-waves": "end_tension",
    "peers/chain-mooring": "tension_range",
    "peers/pendulum": "velocity",
    "studies/restraint-envelope": "map_stop_distance",
    "surface/buoy": "measure_pull",
    "surface/deck-line": "end_speed",
    "three-lines": "swept_above",
}
# of what takes minutes, a part: what is written there, and what instead
LESS = {
    "highline/transfer-chances": {"count = 256": "count = 8"},
    "studies/restraint-envelope": {"count = 4096": "count = 64"},
    "studies/snapback-map": {
        '{ from = "5.4 m", to = "54 m", step = "5.4 m" }': '["18 m", "36 m"]',
        "count = 10": "count = 5",
    },
}


def scenes(folder=CONFIGS):
    """Names and paths of all scenes and fits."""
    paths = sorted(folder.rglob("*.toml"))
    return {path.relative_to(folder).with_suffix("").as_posix(): path for path in paths}


def about(path):
    """The title of a scene and the comment at its head."""
    text = path.read_text()
    comment = re.match(r"(?:#.*\n)*", text)[0]
    words = " ".join(line.lstrip("# ").rstrip() for line in comment.splitlines())
    return tomllib.loads(text).get("title", path.stem), words


def picture(path, folder=KEPT, name=""):
    """A picture of a scene or a fit: run and drawn, or from the last build."""
    # a file beside it, such as a recorded motion, belongs to the scene
    beside = sorted(p for p in path.parent.iterdir() if p.suffix == ".csv")
    told = repr((LESS.get(name), PICKED.get(name))).encode()
    parts = [told, *(p.read_bytes() for p in [path, *beside])]
    digest = hashlib.sha256(b"".join(parts)).hexdigest()[:16]
    kept = folder / f"{path.stem}-{digest}.png"
    if not kept.exists():
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory() as made:
            drawn = _of_fit if "lines" not in tomllib.loads(path.read_text()) else _of_scene
            shutil.copy(drawn(path, Path(made), name), kept)
    return kept


def part_of(path, folder, name):
    """The scene itself, or a file in `folder` with what is computed of it in reasonable time."""
    if name not in LESS:
        return path
    text = path.read_text()
    for whole, part in LESS[name].items():
        assert whole in text, f"{path}: no {whole!r}"
        text = text.replace(whole, part)
    made = folder / path.name
    made.write_text(text)
    return made


def _of_scene(path, folder, name):
    """The figure that shows most of a run."""
    import lumpedcable as lc

    figures = lc.run(part_of(path, folder, name)).figures()
    order = [PICKED[name]] if name in PICKED else BEST
    best = next((n for kind in order for n in sorted(figures) if n.startswith(kind)), min(figures))
    figures[best].savefig(folder / "one.png", dpi=120)
    return folder / "one.png"


def _of_fit(path, folder, name):
    """The first figure of a fit: what was measured and what the fit makes of it."""
    from lumpedcable.fitting.load import load_fit
    from lumpedcable.fitting.run import fit_problem
    from lumpedcable.fitting.write import pictures_of
    from lumpedcable.view import plot_fit
    from lumpedcable.view.fit import pictures_from

    fitted = fit_problem(load_fit(path).problem)
    return plot_fit(pictures_from(pictures_of(fitted)), folder, ("png",))[0]


def write(app=None):
    """Write the page and its pictures."""
    asked = os.environ.get("LUMPEDCABLE_GALLERY")
    parts = [HEAD]
    target = HERE / "images" / "gallery"
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir(parents=True)
    for name, path in scenes().items():
        title, words = about(path)
        parts.append(f"## {title}\n\n`configs/{name}.toml`. {words}\n")
        if asked is None or name in asked.split():
            made = shutil.copy(picture(path, name=name), target / f"{name.replace('/', '-')}.png")
            parts.append(f"![{title}](images/gallery/{Path(made).name})\n")
    PAGE.write_text("\n".join(parts))


def setup(app):
    """Called by Sphinx."""
    app.connect("builder-inited", write)
    return {"parallel_read_safe": True}

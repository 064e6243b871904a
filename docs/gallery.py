"""Makes the gallery: every scene of `configs/` with a picture, run when the documentation is built.

A Sphinx extension. Pictures are kept in `_build/gallery` by the text of their scene, so that the next
build runs only what has changed. LUMPEDCABLE_GALLERY may name scenes, e.g. "peers/catenary", to run
no others.
"""

import hashlib
import os
import re
import shutil
import tomllib
from pathlib import Path

HERE = Path(__file__).parent
CONFIGS = HERE.parent / "configs"
KEPT = HERE / "_build" / "gallery"
PAGE = HERE / "gallery.md"
HEAD = """\
# Gallery

Every scene of `configs/`, as it is, with one of the pictures that `lumpedcable plot` draws of it. Run one
with `lumpedcable run configs/NAME.toml`, see it move with `lumpedcable view`.
"""
# of the figures of a run, the one that shows most; the first of these that there is
BEST = ("xt", "rest", "shape", "tension", "end_tension", "energy")


def scenes(folder=CONFIGS):
    """Names and paths of all scenes, those of a fit or of a large study left out."""
    found = {}
    for path in sorted(folder.rglob("*.toml")):
        name = path.relative_to(folder).with_suffix("").as_posix()
        if "lines" in tomllib.loads(path.read_text()) and not name.startswith("studies/"):
            found[name] = path
    return found


def about(path):
    """The title of a scene and the comment at its head."""
    text = path.read_text()
    comment = re.match(r"(?:#.*\n)*", text)[0]
    words = " ".join(line.lstrip("# ").rstrip() for line in comment.splitlines())
    return tomllib.loads(text).get("title", path.stem), words


def picture(path, folder=KEPT):
    """A picture of a scene: run and drawn, or from the last build."""
    import lumpedcable as lc

    # a file beside it, such as a recorded motion, belongs to the scene
    beside = sorted(p for p in path.parent.iterdir() if p.suffix == ".csv")
    digest = hashlib.sha256(b"".join(p.read_bytes() for p in [path, *beside])).hexdigest()[:16]
    kept = folder / f"{path.stem}-{digest}.png"
    if not kept.exists():
        figures = lc.run(path).figures()
        names = sorted(figures)
        best = next(n for kind in BEST for n in names if n.startswith(kind))
        folder.mkdir(parents=True, exist_ok=True)
        figures[best].savefig(kept, dpi=120)
    return kept


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
            made = shutil.copy(picture(path), target / f"{name.replace('/', '-')}.png")
            parts.append(f"![{title}](images/gallery/{Path(made).name})\n")
    PAGE.write_text("\n".join(parts))


def setup(app):
    """Called by Sphinx."""
    app.connect("builder-inited", write)
    return {"parallel_read_safe": True}

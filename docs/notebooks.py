"""Runs the notebooks of the documentation and writes what came out into them: python docs/notebooks.py.

Names of some may follow. With --check nothing is written: texts that differ from those in the
notebooks are told, numbers in them compared to a part in a thousand, and the exit code is 1. Needs
the extra `docs`.
"""

import math
import re
import sys
from pathlib import Path

import nbformat
from nbclient import NotebookClient

ROOT = Path(__file__).parents[1]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")
CLOSE = 1e-3  # numbers on another processor are not the same to the last digit


def executed(path):
    """The notebook run anew, from its own folder as Jupyter does, without what changes at every run."""
    notebook = nbformat.read(path, as_version=4)
    told = {"metadata": {"path": str(path.parent)}}
    NotebookClient(notebook, timeout=300, kernel_name="python3", resources=told).execute()
    notebook.metadata = nbformat.from_dict(
        {"kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"}}
    )
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)
    return notebook


def texts(notebook):
    """By number of the cell: everything that it printed."""
    found = {}
    for k, cell in enumerate(notebook.cells):
        outputs = cell.get("outputs", ())
        printed = "".join(o.text for o in outputs if o.output_type == "stream")
        shown = [kind for o in outputs for kind in sorted(o.get("data", ()))]
        found[k] = "\n".join(filter(None, [printed, *shown]))
    return found


def same(told, now):
    """Whether two texts are the same but for the last digits of their numbers."""
    if NUMBER.sub("#", told) != NUMBER.sub("#", now):
        return False
    pairs = zip(map(float, NUMBER.findall(told)), map(float, NUMBER.findall(now)), strict=True)
    return all(math.isclose(a, b, rel_tol=CLOSE, abs_tol=1e-12) for a, b in pairs)


def differences(path):
    """What a notebook says and would say now, where the two differ."""
    told, now = texts(nbformat.read(path, as_version=4)), texts(executed(path))
    return [f"{path.name}, cell {k}:\n{told[k]}\nnow:\n{now[k]}"
            for k in told if not same(told[k], now[k])]  # fmt: skip


def main():
    """Run all, or compare."""
    names = [word for word in sys.argv[1:] if word != "--check"]
    chosen = [path for path in NOTEBOOKS if not names or path.stem in names]
    if "--check" in sys.argv:
        wrong = [text for path in chosen for text in differences(path)]
        sys.exit("\n".join([*wrong, "run: python docs/notebooks.py"]) if wrong else 0)
    for path in chosen:
        nbformat.write(executed(path), path)


if __name__ == "__main__":
    main()

"""docs/extending.md is right: its files and changes, put into a copy of the package, run its scene."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "extending.md").read_text()
BLOCK = re.compile(
    r"^```(\w+)\n# (?:(new|scene|run): )?([^\n]*)\n(.*?)^```", re.DOTALL | re.MULTILINE
)


def changed(text, change):
    """A text with the hunks of a change put in; each must fit in one place."""
    for hunk in change.split("...\n"):
        lines = hunk.splitlines(keepends=True)
        before = "".join(line[1:] for line in lines if line[0] in " -")
        after = "".join(line[1:] for line in lines if line[0] in " +")
        assert text.count(before) == 1, before
        text = text.replace(before, after)
    return text


def test_the_three_additions_work(tmp_path):
    shutil.copytree(ROOT / "lumpedcable", tmp_path / "lumpedcable")
    kinds = []
    for _, kind, name, block in BLOCK.findall(PAGE):
        kinds.append(kind)
        target = tmp_path / name
        if kind == "run":
            target = tmp_path / "run.py"
        elif not kind:
            block = changed(target.read_text(), block)
        else:
            assert not target.exists()
        target.write_text(block)
    assert len(kinds) == PAGE.count("\n```") // 2 == 13
    ran = subprocess.run(
        [sys.executable, "run.py"], cwd=tmp_path, capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
    )  # fmt: skip
    assert (ran.returncode, ran.stderr) == (0, "")

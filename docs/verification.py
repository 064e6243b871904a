"""Fills verification.md: every case of the tests' catalogue on three meshes, and what is left out.

python docs/verification.py (minutes)
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "verification.md"
BLOCK = re.compile(r"(<!-- catalogue -->\n).*?(<!-- end -->)", re.DOTALL)
LEFT_OUT = re.compile(r"(<!-- left out -->\n).*?(<!-- end -->)", re.DOTALL)
HEAD = [
    "| case | exact answer from | N | error, % | 2 N, % | 4 N, % | order |",
    "|---|---|---|---|---|---|---|",
]
sys.path[:0] = [str(ROOT), str(ROOT / "tests"), str(ROOT / "tests" / "catalogue")]


def row(name, case):
    """One line of the table: relative errors on three meshes, and the order of the last two."""
    import math

    meshes = [case.segments, 2 * case.segments, 4 * case.segments]
    if case.order is None:
        meshes = meshes[:1]
    errors = [case.error(case.play(segments=n).seen) for n in meshes]
    order = f"{math.log2(errors[1] / errors[2]):.1f}" if case.order else ""
    cells = [f"{100 * error:.2g}" for error in errors] + [""] * (3 - len(errors))
    return f"| {name} | {case.source} | {case.segments} | {' | '.join(cells)} | {order} |"


def main():
    """Run all cases and write the page."""
    from catalogue import CASES, excluded

    table = "\n".join([*HEAD, *(row(name, case) for name, case in CASES.items())])
    text = BLOCK.sub(lambda match: f"{match[1]}{table}\n{match[2]}", PAGE.read_text())
    text = LEFT_OUT.sub(lambda match: f"{match[1]}{excluded()}\n{match[2]}", text)
    PAGE.write_text(text)


if __name__ == "__main__":
    main()

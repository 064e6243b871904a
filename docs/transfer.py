"""How often the claims of transfer.md hold: python docs/transfer.py RESULTS.h5 [--write].

The results are those of configs/highline/transfer-chances.toml. With --write the shares go into the
page, beside a new picture.
"""

import re
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from lumpedcable.results import open_result
from lumpedcable.view.style import COLOURS

PAGE = Path(__file__).with_name("transfer.md")
IMAGES = PAGE.with_name("images")
BLOCK = re.compile(r"(<!-- claims -->\n).*?(<!-- end -->)", re.DOTALL)
HEAD = "| claim (section 2.2) | share | verdict |\n|---|---|---|\n"
CLASSES = [f"class {k}" for k in range(1, 6)]
DISTANCES = ["50 m", "55 m", "class 4", "65 m", "70 m", "75 m", "80 m"]
TENSIONS = ["70 m, 60 kN", "70 m, 70 kN", "70 m", "70 m, 90 kN", "70 m, 100 kN"]
LOW = 3.0  # m over the deck, the paper's limit
ROBUST = 5  # of `claims`, the first ones


def outcomes(path):
    """{case: {measure: values}} of a results file, draw for draw."""
    with open_result(path) as found:
        table, names = found.summary()["run"], np.array(found.cases)
        return {
            case: {name: table[name][names == case] for name in ("h_d", "h_w", "v_z")}
            for case in dict.fromkeys(names)
        }


def claims(found):
    """{claim: whether it holds in each draw} of what the paper concludes, the robust ones first."""

    def of(measure, cases):
        return np.array([found[case][measure] for case in cases])

    deck, water, climb = (of(name, CLASSES) for name in ("h_d", "h_w", "v_z"))
    far, taut = of("h_d", DISTANCES), of("h_d", TENSIONS)
    taut_water, taut_climb = of("h_w", TENSIONS), of("v_z", TENSIONS)
    near, wide, ways = far[:4], of("h_w", DISTANCES), of("v_z", DISTANCES)
    least = np.argmin(ways, axis=0)
    return {
        "class 5 comes below 3 m over the deck": deck[4] < LOW,
        "70 m in class 4 comes below 3 m": far[4] < LOW,
        "80, 90 and 100 kN at 70 m all stay below 3 m": np.all(taut[2:] < LOW, axis=0),
        "least height over water is lowest at 60 kN": np.argmin(taut_water, axis=0) == 0,
        "largest vertical speed rises with every class": np.all(np.diff(climb, axis=0) > 0, axis=0),
        "only class 5 comes below 3 m": np.all(deck[:4] >= LOW, axis=0) & (deck[4] < LOW),
        "below 70 m the deck is safe": np.all(near >= LOW, axis=0),
        "h_d falls with every class": np.all(np.diff(deck, axis=0) < 0.0, axis=0),
        "at 60 kN it comes to about 0 (below 0.5 m)": taut[0] < 0.5,
        "at 60 kN h_w is below 9 m": taut_water[0] < 9.0,
        "it is above 9 m in all cases of 80 kN": np.all(np.vstack([water, wide]) > 9.0, axis=0),
        "h_w falls with every class": np.all(np.diff(water, axis=0) < 0.0, axis=0),
        "h_w falls with every distance": np.all(np.diff(wide, axis=0) < 0.0, axis=0),
        "vertical speed is least neither at 50 m nor at 80 m": (least > 0)
        & (least < len(ways) - 1),
        "tension hardly changes vertical speed (within 10 %)": np.ptp(taut_climb, axis=0)
        < 0.1 * np.mean(taut_climb, axis=0),
    }


def verdict(share):
    """In words, of a share of draws."""
    if share >= 0.9:
        return "holds" if share >= 0.99 else "mostly holds"
    return "does not hold" if share <= 0.05 else "depends on periods and phases"


def draw(found):
    """What the draws come to in each case: nine in ten of them, half of them, and the middle one."""
    titles = {
        "h_d": "least height over the deck (m)",
        "h_w": "least height over water (m)",
        "v_z": "largest vertical speed (m/s)",
    }
    groups = (CLASSES, DISTANCES, TENSIONS)
    figure, rows = plt.subplots(3, 1, figsize=(7.0, 7.5), sharex=True, layout="constrained")
    for axes, (name, title) in zip(rows, titles.items(), strict=True):
        place, ticks, words = 0.0, [], []
        for colour, cases in zip(COLOURS, groups, strict=False):
            for case in cases:
                marks = np.nanquantile(found[case][name], [0.05, 0.25, 0.5, 0.75, 0.95])
                axes.plot([place] * 2, marks[[0, 4]], color=colour, linewidth=1.2)
                axes.plot([place] * 2, marks[[1, 3]], color=colour, linewidth=5.0)
                axes.plot(place, marks[2], "o", color="white", markeredgecolor=colour, markersize=4)
                ticks.append(place)
                words.append("60 m" if cases is DISTANCES and case == "class 4" else case)
                place += 1.0
            place += 1.0
        axes.set_ylabel(title)
        axes.grid(axis="y", alpha=0.25)
        words = [word.replace("70 m, ", "") for word in words]
        words[-3] = "80 kN"
        axes.set_xticks(ticks, words, rotation=60, ha="right", rotation_mode="anchor")
    for axes, limit in zip(rows, (LOW, 9.0), strict=False):
        axes.axhline(limit, color="0.3", linestyle="--", linewidth=0.8)
    figure.savefig(IMAGES / "transfer_chances.svg", metadata={"Date": None})


def main(path, write=False):
    """Print the table; or write it into the page and draw the picture."""
    found = outcomes(path)
    count = len(found["class 1"]["h_d"])
    rows = []
    for claim, holds in claims(found).items():
        share = np.mean(holds)
        # a share of so many draws is known to one standard deviation
        spread = np.sqrt(share * (1.0 - share) / count)
        shown = f"{100 * share:.0f} %" + (f" ± {100 * spread:.0f}" if spread > 0.005 else "")
        rows.append(f"| {claim} | {shown} | {verdict(share)} |\n")
    table = HEAD + "".join(rows)
    if not write:
        print(f"{count} draws\n\n{table}")
        return
    draw(found)
    PAGE.write_text(BLOCK.sub(lambda m: f"{m[1]}{table}{m[2]}", PAGE.read_text()))


if __name__ == "__main__":
    main(sys.argv[1], write="--write" in sys.argv[2:])

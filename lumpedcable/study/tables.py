"""What all tables for a person have in common: a console, their look, what is left out of them."""

import re
from collections.abc import Collection, Iterable, Sequence

from rich import box
from rich.console import Console, ConsoleOptions, JustifyMethod, RenderResult
from rich.measure import Measurement
from rich.table import Column, Table
from rich.text import Text

from lumpedcable.results.human import first_told
from lumpedcable.scene import Axis, Study, format_quantity

__all__ = [
    "MOST_ROWS",
    "WholeTable",
    "console_of",
    "fits_on",
    "new_table",
    "print_told",
    "rows_shown",
    "run_cells",
    "run_heads",
    "table_of",
]

MOST_ROWS = 60  # of a table; the file holds them all
MOST_NAMED = 4  # swept numbers with a column beside the name of their case
MOST_TOLD = 10  # different things that are told of runs
WIDE = 200  # columns where no terminal says how many there are
BOUNDLESS = 10_000


class WholeTable(Table):
    """A table of which a narrow console gets fewer columns, and never a part of a number.

    A column that may not break its lines is as wide as its widest cell, another one at least as its
    longest word. What is left out stands in a note below.

    Attributes:
        spare: columns in the order in which they are left out; None for all but the first, from
            the right.
        hidden: what is left out already, in words.
    """

    spare: Sequence[int] | None = None
    hidden: Sequence[str] = ()

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """The columns that there is room for, then the note."""
        kept, left_out = list(range(len(self.columns))), []
        some = self.spare
        spare = list(range(len(kept) - 1, 0, -1) if some is None else some)
        while (widths := self._widths(console, options, kept)) is None and spare:
            left_out.append(spare.pop(0))
            kept.remove(left_out[-1])
        yield self._part(kept, widths or [None] * len(kept))
        hidden = [*self.hidden, *(_words(self.columns[k]) for k in sorted(left_out))]
        if hidden:
            told = " and ".join(filter(None, [", ".join(hidden[:-1]), hidden[-1]]))
            yield Text(f"A wider terminal shows {told} as well.", "dim")

    def _widths(
        self, console: Console, options: ConsoleOptions, kept: Sequence[int]
    ) -> list[int] | None:
        """Widths of the columns kept with which no word is broken; None where there are none."""
        boundless = options.update(max_width=BOUNDLESS)
        least, widths = [], []
        for column in (self.columns[k] for k in kept):
            cells = [Measurement.get(console, boundless, c) for c in (column.header, *column.cells)]
            widths.append(max(cell.maximum for cell in cells))
            least.append(max(c.maximum if column.no_wrap else c.minimum for c in cells))
        bare = self._part(kept, [1] * len(kept)).__rich_measure__(console, boundless).maximum
        over = sum(widths) + bare - len(kept) - options.max_width
        while over > 0:
            loose = [k for k, width in enumerate(widths) if width > least[k]]
            if not loose:
                return None
            widths[max(loose, key=lambda k: widths[k])] -= 1
            over -= 1
        return widths

    def _part(self, kept: Sequence[int], widths: Sequence[int | None]) -> Table:
        part = Table(box=self.box, padding=self.padding, pad_edge=self.pad_edge)
        for k, width in zip(kept, widths, strict=True):
            column = self.columns[k]
            part.add_column(
                column.header, justify=column.justify, vertical=column.vertical, style=column.style,
                no_wrap=column.no_wrap, overflow="fold", width=width,
            )  # fmt: skip
        for row in zip(*(self.columns[k].cells for k in kept), strict=True):
            part.add_row(*row)
        return part


def _words(column: Column) -> str:
    """A heading in one line and without its unit."""
    words = re.sub(r"\n\([^()]*\)$", "", str(column.header))
    return words.replace("-\n", "").replace("\n", " ")


def console_of(wide: int | None = None) -> Console:
    """A console as wide as the terminal, or `wide`, else `WIDE`, where there is none."""
    console = Console(highlight=False, markup=False)
    if console.is_terminal:
        return console
    return Console(highlight=False, markup=False, width=WIDE if wide is None else wide)


def new_table(padding: int = 1) -> WholeTable:
    """A table without columns, with so many spaces between those to come."""
    return WholeTable(box=box.SIMPLE_HEAD, padding=(0, padding, 0, 0), pad_edge=False)


def table_of(
    heads: Sequence[str], left: Collection[int] = (0,), wrap: Collection[int] = ()
) -> WholeTable:
    """A table of columns to the right, but for those `left`; those of `wrap` may break their lines."""
    table = new_table(2)
    for k, head in enumerate(heads):
        justify = "left" if k in left else "right"
        table.add_column(Text(head), justify=justify, no_wrap=k not in wrap)
    return table


def fits_on(console: Console, table: Table) -> bool:
    """Whether the console is wide enough for all of a table."""
    boundless = console.options.update(max_width=BOUNDLESS)
    return console.measure(table, options=boundless).maximum <= console.width


def rows_shown(
    shown: int, all_: int, what: str = "rows", where: str = "the file holds"
) -> list[str]:
    """A note on rows left out, if there are any."""
    return [f"{shown} of {all_} {what} shown; {where} all."] if all_ > shown else []


def print_told(
    console: Console, told: Iterable[tuple[int, str]], rest: str = "went wrong", style: str = "red"
) -> None:
    """Print numbers of runs and what is told of them, the first few words, the `rest` by number."""
    said, more = first_told(told, MOST_TOLD, rest)
    for words in filter(None, (*said, more)):
        console.print(Text(words, style))


def run_heads(study: Study) -> list[tuple[str, JustifyMethod]]:
    """What stands over the first cells of a row, which tell of its run, and on which side they are."""
    heads: list[tuple[str, JustifyMethod]] = [("run", "right")]
    if study.runs.named:
        heads.append(("case", "left"))
    return heads + [(axis.label.replace(" ", "\n"), "right") for axis in _shown_axes(study)]


def run_cells(study: Study, run: int) -> list[str]:
    """The first cells of a row: the number of the run, the name of its case, and what is swept."""
    values = study.runs.values(run)
    name = [study.runs.name(run)] if study.runs.named else []
    swept = [format_quantity(values[axis.key], axis.unit) for axis in _shown_axes(study)]
    return [str(run), *name, *swept]


def _shown_axes(study: Study) -> list[Axis]:
    """The swept numbers that have a column; the name of a case stands for more than a few."""
    return [
        axis
        for factor in study.factors
        for axis in (() if factor.names and len(factor.axes) > MOST_NAMED else factor.axes)
    ]

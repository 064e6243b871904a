"""What all tables for a person have in common: a console, their look, what is left out of them."""

from collections.abc import Collection, Iterable, Sequence

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

__all__ = [
    "MOST_ROWS",
    "console_of",
    "fits_on",
    "new_table",
    "print_told",
    "rows_shown",
    "table_of",
]

MOST_ROWS = 60  # of a table; the file holds them all
MOST_TOLD = 10  # runs told one by one
WIDE = 200  # columns where no terminal says how many there are


def console_of(wide: int | None = None) -> Console:
    """A console as wide as the terminal, or `wide`, else `WIDE`, where there is none."""
    console = Console(highlight=False, markup=False)
    if console.is_terminal:
        return console
    return Console(highlight=False, markup=False, width=WIDE if wide is None else wide)


def new_table(padding: int = 1) -> Table:
    """A table without columns, with so many spaces between those to come."""
    return Table(box=box.SIMPLE_HEAD, padding=(0, padding, 0, 0), pad_edge=False)


def table_of(
    heads: Sequence[str], left: Collection[int] = (0,), wrap: Collection[int] = ()
) -> Table:
    """A table of columns to the right, but for those `left`; those of `wrap` may break their lines."""
    table = new_table(2)
    for k, head in enumerate(heads):
        justify = "left" if k in left else "right"
        table.add_column(Text(head), justify=justify, no_wrap=k not in wrap)
    return table


def fits_on(console: Console, table: Table) -> bool:
    """Whether the console is wide enough for all of a table."""
    boundless = console.options.update(max_width=10_000)
    return console.measure(table, options=boundless).maximum <= console.width


def rows_shown(
    shown: int, all_: int, what: str = "rows", where: str = "the file holds"
) -> list[str]:
    """A note on rows left out, if there are any."""
    return [f"{shown} of {all_} {what} shown; {where} all."] if all_ > shown else []


def print_told(
    console: Console, told: Iterable[tuple[int, str]], rest: str = "went wrong", style: str = "red"
) -> None:
    """Print numbers of runs and what is told of each, the first few one by one, the `rest` by number."""
    every = list(told)
    for run, message in every[:MOST_TOLD]:
        console.print(Text(f"run {run}: {message}", style))
    if len(every) > MOST_TOLD:
        console.print(Text(f"and {len(every) - MOST_TOLD} more runs {rest}", style))

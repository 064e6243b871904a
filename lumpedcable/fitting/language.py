"""The language of a fit file: which scene, which numbers are free, which data, how to fit."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, StrictBool, Tag

from lumpedcable.scene.part import Name, Part, Problem, Text, choose, tag
from lumpedcable.scene.quantities import Count, Fraction, PositiveNumber, fault, found

Setting = dict[Text, Any]
"""Values by key of the scene, as --set takes them."""


class Free(Part):
    """A number of the scene, or a list of numbers, that the data shall determine."""

    start: Any = None
    """Where the search begins. Absent: the scene's own value."""
    low: Any = None
    """It stays above. Absent: zero where the scene wants a positive number, else no bound."""
    high: Any = None
    """It stays below. Absent: no bound."""
    private: StrictBool = False
    """Every experiment has its own value, instead of one for all."""
    profile: StrictBool | None = None
    """Whether its interval is found by its profile. Absent: where the data hardly tell it."""
    smooth: PositiveNumber | None = None
    """For the tensions of a table: how much the slope may change from one interval to the next, as a
    share of the mean slope; it needs the noise of every column. Absent: as the data have it."""


class Column(Part):
    """A column of a data file."""

    column: Text
    """Its name in the header line."""
    unit: Text | None = None
    """Unit of its numbers. Absent: the one in brackets in its name, "force (kN)", else SI."""


class Observed(Column):
    """A column of a test's record, and what it is in the scene."""

    quantity: Literal["tension", "displacement", "velocity", "position"]
    """What was measured."""
    at: Text
    """Where: "LINE.start", "LINE.end", "LINE@DISTANCE" (unstretched, from the start), or a rigid
    body or a trolley."""
    component: Literal["x", "y", "z"] | None = None
    """Component of a displacement, velocity or position. Absent: its size; needed for position."""
    noise: Any = None
    """Standard deviation of the measurement: a number with a unit, or a percentage of the largest
    value in the column. Absent: found from what the fit leaves."""

    def problems(self) -> Iterator[Problem]:
        """Yield a component where there is none, or one that is missing."""
        if self.quantity == "tension" and self.component is not None:
            yield Problem(("component",), f'expected none for a tension, found "{self.component}"')
        if self.quantity == "position" and self.component is None:
            yield Problem(("component",), 'expected "x", "y" or "z" for a position, found nothing')


class TableExperiment(Part):
    """A bench's load-extension table: tensions of a material at given strains, or over a way of them."""

    material: Name
    """Name of the material, from the scene's [materials]."""
    file: Text
    """CSV file, relative to this file."""
    strain: Column
    """The column of strains."""
    tension: Column
    """The column of tensions."""
    time: Column | None = None
    """The column of times, which never fall: what relaxes in the material then depends on all rows
    before. Absent: slow loads, the law alone."""
    noise: Any = None
    """Standard deviation of the tensions: a number with a unit, or a percentage of the largest.
    Absent: found from what the fit leaves."""


class RecordExperiment(Part):
    """One run of the scene, and what was recorded of it over time."""

    file: Text
    """CSV file, relative to this file."""
    time: Column
    """The column of times, counted from the start of the run."""
    observe: Annotated[tuple[Observed, ...], Field(min_length=1)]
    """The columns with what was measured."""
    scene: Text | None = None
    """Another scene than the fit's, relative to this file."""
    set: Setting = Field(default_factory=dict)
    """Values of the scene in this experiment, by key: {"break.time" = "5 ms"}."""

    def problems(self) -> Iterator[Problem]:
        """Yield what is wrong with the observed columns."""
        for k, seen in enumerate(self.observe):
            for problem in seen.problems():
                yield Problem(("observe", k, *problem.path), problem.message)


def _pick(value: Any) -> str:
    if isinstance(value, TableExperiment):
        return "table"
    if isinstance(value, RecordExperiment):
        return "record"
    if not isinstance(value, dict):
        raise fault(f"expected {_KINDS}, found {found(value)}")
    table = {"material", "strain", "tension"} & set(value)
    return "table" if table and "observe" not in value else "record"


_KINDS = "a table with material, strain and tension, or with time and observe"

Experiment = Annotated[
    Annotated[TableExperiment, Tag(tag("table"))] | Annotated[RecordExperiment, Tag(tag("record"))],
    *choose(_pick, _KINDS),
]


class FitMethod(Part):
    """How the best values are looked for, and how sure of them one wants to be."""

    solver: Literal["levenberg-marquardt", "bfgs", "l-bfgs"] = "levenberg-marquardt"
    """The minimiser."""
    loss: Literal["squares", "huber", "cauchy"] = "squares"
    """What a deviation costs: huber and cauchy forgive outliers, and need the noise of every column."""
    threshold: PositiveNumber = 1.5
    """Deviation in standard deviations beyond which huber and cauchy forgive."""
    tolerance: PositiveNumber = 1e-8
    """Relative change of a value at which the search ends."""
    max_steps: Annotated[int, Count(1, 100_000)] = 200
    """Most steps of one search."""
    starts: Annotated[int, Count(1, 10_000)] | None = None
    """Number of searches: the first from the start values, the others from a random sample between
    the bounds. Absent: one, and where it ends badly up to 4 more from the best of 64 random places."""
    seed: Annotated[int, Count(0, 10**9)] = 0
    """Seed of that sample."""
    confidence: Fraction = 0.95
    """Probability of the intervals, less than 1."""

    def problems(self) -> Iterator[Problem]:
        """Yield a certainty, which no interval has."""
        # the upper end of the interval, of which there is then no quantile
        if 0.5 + 0.5 * self.confidence >= 1.0:
            told = ", which is 1 to rounding" if self.confidence < 1.0 else ""
            message = f"expected less than 1, found {self.confidence:.17g}{told}"
            yield Problem(("confidence",), message)


class Sampling(Part):
    """Draws from the distribution of the numbers, by Hamiltonian sampling (extra `sample`)."""

    draws: Annotated[int, Count(10, 1_000_000)] = 500
    """Draws of a chain that are kept."""
    warmup: Annotated[int, Count(10, 1_000_000)] = 300
    """Draws before them, in which the sampler finds its step."""
    chains: Annotated[int, Count(2, 1000)] = 4
    """Chains, each from another place."""
    accept: Fraction = 0.9
    """Share of proposals that are to be accepted: nearer to 1, smaller steps."""


class Choice(Part):
    """Another law for the same data: what is different in the scene, and what is free in it."""

    set: Setting
    """Values of the scene, by key: {"materials.nylon" = {law = "linear", EA = "1 MN"}}."""
    free: Annotated[dict[Text, Free], Field(min_length=1)]
    """Free numbers, instead of those in [free] that this scene does not have or `set` gives a value."""


def _names_or_all(value: Any) -> Any:
    """The raw value of `ropes`, if it is one."""
    names = isinstance(value, list | tuple) and value and all(isinstance(x, str) for x in value)
    if value is None or value == "*" or names:
        return value
    raise fault(
        f'expected a list of names of ropes, or "*" for all that there are, found {found(value)}'
    )


class FitFile(Part):
    """A fit: free numbers of a scene, and the experiments that shall determine them."""

    title: Text = ""
    """A line of text for people."""
    scene: Text
    """The scene file, relative to this file."""
    set: Setting = Field(default_factory=dict)
    """Values of the scene in all experiments, by key."""
    free: Annotated[dict[Text, Free], Field(min_length=1)]
    """Free numbers by their full key in the scene."""
    experiments: Annotated[dict[Name, Experiment], Field(min_length=1)]
    """Experiments by name."""
    ropes: Annotated[tuple[Text, ...] | Literal["*"] | None, BeforeValidator(_names_or_all)] = None
    """Names of ropes, each fitted by itself: `{rope}` in the names of files becomes each of them. "*":
    all that there are files of. Absent: one rope."""
    method: FitMethod = FitMethod()
    """How to fit."""
    sample: Sampling | None = None
    """Draws from the distribution of the numbers, beside the intervals. Absent: none."""
    choices: dict[Name, Choice] = Field(default_factory=dict)
    """Other laws to fit to the same data, compared in the report."""

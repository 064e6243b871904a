"""Models with stiff lines made softer, from whose shapes at rest those of the stiff ones are found.

A chain's axial stiffness is thousands of times what turns its links: from a shape that is wrong by a
millimetre across, which is tonnes of tension, Newton's method goes astray where links fall slack or
touch the bed. From the shape of a softer chain it does not.
"""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from lumpedcable.model.line import Line
from lumpedcable.model.model import Model
from lumpedcable.physics.tension import AbstractTensionLaw, Linear, TensionOnly

__all__ = ["STAGES", "Stage", "Stages", "softened", "softens"]

STAGES = 5
"""Stages of growing stiffness, ten times from one to the next, the last of them the line's own."""

TAUT = 0.01
"""Strain (-) up to which a law's stiffness is taken."""

AT_ONCE = 60
"""Steps after which an equilibrium that may be found by way of softer lines is looked for so."""


class Stage(NamedTuple):
    """Where a search is: which stage, 0 for the first, of the model as it is, and its turn in that."""

    number: Int[Array, ""]
    turn: Int[Array, ""]


class Stages(NamedTuple):
    """How a search for equilibrium goes on that has not found it at once: anew, by softer lines.

    `last` is the last stage, `STAGES`, in which lines are as stiff as they are again; 0 where a model
    has none that softens. No line's stiffness falls below `softest` (N), where that is given.
    """

    last: int
    max_iterations: int
    softest: Float[Array, ""] | None

    @staticmethod
    def of(
        model: Model, max_iterations: int, *, at_once: bool = False,
        softest: Float[Array, ""] | None = None,
    ) -> "Stages":  # fmt: skip
        """Those of a search in a model, each of so many steps at most; the first alone if `at_once`."""
        last = STAGES if not at_once and any(map(softens, model.lines.values())) else 0
        return Stages(last, max_iterations, softest)

    @property
    def first(self) -> Stage:
        """Before the first look."""
        return Stage(jnp.zeros((), int), jnp.zeros((), int))

    def model(self, model: Model, stage: Stage) -> Model:
        """The model as it is in a stage."""
        if not self.last:
            return model
        soft = self._between(stage)
        share = jnp.where(soft, 10.0 ** (stage.number - float(STAGES)), 1.0)
        return softened(model, share, self.softest)

    def begins(self, stage: Stage) -> Bool[Array, ""]:
        """Whether a stage has seen nothing yet."""
        return stage.turn == 0

    def unfinished(self, stage: Stage, found: Bool[Array, ""]) -> Bool[Array, ""]:
        """Whether to go on, where what was seen last is or is not at rest."""
        there = found & ~self.begins(stage) & ~self._between(stage)
        return ~there & (stage.number <= self.last)

    def after(
        self, stage: Stage, found: Bool[Array, ""], x: Array, ahead: Array
    ) -> tuple[Stage, Array]:
        """The next turn's stage, and where it looks: `ahead`, or at x in a new stage, 0 in the first."""
        most = min(AT_ONCE, self.max_iterations) if self.last else self.max_iterations
        over = stage.turn >= jnp.where(stage.number == 0, most, self.max_iterations)
        on = jnp.where(found, self._between(stage), over)
        later = Stage(stage.number + on, jnp.where(on, 0, stage.turn + 1))
        begin = jnp.where(stage.number == 0, 0.0, x)
        return later, jnp.where(on, begin, ahead)

    def _between(self, stage: Stage) -> Bool[Array, ""]:
        return (stage.number > 0) & (stage.number < self.last)


def softens(line: Line) -> bool:
    """Whether a line has softer stages: one that stretches has."""
    return not line.inextensible


class Softened(AbstractTensionLaw):
    """T(e) = law(s e), U(e) = U_law(s e) / s: a law whose strains are 1/s times as large, 0 < s <= 1.

    What it bears is what the law bears, also of one that levels off, as tanh does.
    """

    law: AbstractTensionLaw
    share: Float[Array, ""]

    def tension(self, strain: Float[Array, "..."]) -> Float[Array, "..."]:
        """The law's tension (N) at a share of each strain."""
        return self.law.tension(self.share * strain)

    def energy(self, strain: Float[Array, "..."]) -> Float[Array, "..."]:
        """The integral of the tension from strain 0 (J/m)."""
        return self.law.energy(self.share * strain) / self.share


def softened(
    model: Model, share: Float[Array, ""], softest: Float[Array, ""] | None = None
) -> Model:
    """The model, lines that stretch with a share (-) of their stiffness, no less than `softest` (N)."""
    lines = dict(model.lines)
    for name, line in model.lines.items():
        if softens(line):
            own = share
            if softest is not None:
                EA = (line.law.tension(jnp.asarray(TAUT)) - line.law.tension(jnp.zeros(()))) / TAUT
                own = jnp.minimum(1.0, jnp.maximum(share, softest / EA))
            lines[name] = eqx.tree_at(lambda x: x.law, line, _softer(line.law, own))
    return eqx.tree_at(lambda m: m.lines, model, lines)


def _softer(law: AbstractTensionLaw, share: Float[Array, ""]) -> AbstractTensionLaw:
    """A law with a share of its stiffness, cut at zero where it is."""
    if isinstance(law, TensionOnly):
        inner = _softer(law.law, share)
        return eqx.tree_at(
            lambda x: (x.law, x.slack_strain), law, (inner, law.slack_strain / share)
        )
    return Linear(share * law.EA) if isinstance(law, Linear) else Softened(law, share)

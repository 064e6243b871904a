"""What a lumped chain gets wrong about a wave front, and the two remedies.

A chain of lumps disperses: short waves run slow, a front leaves ripples behind, and a released end
overshoots at every number of nodes. A release from above the inflection of the tension law is a
shock, which a chain without dissipation does not find at all. Both remedies live on segments and
are exactly zero where the strain rate does not change along the line.
"""

import functools
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from lumpedcable.physics.each import at_each
from lumpedcable.physics.linear import neighbours, pick, sides
from lumpedcable.physics.place import framed, place_at_end
from lumpedcable.physics.seam import Seam
from lumpedcable.physics.tips import AFTER, ALIKE, BEFORE, FALLEN
from lumpedcable.physics.vectors import least, most
from lumpedcable.physics.wave_terms import (
    SOFT,
    TURNED,
    Given,
    Values,
    WaveTensions,
    second_difference,
    slopes,
    tensions,
)

__all__ = ["Boundary", "Cut", "Ghosted", "ReleaseWaves", "WaveTensions"]


class Boundary(eqx.Module):
    """What a wave meets at one end of a line.

    `loaded` is True where the force on the end node is known (free, held by a force, broken) and
    False where its motion is. `force` (d,) is that known force (N), None where it is zero, and
    `force_rate` (d,) how fast it changes (N/s), None where it does not. `joined` is True while the
    line goes on into another one; None where that never is. What never changes is a Python bool, so
    that the other case is not compiled.
    """

    loaded: Bool[Array, ""] | bool
    force: Float[Array, " d"] | None = None
    joined: Bool[Array, ""] | bool | None = None
    force_rate: Float[Array, " d"] | None = None

    def ghost_tension(
        self, tension: Float[Array, ""], outward: Float[Array, " d"]
    ) -> Float[Array, ""]:
        """Tension (N) of the segment that would follow beyond the end; `outward` is a unit vector.

        T at an end whose motion is known (a wave is reflected with its sign), 2 F . u - T at an end
        loaded by F (the mean of the two is the force).
        """
        if self.loaded is False:
            return tension
        pull = jnp.zeros_like(tension) if self.force is None else jnp.dot(self.force, outward)
        loaded = 2.0 * pull - tension
        return loaded if self.loaded is True else jnp.where(self.loaded, loaded, tension)

    def ghost_rate(
        self,
        rate: Float[Array, ""],
        stiffness: Float[Array, ""],
        outward: Float[Array, " d"],
        last: "Last | None",
    ) -> Float[Array, ""]:
        """Strain rate (1/s) of the segment that would follow beyond the end; `outward` a unit vector.

        `stiffness` (N) is that of the end's own segment, and `last` are the last ones, None for a line
        that cannot be slack. The rate repeats at an end whose motion is known. At one loaded by F it is
        2 g - rate: the force gives the end's own strain rate g = F' . u / T'(e), the mean of the two. Of
        slack segments it says nothing: a few have run ahead of their neighbours, and g is 0; where the
        line falls slack from the end, what it does repeats.
        """
        if self.loaded is False:
            return rate
        loaded = -rate
        if self.force_rate is not None:
            taut = stiffness > SOFT
            g = jnp.dot(self.force_rate, outward) / jnp.where(taut, stiffness, 1.0)
            loaded = loaded + 2.0 * jnp.where(taut, g, 0.0)
        if last is not None:
            loaded = jnp.where(last.fall(), rate, loaded)
        return loaded if self.loaded is True else jnp.where(self.loaded, loaded, rate)

    def at_load(
        self, rate: Float[Array, " n"], segment: int | Int[Array, ""]
    ) -> Float[Array, " n"] | None:
        """1 in the end's own segment where a force is known, else 0; None if it never is.

        In the shape and precision of `rate`.
        """
        if self.loaded is False:
            return None
        # a mask, since a write in the middle of a loop is a branch at every element
        segments = rate.shape[0]
        here = jnp.arange(segments) == segment % segments
        return (here & self.loaded).astype(rate.dtype)

    def off_joint(self, segments: int, segment: int | Int[Array, ""]) -> Bool[Array, " n"] | None:
        """False in the end's own segment at a joint, where the next line's tension is not known."""
        if self.joined is None:
            return None
        return ~((jnp.arange(segments) == segment % segments) & self.joined)


class Last(NamedTuple):
    """Strain rates (1/s) and stiffnesses (N) of an end's last segments, its own first."""

    rate: Float[Array, " k"]
    stiffness: Float[Array, " k"]

    def fall(self) -> Bool[Array, ""]:
        """Whether the line falls slack from the end.

        All of them are slack, or the own one is and a wave shortens them alike. Where an end has run
        ahead, its own segment shortens by itself, or far less than a fan that is still next to it.
        """
        fallen = jnp.max(self.stiffness) <= SOFT
        if self.rate.shape[0] < FALLEN:
            return fallen
        share = jnp.asarray(ALIKE, self.rate.dtype)
        alike = jnp.all(self.rate[: share.size] <= share * jnp.min(self.rate))
        return fallen | (alike & (self.stiffness[0] <= SOFT))


class Cut(NamedTuple):
    """A cut along a line and what a wave meets at the end before it and at the one after it."""

    seam: Seam
    before: Boundary
    after: Boundary

    def sides(self) -> tuple[tuple[int, Boundary], tuple[int, Boundary]]:
        """The two ends with their boundaries."""
        return (BEFORE, self.before), (AFTER, self.after)


class Ghosted(NamedTuple):
    """Tension, strain rate (1/s), stiffness (N) of all segments and a ghost beyond each end, (n + 2,).

    The tension and the stiffness are None where nothing asks for their ghosts.
    """

    tension: Float[Array, " n+2"] | None
    rate: Float[Array, " n+2"]
    stiffness: Float[Array, " n+2"] | None


class ReleaseWaves(eqx.Module):
    """Dispersion correction and limited viscosity for axial waves on a lumped line.

    For segment j with unstretched length l (m), tension T (N), wave speed c = sqrt(T'(e) / m)
    (m/s), Courant number nu = c dt / l, strain rate g (1/s) and jump of velocity D = g l (m/s):

    - correction C = -(1 - nu^2) / 12 (T_j+1 - 2 T_j + T_j-1 - R_j) (N): the leading error of leapfrog
      in space and time together, after the modified equation. Beyond the ends stand the ghost
      tensions of `Boundary`. R is what the second difference is at rest, where loads along the line
      hold a tension that is no wave: a line at rest stays at rest. None where nothing loads it. In a
      segment whose end has broken away since it is left out, and where a line may go slack what it
      makes is no more than T.
    - smoothness phi, the mean of the ratios of the neighbours' g to its own, from 0 to 1; where a
      segment stretches or is slack also at most twice the lesser ratio (monotonised central limiter;
      Christensen's limited viscosity), so that a change of sign is rough. f = (1 - phi)^2: 0 where the
      rate varies smoothly, 1 at an extremum. With the correction a taut segment that shortens is let off
      the second rule, which takes ripples behind a release for roughness and smears its front; without
      it, shocks of a release would then have too little viscosity. Where D is rounding, of
      some 50 eps c or below sqrt(eps) of a neighbour's, phi is 1: else the sign of what rest has left
      would decide ahead of a front. Methods that choose their step leave more, 1e-7 c: stages that
      switch f from one iterate to the next are not found.
    - viscosity Q = m b D f (N), b = min(0.16 c + 0.5 |D|, 0.4 (1 - nu^2)(3 - nu^2) l / (6 dt)) (m/s);
      the second bound keeps a viscosity lagging by half a step stable. In the segment of a loaded end,
      where a break leaves what no mesh resolves, the first is half as much again and the second 0.35
      times as much, since half a mass follows. Material damping k (N s) is a viscosity already: what it
      does, k / (m l), is taken off b. Where a tension-only line is slack, b = l / (4 dt), or
      0.3 (1 - nu^2) l / dt with the nu of the segments beside it if that is less: nothing else would
      send back a node that has overshot, and it would keep its speed and run into its neighbours. That
      it can only along a straight line: b is taken 1 - (a / 0.05)^2 times, or 0, with a (rad) the angle
      between the segments on both sides. A line that folds as it falls would be held up else.
    - the correction is switched off where f says shock, (1 - f) C, and at a joint.

    1/12 and the ghosts of a taut line are derived; 0.16, 0.5, 0.4, 0.3, 0.05, what an end changes of
    them, the rules of phi and the squares are choices. Without a fixed step (dt None, adaptive solvers)
    nu is 0 and the stability bound is left out.
    """

    corrected: bool = eqx.field(static=True)
    at_rest: Float[Array, " n"] | None = None

    def resting(
        self,
        tension: Float[Array, " n"],
        tangent: Float[Array, "d n"],
        ends: tuple[Boundary, Boundary],
        cut: Cut | None = None,
    ) -> "ReleaseWaves":
        """The same for a line with these tensions (N) at rest, before anything breaks."""
        still = jnp.zeros_like(tension)
        ghosted = self._ghosted(tension, still, still, tangent, ends, False, None)
        if cut is not None:
            ghosted = _written_beyond(ghosted, tension, still, still, tangent, cut)
        assert ghosted.tension is not None
        bend = second_difference(*neighbours(ghosted.tension))
        return ReleaseWaves(self.corrected, bend)

    def terms(
        self,
        tension: Float[Array, " n"],
        stiffness: Float[Array, " n"],
        rate: Float[Array, " n"],
        tangent: Float[Array, "d n"],
        length: Float[Array, "..."],
        mass: Float[Array, ""],
        ends: tuple[Boundary, Boundary],
        dt: Float[Array, ""] | None,
        tension_only: bool,
        over: Ghosted | None = None,
        damping: Float[Array, ""] | None = None,
        cut: Cut | None = None,
    ) -> tuple[WaveTensions, Ghosted]:
        """The tensions that they add, and what these were found from, written over `over` if given."""
        ghosted = self._ghosted(tension, stiffness, rate, tangent, ends, tension_only, over)
        if cut is not None:
            ghosted = _written_beyond(ghosted, tension, stiffness, rate, tangent, cut)
        if ghosted.tension is not None:
            tension = ghosted.tension[1:-1]
        segments = rate.shape[0]
        met: list[tuple[int | Int[Array, ""], Boundary]] = [(0, ends[0]), (-1, ends[1])]
        if cut is not None:
            met += [(cut.seam.segment(side), end) for side, end in cut.sides()]
        given = Given(
            _at_loads(met, rate),
            tuple(end.off_joint(segments, segment) for segment, end in met),
            tension > 0.0 if tension_only else None,
        )
        values = Values(
            neighbours(ghosted.rate),
            stiffness,
            None if ghosted.stiffness is None or dt is None else sides(ghosted.stiffness),
            None if ghosted.tension is None else neighbours(ghosted.tension),
            length,
            mass,
            dt,
            damping,
            self._at_rest(met, tension, tension_only),
            _aligned(tangent, cut) if tension_only and dt is not None else None,
        )
        return at_each(tensions, given, values, slopes), ghosted

    def _at_rest(
        self,
        met: list[tuple[int | Int[Array, ""], Boundary]],
        tension: Float[Array, " n"],
        tension_only: bool,
    ) -> Float[Array, " n"] | None:
        """R of the segments as it counts now."""
        rest = self.at_rest
        if rest is None:
            return None
        # of an end that was loaded from the first it was found as such
        broken = _at_loads([(k, end) for k, end in met if end.loaded is not True], rest)
        rest = rest if broken is None else rest * (1.0 - broken)
        if not tension_only:
            return rest
        most_of_it = 12.0 * tension  # which makes a C of T
        return most(least(rest, most_of_it), -most_of_it)

    def _ghosted(
        self,
        tension: Float[Array, " n"],
        stiffness: Float[Array, " n"],
        rate: Float[Array, " n"],
        tangent: Float[Array, "d n"],
        ends: tuple[Boundary, Boundary],
        tension_only: bool,
        over: Ghosted | None,
    ) -> Ghosted:
        start, end = ends
        over = Ghosted(None, None, None) if over is None else over  # type: ignore[arg-type]
        ahead = -pick(tangent, 0), pick(tangent, -1)
        own, fallen, near = (pick(stiffness, 0), pick(stiffness, -1)), (None, None), None
        if tension_only:
            still = jax.lax.stop_gradient((rate, stiffness))
            fallen = (
                Last(*(x[:FALLEN] for x in still)), Last(*(x[-FALLEN:][::-1] for x in still))
            )  # fmt: skip
            near = framed(own[0][None], stiffness, own[1][None], over.stiffness)
        first = start.ghost_rate(pick(rate, 0), own[0], ahead[0], fallen[0])
        last = end.ghost_rate(pick(rate, -1), own[1], ahead[1], fallen[1])
        rates = framed(first[None], rate, last[None], over.rate)
        if not self.corrected:
            return Ghosted(None, rates, near)
        before = start.ghost_tension(pick(tension, 0), ahead[0])
        after = end.ghost_tension(pick(tension, -1), ahead[1])
        tensions = framed(before[None], tension, after[None], over.tension)
        return Ghosted(tensions, rates, near)


def _written_beyond(
    ghosted: Ghosted,
    tension: Float[Array, " n"],
    stiffness: Float[Array, " n"],
    rate: Float[Array, " n"],
    tangent: Float[Array, "d n"],
    cut: Cut,
) -> Ghosted:
    """`ghosted` with what lies beyond the ends at a cut in its slots.

    Written there and not chosen at each segment: XLA would work it out anew at every one.
    """
    tensions, rates, near = ghosted
    for side, end in cut.sides():
        own, slot = cut.seam.segment(side), cut.seam.slot(side) + 1
        ahead = pick(tangent, own) * (1.0 if side == BEFORE else -1.0)
        stiff, last = pick(stiffness, own), None
        if near is not None:
            near = place_at_end(near, slot, stiff)
            still = jax.lax.stop_gradient((rate, stiffness))
            last = Last(*(cut.seam.last(x, side, FALLEN) for x in still))
        rates = place_at_end(rates, slot, end.ghost_rate(pick(rate, own), stiff, ahead, last))
        if tensions is not None:
            tensions = place_at_end(tensions, slot, end.ghost_tension(pick(tension, own), ahead))
    return Ghosted(tensions, rates, near)


def _aligned(tangent: Float[Array, "d n"], cut: Cut | None) -> Float[Array, " n"] | None:
    """1 - (a / 0.05)^2, or 0, with the angle a (rad) between the segments beside each.

    None of a straight line. Beyond an end a line goes on straight.
    """
    if tangent.shape[0] == 1:
        return None
    around = framed(tangent[:, :1], tangent, tangent[:, -1:])
    if cut is not None:
        for side, _ in cut.sides():
            own = pick(tangent, cut.seam.segment(side))
            around = place_at_end(around, cut.seam.slot(side) + 1, own)
    before, _, after = neighbours(around)
    turn = after - before
    return most(1.0 - jnp.sum(turn * turn, axis=0) / TURNED**2, 0.0)


def _at_loads(
    met: list[tuple[int | Int[Array, ""], Boundary]], rate: Float[Array, " n"]
) -> Float[Array, " n"] | None:
    """1 in the segments of loaded ends, 0 in all others; None if there can be none."""
    found = [end.at_load(rate, segment) for segment, end in met]
    masks = [mask for mask in found if mask is not None]
    return functools.reduce(jnp.maximum, masks) if masks else None

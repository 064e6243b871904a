"""What a case of the catalogue is, and the checkers that judge a run by it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from engine_runs import order_of
from player import Array, Kick, Played, Seen, play, sensitivity

Reader = Callable[[Seen], Array]


@dataclass(frozen=True)
class Case:
    """A scene, what is looked at in it, and what that is exactly.

    Attributes:
        text: the scene, TOML, with at most 16 outputs.
        seen: what is compared, time first; it must do with JAX arrays as well.
        exact: the exact answer, of the same shape, from times and places alone.
        scale: size that errors are relative to, in the units of `seen`.
        bound: largest relative error that a mesh of n segments may make in space, and in time with
            a step of its order.
        segments: size of the small mesh.
        source: where the exact answer comes from.
        kick: displacement and velocity that are given to the line at rest. None: none.
        order: band of the order in the segments' length, None where the mesh makes no error.
        refined: how many times the steps on a mesh twice as fine: 2 keeps the step over the segments'
            length, 4 is what the limit of a material's damping asks for.
        step_order: band of leapfrog's order in the step on the small mesh.
        mean: errors are mean ones over places and times (for jumps), else the largest ones.
        plain: whether a chain without wave terms finds the answer at all.
        euler: step of the first-order method over the stable one of leapfrog, small enough for the
            same bound: Euler's method swells an oscillation by omega^2 dt/2 a second.
        gradients: exact derivatives of `seen` with respect to numbers of the scene, by their key.
        gradient_bound: their largest relative error. Where the error is a phase eps omega t with
            eps ~ omega^2, the derivative's is that and 3 eps: half as much again for omega t > 6,
            the default.
    """

    text: str
    seen: Reader
    exact: Reader
    scale: float
    bound: Callable[[int], float]
    segments: int
    source: str
    kick: Kick | None = None
    order: tuple[float, float] | None = (1.8, 2.2)
    refined: int = 2
    step_order: tuple[float, float] | None = (1.9, 2.1)
    mean: bool = False
    plain: bool = True
    euler: float = 1e-3
    gradients: Mapping[str, Reader] = field(default_factory=dict)
    gradient_bound: Callable[[int], float] | None = None

    def play(
        self, *overrides: str, segments: int | None = None, steps: int | None = None
    ) -> Played:
        """Run the case."""
        line = f"{self.line}.segments={segments or self.segments}"
        return play(self.text, line, *overrides, kick=self.kick, steps=steps)

    @property
    def line(self) -> str:
        return self.text.partition("[lines.")[2].partition("]")[0]

    def allowed(self) -> float:
        """Largest relative error of a gradient on the small mesh."""
        n = self.segments
        return 1.5 * self.bound(n) if self.gradient_bound is None else self.gradient_bound(n)

    def gradient(self, key: str, *overrides: str, reverse: bool = False):
        """What is seen and its derivative by `key`; see `player.sensitivity`."""
        line = f"{self.line}.segments={self.segments}"
        return sensitivity(
            self.text, key, self.seen, line, *overrides, kick=self.kick, reverse=reverse
        )

    def error(self, seen: Seen) -> float:
        """Relative error of a run."""
        return relative_error(self.seen(seen), self.exact(seen), self.scale, mean=self.mean)


def relative_error(found: Array, exact: Array, scale: float, *, mean: bool = False) -> float:
    """Largest or mean distance over a scale; shapes must agree."""
    found, exact = np.asarray(found, float), np.asarray(exact, float)
    assert found.shape == exact.shape
    distance = np.abs(found - exact)
    return float(np.mean(distance) if mean else np.max(distance)) / scale


def assert_right(case: Case, played: Played, segments: int | None = None) -> None:
    """The run ended, moved at all, and is as close to the exact answer as the mesh must be."""
    assert played.finite
    error, bound = case.error(played.seen), case.bound(segments or case.segments)
    assert error <= bound, f"error {error:.3g}, at most {bound:.3g}"


def assert_order(errors, factor: float, band: tuple[float, float]) -> None:
    """Errors of meshes or steps finer by `factor` fall with an order inside the band."""
    orders = order_of(errors, factor)
    assert np.all((orders >= band[0]) & (orders <= band[1])), f"order {orders}, expected {band}"


def assert_step_order(case: Case, *overrides: str, steps: int, band: tuple[float, float]) -> None:
    """Changes from halving the step, and halving it again, fall with an order inside the band."""
    runs = [case.play(*overrides, steps=k * steps) for k in (1, 2, 4)]
    assert all(run.finite for run in runs)
    seen = [np.asarray(case.seen(run.seen)) for run in runs]
    changes = [np.max(np.abs(a - b)) for a, b in pairwise(seen)]
    assert_order(changes, 2, band)


def assert_gradient(found: Array, exact: Array, bound: float, *, mean: bool = False) -> None:
    """A derivative is right to `bound` times its own largest value."""
    error = relative_error(found, exact, float(np.max(np.abs(exact))), mean=mean)
    assert error <= bound, f"gradient error {error:.3g}, at most {bound:.3g}"

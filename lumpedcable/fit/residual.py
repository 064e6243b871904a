"""Deviations of the model from the data, in standard deviations, as a function of the parameters."""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from lumpedcable.fit.arrays import Arrays, GroupArrays, GroupSpec, Spec, TableArrays, TableSpec
from lumpedcable.fit.observe import look
from lumpedcable.fit.transforms import to_values
from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.materials import law_of
from lumpedcable.model.model import Model
from lumpedcable.solve.bound import step_bound
from lumpedcable.solve.integrate import Numbers, begin, cast, interval
from lumpedcable.solve.observe import Sample, sample
from lumpedcable.solve.start import start_of

__all__ = [
    "Prediction",
    "deviations",
    "penalised",
    "predict",
    "residual",
    "value_and_jacobian",
]

PENALTY = 10.0
"""What a run that failed is taken to miss every value by, over the largest value of its column."""


class Prediction(NamedTuple):
    """What the model says: tables (points,), groups (runs, observed, points), all in SI.

    `good` tells, by group, which runs came to their end; `steps` are those between outputs.
    """

    tables: tuple[Float[Array, " points"], ...]
    groups: tuple[Float[Array, "runs observed points"], ...]
    good: tuple[Bool[Array, " runs"], ...]
    steps: tuple[Array, ...]


def predict(spec: Spec, arrays: Arrays, values: Float[Array, " p"]) -> Prediction:
    """The model's answer to every measured value, for parameters in SI."""
    tables = tuple(_table(s, a, values) for s, a in zip(spec.tables, arrays.tables, strict=True))
    groups = [_group(s, a, values) for s, a in zip(spec.groups, arrays.groups, strict=True)]
    found, good, steps = zip(*groups, strict=True) if groups else ((), (), ())
    return Prediction(tables, found, good, steps)


def _table(spec: TableSpec, arrays: TableArrays, values) -> Float[Array, " points"]:
    numbers = dict(arrays.numbers) | {key: values[index] for key, index in spec.free}
    scene = spec.structure.scene.with_numbers(numbers)
    return law_of(scene.materials[spec.material]).tension(jnp.asarray(arrays.strain))


def _group(spec: GroupSpec, arrays: GroupArrays, values):
    """(runs, observed, points) of a group, which runs went well, and the steps between outputs."""
    shared, own = dict(arrays.shared), dict(arrays.own)
    for key, index in spec.free:
        shared.pop(key, None)
        own.pop(key, None)
        if len(index) == 1:
            shared[key] = values[index[0]]
        else:
            own[key] = values[jnp.array(index)]
    coordinates = Coordinates(arrays.axes, arrays.origin)  # type: ignore[arg-type]

    def start(mine):
        scene = spec.structure.scene.with_numbers({**shared, **mine})
        found = start_of(scene, spec.structure.layout, coordinates)
        return cast(found.model, spec.plan.dtype), step_bound(found.model), found.converged

    axis = None if not own else 0
    runs = arrays.every.shape[0]
    models, bound, converged = jax.vmap(start, in_axes=(axis,), axis_size=runs)(own)
    steps = _steps(spec, arrays, bound)

    def run(model, every, shares, index, mix):
        numbers = Numbers(every, steps, arrays.rtol, arrays.atol)
        kept, good = history(model, spec, numbers, coordinates, shares)
        return jnp.einsum("pk,pko->op", mix, kept[index]), good

    found, good = jax.vmap(run)(models, arrays.every, arrays.shares, arrays.index, arrays.mix)
    good = good & converged & jnp.all(jnp.isfinite(found), axis=(1, 2))
    return found, good, steps


def _steps(spec: GroupSpec, arrays: GroupArrays, bound: Float[Array, " runs"]):
    """Steps between outputs: as many as stability asks for, and no fewer than the arrays say.

    Rounded up as those of a run are, so that nearby values take the same number.
    """
    if spec.plan.adaptive:
        return 1
    if spec.steps is not None:
        return spec.steps
    need = jnp.max(arrays.every / (arrays.courant * jax.lax.stop_gradient(bound)))
    count = jnp.maximum(jnp.ceil(need * (1.0 - 1e-9)), 1.0)
    count = jnp.where(jnp.isfinite(count), count, 1.0)
    unit = 2.0 ** jnp.maximum(jnp.floor(jnp.log2(count)) - 4.0, 0.0)
    return jnp.maximum((jnp.ceil(count / unit) * unit).astype(int), arrays.steps)


def history(
    model: Model, spec: GroupSpec, numbers: Numbers, coordinates: Coordinates, shares
) -> tuple[Float[Array, "outputs observed"], Bool[Array, ""]]:
    """Observed values at every output of one run, the start first, and whether all went well."""
    plan = spec.plan
    dt = None if plan.adaptive else numbers.every / numbers.steps

    def seen(s: Sample):
        picked = [
            look(model, coordinates, s, what, shares[k]) for k, what in enumerate(spec.watched)
        ]
        return jnp.stack(picked), s.finite & (s.courant <= 1.0) & ~s.exhausted

    def body(run, k):
        run = interval(model, plan, numbers, run, k * numbers.every)
        t = (k + 1) * numbers.every
        return run, seen(sample(model, t, run.y, plan.quantities, dt, run.exhausted))

    run, first = begin(model, plan, numbers)
    if spec.steps is not None:
        # reverse mode keeps one state an output and goes through each interval again
        body = jax.checkpoint(body)
    _, (values, good) = jax.lax.scan(body, run, jnp.arange(spec.count))
    now, fine = seen(first)
    return jnp.concatenate([now[None], values]), jnp.all(good) & fine


def deviations(
    spec: Spec, arrays: Arrays, values: Float[Array, " p"]
) -> tuple[Float[Array, " n"], Float[Array, " m"], Prediction]:
    """(model - data) weight for every value, rows that ask for smoothness, what was predicted.

    A run that failed deviates by nothing: see `penalised`.
    """
    found = predict(spec, arrays, values)
    parts = [
        (f - a.data) * a.weight for f, a in zip(found.tables, arrays.tables, strict=True)
    ]
    for f, good, a in zip(found.groups, found.good, arrays.groups, strict=True):
        parts.append(jnp.where(good[:, None, None], (f - a.data) * a.weight, 0.0).ravel())
    rows = [jnp.zeros(0)]
    for index, a in zip(spec.smooth, arrays.smooth, strict=True):
        slope = jnp.diff(values[jnp.array(index)]) / jnp.diff(a.strain)
        rows.append(jnp.diff(slope) * a.weight)
    return jnp.concatenate(parts), jnp.concatenate(rows), found


def robust(r: Float[Array, " n"], loss: str, c: Float[Array, ""]) -> Float[Array, " n"]:
    """Deviations whose squares are the loss rho(r): sqrt(rho(r)) with the sign of r.

    squares: r^2. huber: r^2 up to c, 2 c |r| - c^2 beyond. cauchy: c^2 ln(1 + r^2/c^2).
    """
    if loss == "squares":
        return r
    if loss == "huber":
        far = jnp.abs(r) > c
        long = jnp.sqrt(jnp.where(far, 2.0 * c * jnp.abs(r) - c**2, 1.0))
        return jnp.where(far, jnp.sign(r) * long, r)
    u = (r / c) ** 2
    small = u < 1e-8
    ratio = jnp.where(small, 1.0 - 0.5 * u, jnp.log1p(u) / jnp.where(small, 1.0, u))
    return r * jnp.sqrt(ratio)


def penalised(spec: Spec, arrays: Arrays, z: Float[Array, " p"]) -> Float[Array, " n"]:
    """What is squared and summed, for unbounded parameters.

    Measured values, then smoothness, then one row for each run: 0, or where the run failed a number
    larger than what its values could deviate by. So the others can still tell where to go.
    """
    r, smooth, found = deviations(spec, arrays, to_values(arrays.transform, z))
    fines = [jnp.zeros(0)]
    for good, a in zip(found.good, arrays.groups, strict=True):
        worst = jnp.max(jnp.abs(a.data * a.weight), axis=2, keepdims=True)
        fine = PENALTY * jnp.sqrt(jnp.sum(jnp.where(a.weight > 0.0, worst, 0.0) ** 2, axis=(1, 2)))
        fines.append(jnp.where(good, 0.0, fine))
    r = robust(r, spec.loss, arrays.threshold)
    return jnp.concatenate([r, smooth, *fines])


def failed_runs(runs: int, r: Float[Array, " n"]) -> Int[Array, ""]:
    """How many of all `runs` failed, from what `penalised` gave."""
    return jnp.sum(r[r.shape[0] - runs :] > 0.0)


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def residual(spec: Spec, arrays: Arrays, z: Float[Array, " p"]) -> Float[Array, " n"]:
    """`penalised`, with its Jacobian worked out as a whole, in forward mode, where it is needed.

    A minimiser then multiplies with a matrix instead of going through time again.
    """
    return penalised(spec, arrays, z)


@residual.defjvp
def _residual_jvp(spec, primals, tangents):
    arrays, z = primals
    value, slope = value_and_jacobian(spec, arrays, z)
    return value, slope @ tangents[1]


def value_and_jacobian(spec: Spec, arrays: Arrays, z: Float[Array, " p"]):
    """`penalised` and its Jacobian (n, p), zero in the rows of a run that failed."""

    def both(z):
        value = penalised(spec, arrays, z)
        return value, value

    slope, value = jax.jacfwd(both, has_aux=True)(z)
    return value, jnp.where(jnp.isfinite(slope), slope, 0.0)

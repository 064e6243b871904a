"""A results file made from closed forms, so that reading and drawing need no engine.

A line of the linear law T = EA e, held at s = 0 and broken at s = L, released from the pretension
T0 over the break time tb: the tension at the broken end is T0 cos^2(pi t / 2 tb), and d'Alembert's
solution with one reflection after another at the wall gives everything else. With c = sqrt(EA/m),
f(t) = 1 - cos^2(pi t / 2 tb) clipped to [0, 1] the released share, and images of alternating sign
at the free end::

    T(s, t)/T0 = 1 - sum_k (-1)^k [f(t - (2k L + L - s)/c) + f(t - (2k L + L + s)/c)]
    v(s, t)    = -(T0/(m c)) sum_k (-1)^k [f(t - (2k L + L - s)/c) - f(t - (2k L + L + s)/c)]

The tension goes negative after the first return, as the linear law has it.
"""

import numpy as np

from lumpedcable.results import Coordinate, ResultWriter, Variable, sweep_coordinates

LENGTH = 60.0  # m
MASS = 2.238  # kg/m
STIFFNESS = 1.5e6  # N
SPEED = np.sqrt(STIFFNESS / MASS)  # m/s
PRETENSIONS = (45e3, 180e3, 315e3, 450e3)  # N
BREAK_TIMES = (5e-3, 50e-3)  # s
TIMES = np.linspace(0.0, 0.2, 201)  # s
ATTRIBUTES = {
    "title": "Linear line parting",
    "scene_path": "configs/made_up.toml",
    "overrides": ["break.time=50 ms"],
    "solver": "leapfrog",
    "step": 1.2e-5,
    "waves": "corrected",
    "dtype": "float64",
    "lumpedcable_version": "0.1.0",
    "versions": {"jax": "0.7.2"},
    "created": "2026-01-02T03:04:05+00:00",
}


def released(time, break_time):
    """The share of the pretension taken off at the broken end by a time."""
    return 1 - np.cos(np.pi / 2 * np.clip(time / break_time, 0, 1)) ** 2


def wave(place, time, pretension, break_time, images=4):
    """Tension in N and axial velocity in m/s at (time, place)."""
    s, t = np.asarray(place)[None, :], np.asarray(time)[:, None]
    tension = np.ones((t.shape[0], s.shape[1]))
    velocity = np.zeros_like(tension)
    for k in range(images):
        away = released(t - (2 * k * LENGTH + LENGTH - s) / SPEED, break_time)
        back = released(t - (2 * k * LENGTH + LENGTH + s) / SPEED, break_time)
        tension -= (-1) ** k * (away + back)
        velocity -= (-1) ** k * (away - back)
    return pretension * tension, pretension / (MASS * SPEED) * velocity


def snapback(
    path,
    *,
    pretensions=PRETENSIONS,
    break_times=BREAK_TIMES,
    segments=60,
    times=TIMES,
    broken=True,
    swept=True,
    failed=(),
    lost=(),
    padded=0,
    sag=0.0,
    break_start=None,
    scene="title = 'made up'",
    fields=("position", "velocity", "tension", "strain"),
    finish=True,
):
    """Write the file and return its path.

    Runs in `failed` are NaN from the middle on, those in `lost` wholly; `padded` nodes are NaN; the
    line swings up and down by `sag` (m), which is no mechanics, only something to look at.
    Only the `fields` named are stored. Unless told to `finish`, the file stays a partial one.
    """
    runs = np.array([(p, b) for p in pretensions for b in break_times])
    node = np.linspace(0, LENGTH, segments + 1)
    computed, energy = _computed(runs, node, times, sag)
    for array in (*computed.values(), *energy.values()):
        array[list(failed), len(times) // 2 :] = np.nan
        array[list(lost)] = np.nan
    numbers = _summary(runs, computed["velocity"], break_start) if broken else {}
    status = np.where(np.isin(np.arange(len(runs)), list(failed)), 2, 1).astype("i1")

    coordinates = {"time": Coordinate(times, "s", "time"), **_places(node, padded)}
    if swept:
        coordinates |= sweep_coordinates(
            [
                ("lines.rope.end.held.pretension", "N", runs[:, 0]),
                ("events.break.time", "s", runs[:, 1]),
            ]
        )
    with ResultWriter(
        path,
        dims={
            "run": len(runs),
            "time": len(times),
            "xyz": 3,
            "lines/rope/node": segments + 1 + padded,
            "lines/rope/segment": segments + padded,
        },
        variables=_variables(fields, energy, numbers),
        coordinates=coordinates,
        attributes={**ATTRIBUTES, "scene": scene},
    ) as writer:
        for first in range(0, len(times), 50):  # piece by piece, as a study does
            part = slice(first, min(first + 50, len(times)))
            for name, array in ((name, computed[name]) for name in fields):
                room = [(0, 0)] * array.ndim
                room[2] = (0, padded)
                whole = np.pad(array[:, part], room, constant_values=np.nan)
                writer.write(f"lines/rope/{name}", whole, time=part)
            writer.flush()
        for name, array in energy.items():
            writer.write(f"energy/{name}", array)
        writer.write("status", status)
        writer.write("status_time", np.where(status == 2, times[len(times) // 2], np.nan))
        writer.write("status_message", ["too much strain" if s == 2 else "" for s in status])
        writer.write("summary/energy_closure", np.full(len(runs), 1e-6))
        for name, (_, values, _) in numbers.items():
            writer.write(f"summary/rope.end/{name}", values)
        return writer.finish() if finish else writer.keep()


def _computed(runs, node, times, sag):
    """Fields by name, shape (run, time, ...), and energies by term, shape (run, time)."""
    middle = (node[1:] + node[:-1]) / 2
    tension = np.array([wave(middle, times, *run)[0] for run in runs])
    along = np.array([wave(node, times, *run)[1] for run in runs])
    strain = tension / STIFFNESS
    position = np.zeros((*along.shape, 3))
    position[..., 1:, 0] = np.cumsum((1 + strain) * np.diff(node), axis=-1)
    x = position[..., 0] / LENGTH
    position[..., 2] = -4 * sag * np.cos(2 * np.pi * times / 0.3)[:, None] * (x - x**2)
    stored = 0.5 * STIFFNESS * np.mean(strain**2, axis=-1) * LENGTH
    return {
        "position": position,
        "velocity": along[..., None] * np.array([1.0, 0.0, 0.0]),
        "tension": tension,
        "strain": strain,
    }, {
        "kinetic": 0.5 * MASS * np.trapezoid(along**2, node, axis=-1),
        "strain": stored,
        "residual": 1e-6 * stored[:, :1] * np.sin(300 * times),
    }


def _summary(runs, velocity, break_start):
    """Numbers of the broken end by name: (units, values, attributes)."""
    pretension = runs[:, 0]
    ideal = {"holds": "instantaneous break, no drag"}
    arrival = np.full(len(runs), LENGTH / SPEED)
    numbers = {
        "static_strain": ("1", pretension / STIFFNESS, {}),
        "peak_end_speed": ("m/s", -np.fmin.reduce(velocity[:, :, -1, 0], axis=1), {}),
        "exact_peak_end_speed": ("m/s", pretension / (MASS * SPEED), ideal),
        "exact_front_arrival": ("s", arrival, ideal),
        "reference_book_front_arrival": ("s", np.full(len(runs), 0.0733), {"source": "A book"}),
    }
    if break_start is not None:
        numbers["break_start"] = ("s", np.full(len(runs), break_start), {})
    return numbers


def _places(node, padded):
    words = "unstretched distance from the start"
    room = np.full(padded, np.nan)
    middle = (node[1:] + node[:-1]) / 2
    return {
        f"lines/rope/unstretched_{name}": Coordinate(np.append(at, room), "m", words, (dim,))
        for name, dim, at in (("position", "node", node), ("segment", "segment", middle))
    }


def _variables(fields, energy, numbers):
    meanings = {"flag_values": np.array([0, 1, 2], "i1"), "flag_meanings": "pending ok diverged"}
    nodes, segments = ("run", "time", "node", "xyz"), ("run", "time", "segment")
    known = {"position": (nodes, "m"), "velocity": (nodes, "m/s"),
             "tension": (segments, "N"), "strain": (segments, "1")}  # fmt: skip
    return [
        *(Variable(f"lines/rope/{n}", known[n][0], "f4", known[n][1]) for n in fields),
        *(Variable(f"energy/{term}", ("run", "time"), "f8", "J") for term in energy),
        Variable("status", ("run",), "i1", "1", "outcome", meanings),
        Variable("status_time", ("run",), "f8", "s", "time of failure"),
        Variable("status_message", ("run",), "str"),
        Variable("summary/energy_closure", ("run",), "f8", "1"),
        *(
            Variable(f"summary/rope.end/{name}", ("run",), "f8", unit, "", attributes)
            for name, (unit, _, attributes) in numbers.items()
        ),
    ]

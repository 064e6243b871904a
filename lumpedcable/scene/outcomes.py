"""The numbers that every run comes down to, by name: no number that a scene asks for may take one."""

from __future__ import annotations

__all__ = ["QUANTITIES", "RESULTS", "STATISTICS", "SUMMARIES", "TAKEN"]

QUANTITIES = {
    "static_strain": ("1", "strain at the end at rest, before anything moves"),
    "static_tension": ("N", "tension at the end at rest, before anything moves"),
    "peak_end_speed": ("m/s", "peak speed of the broken end, once its break has begun"),
    "break_start": ("s", "time at which the break begins"),
    "front_arrival": (
        "s",
        "time after the start of the break until the far end has lost 1 % of its tension then",
    ),
    "end_displacement": (
        "m",
        "distance of the broken end, at the last time, from where it was when its break began",
    ),
    "reach": ("m", "largest distance of the broken end from where it was when its break began"),
}
"""Of every end that recoils: unit and meaning."""
SUMMARIES = {
    "energy_closure": ("1", "largest energy residual over released energy"),
    "released_energy": ("J", "energy turned into motion or lost"),
    "static_imbalance": ("1", "largest force left by statics over the largest force"),
    "peak_tension": (
        "N",
        "largest tension of any segment at any step, with other methods than leapfrog at output times; "
        "of ends of lines with weight at output times as well",
    ),
    "utilisation": ("1", "largest tension of a line over the breaking strength of its material"),
    "peak_kinetic_energy": ("J", "largest kinetic energy, at the output times"),
    "stop_time": ("s", "when the body of output.stop came to rest"),
    "stop_distance": (
        "m",
        "distance of the body of output.stop from its start when it came to rest",
    ),
    "solver_step": ("s", "time step"),
}
"""Of every run: unit and meaning."""
STATISTICS = ("mean", "deviation")
"""What `output.statistics` gives of each measure besides its extreme: NAME_mean, NAME_deviation."""
_OF_THE_SOLVER = ("energy_closure", "static_imbalance", "solver_step")
RESULTS = {
    name: "" if unit == "1" else unit
    for name, (unit, _) in (QUANTITIES | SUMMARIES).items()
    if name not in _OF_THE_SOLVER
}
"""Numbers of a run that a source may give, with their units; the measures of a scene are more."""
_OF_RUNS = ("run", "time", "case", "status", "status_time", "status_message", "written", "xyz")
TAKEN = frozenset({*SUMMARIES, "solver_steps", *RESULTS, *_OF_RUNS})
"""Names of a run's own numbers, of what tells runs and times apart, and of what references give."""

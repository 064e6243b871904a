"""How a run ended: a code, what it means, and what to do about it; and why none can begin."""

from enum import IntEnum

__all__ = [
    "ADVICE",
    "CALMED",
    "MEANING",
    "SIGNS",
    "PlatformError",
    "Status",
    "advice_of",
    "remark_of",
]


class PlatformError(Exception):
    """This computer, or jax on it, lacks the device that is asked for; the message says which it has."""


class Status(IntEnum):
    """The end of a run. A run that is not `OK` never spoils the others of its batch."""

    OK = 0
    STATICS_NOT_CONVERGED = 1
    NON_FINITE = 2
    STEP_BOUND_BROKEN = 3
    LINE_REVERSED = 4
    TOO_MANY_STEPS = 5
    INTERRUPTED = 6
    ENERGY_NOT_CLOSED = 7
    SCENE_IMPOSSIBLE = 8
    STILL_MOVING = 9
    BODY_UPENDED = 10
    LENGTH_LOST = 11
    STEP_NOT_FOUND = 12
    STRAIN_EXCEEDED = 13
    LINE_RUN_OUT = 14


SIGNS = (
    Status.BODY_UPENDED,
    Status.LINE_RUN_OUT,
    Status.LENGTH_LOST,
    Status.STEP_BOUND_BROKEN,
    Status.TOO_MANY_STEPS,
    Status.STEP_NOT_FOUND,
    Status.NON_FINITE,
    Status.LINE_REVERSED,
)
"""What an output can show to have gone wrong: the first one to show counts, of those that show at one
time the first one here, since what is undefined was something else first."""

MEANING = {
    Status.OK: "ok",
    Status.STATICS_NOT_CONVERGED: "no static equilibrium was found to start from",
    Status.NON_FINITE: "a number became infinite or undefined",
    Status.STEP_BOUND_BROKEN: "a wave became faster than the step allows",
    Status.LINE_REVERSED: "the line reversed on itself, so that the result depends on the mesh",
    Status.TOO_MANY_STEPS: "more steps are needed than may be taken",
    Status.INTERRUPTED: "interrupted before the end",
    Status.ENERGY_NOT_CLOSED: (
        "energy came from nowhere or was lost, so that the motion is not to be trusted"
    ),
    Status.SCENE_IMPOSSIBLE: "the numbers of this run do not go together",
    Status.BODY_UPENDED: (
        "a body in space pitched up or down to 90 degrees, where its roll and yaw cannot be told apart"
    ),
    Status.STILL_MOVING: "the body that should come to rest was still moving at the end",
    Status.LENGTH_LOST: (
        "an inextensible line lost its length, since its ends are moved farther apart than it is long, "
        "or the step is too long for how it is pulled"
    ),
    Status.STEP_NOT_FOUND: (
        "the method found no step that goes on from there: its stages had no solution, or its error "
        "stayed too large, however short it was"
    ),
    Status.STRAIN_EXCEEDED: "a line stretched beyond max_strain of its material",
    Status.LINE_RUN_OUT: "a body that runs on a line came to an end of it, where it is no longer borne",
}

_ON_BEDS = "; of inextensible lines on a bed, lower solver.step"

TURNED_OVER = (
    "in balance, but a touch would turn it over, since a line is folded back on itself or leaves a "
    "clamp backwards"
)
"""What is said of a state of rest that was found and is none to start from."""

UNFOLDED = (
    "give what lies slack on a bed tension_only; turn a clamp towards where its line goes, give a joint "
    "a place (at), or change segments a little"
)

CALMED = ", or give the line materials.NAME.damping and lines.NAME.drag"
"""What may keep a line from reversing; of one line its keys that it does not have."""

ADVICE = {
    Status.OK: "",
    Status.STATICS_NOT_CONVERGED: (
        "check that something holds each line in its place (an end that is fixed, moved or on a "
        "body), that the ends and forces can balance (a slack line needs gravity to have a shape, and "
        "tension_only where it lies slack on a bed), that "
        "the tension of a winch or of a target is not too low to hold up its line, and that no body "
        "of a target lies beyond the ends; lengths that targets choose may begin too far from what is "
        "wanted; or give a point body at which lines meet a position near its own, or raise "
        "statics.max_iterations"
    ),
    Status.NON_FINITE: (
        "lower solver.courant; if strains can go beyond max_strain of the material, raise it, but "
        "where its tension falls as it is stretched lower it to that: nothing holds a line there; check "
        "places, masses, stiffness and drag for the units"
    ),
    Status.STEP_BOUND_BROKEN: (
        "strains left the range that the step was chosen for, or a winch hauled in so much that "
        f"segments became shorter: raise max_strain of the material, or lower solver.courant{_ON_BEDS}"
    ),
    Status.LINE_REVERSED: (
        "what happens after this time is a pile-up that no line model resolves: use the results "
        f"up to it{CALMED}"
    ),
    Status.TOO_MANY_STEPS: "raise solver.max_steps, loosen rtol, or use the leapfrog method",
    Status.INTERRUPTED: "run it again",
    Status.ENERGY_NOT_CLOSED: (
        'lower solver.courant; where a line snaps taut or shocks, solver.waves = "corrected"; a '
        "method that takes longer steps than its accuracy allows needs a smaller step or tolerance"
    ),
    Status.SCENE_IMPOSSIBLE: "change the bounds of the sweep",
    Status.BODY_UPENDED: (
        "use the results up to this time, or choose other axes of the body's own, so that it rolls or "
        "yaws where it pitched: its points, size, inertia, attitude and directions of clamped lines go "
        "by them"
    ),
    Status.STILL_MOVING: "raise output.duration; what drags it on may be more than what holds it",
    Status.LENGTH_LOST: (
        "see how far apart its ends are moved, and lower solver.step if that is less; the run ends "
        "before that step, and tensions of the last ones before it may be far too large"
    ),
    Status.STEP_NOT_FOUND: (
        'use the leapfrog method, or with an implicit one (kvaerno) solver.waves = "plain"; '
        "where solver.step or solver.courant is given a lower one may do"
    ),
    Status.STRAIN_EXCEEDED: (
        "raise max_strain if the rope bears that; if not, check the units of lengths, places and "
        "records, and the stiffness; what comes after this time is the law carried on"
    ),
    Status.LINE_RUN_OUT: (
        "use the results up to this time: a line that breaks runs out through the trolley, which falls "
        "then, and here holds on to its end; where nothing breaks, let it stop farther from the post"
    ),
}


def advice_of(status: Status, step_given: bool) -> str:
    """What to do about an end; where the scene gives `solver.step`, that is what it can lower."""
    told = ADVICE[status]
    if step_given:
        return told.replace(_ON_BEDS, "").replace("solver.courant", "solver.step")
    return told


def remark_of(message: str) -> str:
    """What the message of a run that went well says beside that; "" of nothing, and of other runs."""
    well, _, remark = message.partition("; ")
    return remark if well == MEANING[Status.OK] else ""

"""A box that floats on two chains in a plane, and targets as a scene writes them."""

from engine_runs import fixed, line_text

BUOY = (
    "gravity = 9.81\n[water]\ndensity = 1025\nsurface = 0\n"
    '[materials.chain]\nlaw = "linear"\nEA = "50 MN"\ntension_only = true\n'
    "[bodies.buoy]\nmass = 3000\nvolume = 8\nsize = [2, 2, 2]\nposition = [0, 0, -0.3]\n"
    'free = ["x", "z"]\nsettle = true\n'
    + line_text("left", "chain", 60, 12, 20, fixed(-45, 0, -30), '"buoy"', "diameter = 0.05")
    + line_text("right", "chain", 60, 12, 20, fixed(45, 0, -30), '"buoy"', "diameter = 0.05")
)


def target(name, change, of, **wanted):
    """The table of a target: which line's length is found, and what is asked for."""
    ((key, value),) = wanted.items()
    return f'[targets.{name}]\nchange = "lines.{change}.length"\nof = "{of}"\n{key} = {value}\n'

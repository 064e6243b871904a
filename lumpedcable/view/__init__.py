"""Figures drawn from a results file or of natural modes, for a screen or a printed page."""

from lumpedcable.view.animation import animate_result
from lumpedcable.view.modes import ModeShapes, plot_modes
from lumpedcable.view.plot import figures_of, plot_result

__all__ = ["ModeShapes", "animate_result", "figures_of", "plot_modes", "plot_result"]

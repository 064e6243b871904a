"""Figures drawn from a results file, of natural modes or of a fit, for a screen or a printed page."""

from lumpedcable.view.animation import animate_result
from lumpedcable.view.fit import Compared, FitPictures, Law, fit_figures, plot_fit
from lumpedcable.view.modes import ModeShapes, mode_figure, plot_modes
from lumpedcable.view.plot import figures_of, plot_result
from lumpedcable.view.sensitivity import plot_sensitivity, sensitivity_bars

__all__ = [
    "Compared",
    "FitPictures",
    "Law",
    "ModeShapes",
    "animate_result",
    "figures_of",
    "fit_figures",
    "mode_figure",
    "plot_fit",
    "plot_modes",
    "plot_result",
    "plot_sensitivity",
    "sensitivity_bars",
]

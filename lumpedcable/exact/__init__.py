"""Closed forms and exact waves that judge the engine; imports nothing else of lumpedcable.

Every answer here is a closed form, a quadrature, a root or a wave by characteristics: none of it
shares a line of code with the lumped-mass model. Inputs and results are SI numbers and NumPy
arrays.
"""

from .beam import (
    beam_frequencies,
    cantilever_deflection,
    rolled_beam,
    simply_supported_deflection,
    tensioned_beam_frequencies,
    tip_loaded_cantilever,
)
from .catenary import Catenary, elastic_catenary
from .chain import (
    ChainShape,
    StrainOfTension,
    hanging_nodes,
    linear_strain,
    pinned_nodes,
    strain_of_tension,
)
from .dalembert import LinearRelease
from .drag_line import DragLine, drag_line
from .envelope import Envelope, EnvelopePiece, lower_convex_envelope
from .ideal_highline import IdealHighline
from .law import Law, inverse_tension, released_strain
from .ramp import RampedRelease, ramped_release
from .rod import HangingRod
from .vibration import (
    STANDARD_GRAVITY,
    elastic_pendulum_periods,
    hanging_chain_frequencies,
    irvine_parameter,
    pendulum_period,
    rod_frequencies,
    sagged_cable_frequencies,
    string_frequencies,
)
from .waves import ReleaseWave, WavePiece, release_wave

__all__ = [
    "STANDARD_GRAVITY",
    "Catenary",
    "ChainShape",
    "DragLine",
    "Envelope",
    "EnvelopePiece",
    "HangingRod",
    "IdealHighline",
    "Law",
    "LinearRelease",
    "RampedRelease",
    "ReleaseWave",
    "StrainOfTension",
    "WavePiece",
    "beam_frequencies",
    "cantilever_deflection",
    "drag_line",
    "elastic_catenary",
    "elastic_pendulum_periods",
    "hanging_chain_frequencies",
    "hanging_nodes",
    "inverse_tension",
    "irvine_parameter",
    "linear_strain",
    "lower_convex_envelope",
    "pendulum_period",
    "pinned_nodes",
    "ramped_release",
    "release_wave",
    "released_strain",
    "rod_frequencies",
    "rolled_beam",
    "sagged_cable_frequencies",
    "simply_supported_deflection",
    "strain_of_tension",
    "string_frequencies",
    "tensioned_beam_frequencies",
    "tip_loaded_cantilever",
]

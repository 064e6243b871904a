"""Closed forms and exact waves that judge the engine; imports nothing else of lumpedcable.

Every answer here is a closed form, a quadrature, a root or a wave by characteristics: none of it
shares a line of code with the lumped-mass model. Inputs and results are SI numbers and NumPy
arrays. What describes a problem must be finite, else a ValueError tells which number is not (EA may
be inf for a line that does not stretch); positions and times at which a solution is asked for may be
NaN.
"""

from .beam import (
    beam_frequencies,
    cantilever_deflection,
    rolled_beam,
    simply_supported_deflection,
    tensioned_beam_frequencies,
    tip_loaded_cantilever,
)
from .cargo import (
    StraightHighline,
    loaded_from_length,
    loaded_from_tension,
    straight_from_length,
    straight_from_tension,
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
from .dragged import dragged_from_length, dragged_from_tension
from .envelope import Envelope, EnvelopePiece, lower_convex_envelope
from .highline import (
    Highline,
    highline_from_length,
    highline_from_sag,
    highline_from_tension,
    least_tension,
)
from .ideal_highline import IdealHighline
from .law import Law, inverse_tension, released_strain
from .ramp import RampedRelease, ramped_release
from .relaxing import RelaxingRelease
from .rod import HangingRod
from .stages import STAGES, Slider, Stage, StageShape, stage_shape
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
    "STAGES",
    "STANDARD_GRAVITY",
    "Catenary",
    "ChainShape",
    "DragLine",
    "Envelope",
    "EnvelopePiece",
    "HangingRod",
    "Highline",
    "IdealHighline",
    "Law",
    "LinearRelease",
    "RampedRelease",
    "RelaxingRelease",
    "ReleaseWave",
    "Slider",
    "Stage",
    "StageShape",
    "StraightHighline",
    "StrainOfTension",
    "WavePiece",
    "beam_frequencies",
    "cantilever_deflection",
    "drag_line",
    "dragged_from_length",
    "dragged_from_tension",
    "elastic_catenary",
    "elastic_pendulum_periods",
    "hanging_chain_frequencies",
    "hanging_nodes",
    "highline_from_length",
    "highline_from_sag",
    "highline_from_tension",
    "inverse_tension",
    "irvine_parameter",
    "least_tension",
    "linear_strain",
    "loaded_from_length",
    "loaded_from_tension",
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
    "stage_shape",
    "straight_from_length",
    "straight_from_tension",
    "strain_of_tension",
    "string_frequencies",
    "tensioned_beam_frequencies",
    "tip_loaded_cantilever",
]

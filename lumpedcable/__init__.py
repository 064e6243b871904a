"""lumpedcable: cable dynamics for violent, short, nonlinear events.

A vectorised lumped-mass engine on JAX, integrated by diffrax and checked against exact answers.
Importing this package is cheap: jax is loaded only by the parts that compute.

    import lumpedcable as lc

    result = lc.run("configs/snapback.toml", pretension=[45e3, 90e3])
"""

from typing import TYPE_CHECKING, Any

import lumpedcable.sources  # which code this is, before anybody changes it
import lumpedcable.timings  # noqa: F401 (its clock begins here)

__version__ = "0.1.0"
_FITS = (
    "Dependence",
    "Fit",
    "FoundNumber",
    "Sensitivity",
    "fit",
    "fit_ropes",
    "response",
    "sensitivity",
)
_MODES = ("NaturalModes", "modes")
__all__ = [
    "Dependence",
    "Figures",
    "Fit",
    "FoundNumber",
    "NaturalModes",
    "OutputError",
    "Page",
    "Result",
    "ResultError",
    "SceneError",
    "Sensitivity",
    "__version__",
    "fit",
    "fit_ropes",
    "modes",
    "open",
    "response",
    "run",
    "sensitivity",
]

if TYPE_CHECKING:
    from lumpedcable.api import (
        Figures,
        OutputError,
        Page,
        Result,
        ResultError,
        SceneError,
        open,
        run,
    )
    from lumpedcable.fits import (
        Dependence,
        Fit,
        FoundNumber,
        Sensitivity,
        fit,
        fit_ropes,
        response,
        sensitivity,
    )
    from lumpedcable.vibrations import NaturalModes, modes


def __getattr__(name: str) -> Any:
    # loaded when first asked for, so that `lumpedcable --help` need not wait for it
    if name in _FITS:
        from lumpedcable import fits

        return getattr(fits, name)
    if name in _MODES:
        from lumpedcable import vibrations

        return getattr(vibrations, name)
    if name in __all__:
        from lumpedcable import api

        return getattr(api, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)

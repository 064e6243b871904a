"""Natural modes from Python: what the command `modes` finds, as an object.

    import lumpedcable as lc

    found = lc.modes("configs/sagged-cable.toml")
    found.frequency, found.shapes["cable"]
    found.plot("pictures")

Everything that takes time to import is imported when it is used.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lumpedcable.api import study_with_run
from lumpedcable.shown import Drawn, Figures

if TYPE_CHECKING:
    from lumpedcable.scene import Study
    from lumpedcable.solve.modal import Modes
    from lumpedcable.solve.modal_bodies import RigidMotion
    from lumpedcable.view import ModeShapes

__all__ = ["NaturalModes", "modes", "study_modes"]


class NaturalModes(Drawn):
    """The lowest natural modes of a scene about its static equilibrium; k modes.

    Attributes:
        title: the scene's title, and which run of its sweep this is.
        square: omega^2 (rad2/s2), (k,), the lowest first; negative where the equilibrium is unstable.
        frequency: omega / 2 pi (Hz), (k,), 0 where nothing resists a mode and NaN where it is unstable.
        damping: share of critical damping to first order (-), (k,), NaN where a mode does not swing by
            itself; None where nothing damps small motions.
        nodes: places at rest by line, (nodes, 3) in m.
        shapes: displacements by line, (k, nodes, 3); the largest of each mode is 1.
        bodies: how rigid bodies and trolleys move, by name.
        mass: phi . M phi of those shapes (kg), (k,).
    """

    def __init__(self, study: Study, run: int, found: Modes, asked: int) -> None:
        from lumpedcable.study.modes_report import heading

        self._study, self._run, self._found, self._asked = study, run, found, asked
        self.title: str = heading(study, run)
        self.square: NDArray[np.float64] = found.square
        self.frequency: NDArray[np.float64] = found.frequency
        self.damping: NDArray[np.float64] | None = found.damping
        self.nodes: dict[str, NDArray[np.float64]] = found.nodes
        self.shapes: dict[str, NDArray[np.float64]] = found.shapes
        self.bodies: dict[str, RigidMotion] = found.rigid
        self.mass: NDArray[np.float64] = found.mass

    @property
    def remarks(self) -> list[str]:
        """What is to be known of all modes, in words: what they are about, and what takes no part."""
        from lumpedcable.study.modes_report import conditions

        return conditions(self._study, self._run, self._found)

    def report(self) -> None:
        """Print what `lumpedcable modes` prints."""
        from lumpedcable.study.modes_report import modes_table

        modes_table(self._study, self._run, self._found, self._asked)

    def save(self, folder: str | Path) -> list[Path]:
        """Write modes.json, and return the files made.

        Raises:
            OutputError: it cannot be written there.
        """
        from lumpedcable.results.modes import write_modes
        from lumpedcable.study.modes_report import modes_contents

        target = Path(folder) / "modes.json"
        write_modes(target, *modes_contents(self._study, self._run, self._found))
        return [target]

    def figures(self) -> Figures:
        """The panels of `lumpedcable modes`."""
        from lumpedcable.view import mode_figure

        return Figures(modes=mode_figure(self._shown(), self._heading))

    def _drawn(self, folder: Path, formats: Sequence[str]) -> list[Path]:
        from lumpedcable.view import plot_modes

        return plot_modes(self._shown(), self._heading, folder / "modes", formats)

    @property
    def _heading(self) -> str:
        return f"Natural modes: {self.title}"

    def _shown(self) -> ModeShapes:
        from lumpedcable.study.modes_report import shown
        from lumpedcable.view import ModeShapes

        return ModeShapes(*shown(self._found))

    def __repr__(self) -> str:
        told = ", ".join(f"{frequency:.4g}" for frequency in self.frequency[:3])
        more = ", ..." if self.frequency.size > 3 else ""
        return f"NaturalModes({self.title}: {told}{more} Hz)"


def modes(
    scene: str | Path,
    changes: Mapping[str, Any] | None = None,
    *,
    count: int = 10,
    run: int = 0,
    **more: Any,
) -> NaturalModes:
    """The lowest natural modes of a scene about its static equilibrium.

    Args:
        scene: scene file (TOML).
        changes: other values by key, as in `run`.
        count: how many modes, the lowest first.
        run: which run of a sweep, from 0.
        more: changes whose key is one word.

    Raises:
        SceneError: the scene or a change is wrong, or nothing in it can move.
        NoEquilibriumError: no state of rest was found; a ValueError, whose text says what to do.
        ValueError: the scene has no such run, or `count` is no whole number of at least 1.
    """
    if not isinstance(count, Integral) or count < 1:
        raise ValueError(f"count: expected a whole number of at least 1, found {count!r}")
    return study_modes(study_with_run(scene, changes, more, run), count, run)


def study_modes(study: Study, count: int, run: int) -> NaturalModes:
    """The same of a run of a study that is loaded."""
    from lumpedcable.study.modes import find_modes

    return NaturalModes(study, run, find_modes(study, count, run), count)

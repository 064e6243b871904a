"""What results are shown as: pages and figures, in a notebook or in files."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, overload

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Drawn", "Figures", "Page"]


class Page:
    """A page that shows itself in a notebook, and can be written to a file."""

    def __init__(self, text: str, height: int = 640) -> None:
        self.text: str = text
        self.height: int = height

    def _repr_html_(self) -> str:
        import html

        return (
            f'<iframe srcdoc="{html.escape(self.text, quote=True)}" '
            f'style="width: 100%; height: {self.height}px; border: 0"></iframe>'
        )

    def save(self, path: str | Path) -> Path:
        """Write it as one HTML file that works offline.

        Raises:
            OutputError: it cannot be written there.
        """
        from lumpedcable.page.document import save

        save(self.text, Path(path))
        return Path(path)


class Figures(dict[str, "Figure"]):
    """Figures by name, which a notebook shows one below the other."""

    def _repr_html_(self) -> str:
        import base64
        import html
        import io

        shown = []
        for name, figure in self.items():
            picture = io.BytesIO()
            figure.savefig(picture, format="png", dpi=110)
            data = base64.b64encode(picture.getvalue()).decode()
            words = html.escape(name, quote=True)
            shown.append(f'<img alt="{words}" src="data:image/png;base64,{data}">')
        return "<br>".join(shown)


class Drawn(ABC):
    """What has figures: given back, or written to a folder."""

    @abstractmethod
    def figures(self) -> Figures:
        """The figures by name."""

    @abstractmethod
    def _drawn(self, folder: Path, formats: Sequence[str]) -> list[Path]:
        """Write the figures and return the files made."""

    @overload
    def plot(self, folder: None = None, formats: Sequence[str] = ("png",)) -> Figures: ...
    @overload
    def plot(self, folder: str | Path, formats: Sequence[str] = ("png",)) -> list[Path]: ...
    def plot(
        self, folder: str | Path | None = None, formats: Sequence[str] = ("png",)
    ) -> Figures | list[Path]:
        """The figures that the command of the same job draws.

        Args:
            folder: where to write them; None gives them back instead, as a notebook shows them.
            formats: any of "png", "pdf", "svg".

        Returns:
            The paths written, or the matplotlib figures by name.

        Raises:
            ResultError: there is nothing to draw.
            OutputError: they cannot be written there.
        """
        formats = (formats,) if isinstance(formats, str) else formats
        return self.figures() if folder is None else self._drawn(Path(folder), formats)

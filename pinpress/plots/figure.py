"""The figure that all plots return: Matplotlib's, which notebooks show where it is the last line of a cell, without pyplot."""

from __future__ import annotations

import io

from matplotlib.figure import Figure


class NotebookFigure(Figure):
    """A figure of Matplotlib that is a picture in notebooks."""

    def _repr_png_(self) -> bytes:
        """The bytes of a PNG file, which IPython asks for."""
        drawn = io.BytesIO()
        self.savefig(drawn, format="png", dpi=110)
        return drawn.getvalue()

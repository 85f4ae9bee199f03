"""Plots for papers: Matplotlib figures in the width of a text column.

    pp.plots.save(pp.plots.draw(reactions, "torque", "bearings"), "torque.svg")
    pp.plots.save(pp.plots.draw(reactions, "polar A", "polar D"), "polar.pdf")
    pp.plots.draw(after, "torque", "shaking", "peaks", before=before)  # of two presses
    pp.plots.draw({"idle": idle, "pressing": pressing}, "torque").axes[0].set_title("torque")  # a figure can be changed before it is saved
    pp.plots.draw(reactions, "torque", ax=axes)  # on axes at hand, one for each chart

Signs and axes are those of `Reactions`; units are chosen by size. Every function raises `PinpressError` where Matplotlib is not installed
(``pip install 'pinpress[plots]'``) or a value is not finite.
"""

from ..common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)

"""Plots for papers: Matplotlib figures in the width of a text column.

    pp.plots.save(pp.plots.torque(reactions), "torque.svg")
    pp.plots.save(pp.plots.polar(reactions, "A", "D"), "polar.pdf")
    pp.plots.slide(motion).axes[0].set_title("slide")  # a figure can be changed before it is saved
    pp.plots.torque(reactions, ax=pp.plots.slide(motion).axes[0])  # on axes at hand, several where a plot draws several charts

Signs and axes are those of `Reactions`; units are chosen by size. Every function raises `PinpressError` where Matplotlib is not installed
(``pip install 'pinpress[plots]'``) or a value is not finite.
"""

from ..common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)

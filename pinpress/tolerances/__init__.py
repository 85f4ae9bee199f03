"""The accuracy of a press: how the tolerances of its dimensions scatter its bottom dead centre, and which dimension matters most.

    rod = pp.tolerances.link_length(press, "E", "F", 50e-6)
    shaft = pp.tolerances.pin_position(press, "A", "x", 100e-6, shape="uniform")
    found = pp.tolerances.bottom_dead_centre(press, [rod, shaft])
    print(found)  # the band of 99.73 % of the presses, worst cases, the dimensions with their shares
    found.within(50e-6)  # share of the presses whose bottom dead centre is within 0.05 mm

A `Dimension` is a direction in which pivots move, with its tolerance. Each of 100 000 presses is closed with its own lengths. First-order
results are named as such. `play`, `heat` and `budget` compute the shifts by clearances, temperatures and springs while the press runs.
`parallelism` computes the tilt of a slide on several points.
"""

from ..common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)

"""Load cases of a link for a finite element program: forces, moments, gravity and inertia in the link's axes, which are in balance.

    cases = pp.fe.load_cases(press, reactions, link="rod", at="peak F")
    print(cases)  # every force, and the residual of the balance
    cases.to_csv("rod.csv")  # N, mm, t, s

`cases.write_inp("rod_cases.inp", mesh="rod.inp", nodes={"E": 1, "F": 2})` writes them for CalculiX and Abaqus.

Link axes are those of the link's own frame: in a table of pins x points to the second pin, y away from the reader, z left of x.
"""

from ..common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)

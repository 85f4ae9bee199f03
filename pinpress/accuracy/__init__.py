"""Error against run time of all engines and methods for a press.

    measured = pp.accuracy.compare(press, 70 * pp.RPM, repeats=1, points=36, scenes=["free run"])
    print(measured)
    measured.fastest("free run", error=1e-6)  # of every method the fastest row that is as accurate
    pp.plots.save(pp.accuracy.plot(measured), "accuracy.png")

Every error is measured against a reference on which two independent methods agree; `Group.certificate` says how closely.
"""

from ..common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)

"""A press out of Python: as a table that answers one state in microseconds, as C, as an FMU for simulation tools, and as MATLAB.

    table = pp.export.tabulate(press, bearings=press.bearings[:1])
    state = table.at(1.2, 7.3, 0.0, force=1e6)
    state.driving_torque, state.bearing_force[press.bearings[0]]
    pp.export.c_code(table, "press.c")  # and press.h
    pp.export.fmu(table, "press.fmu")
    pp.export.matlab(table, "press.m")

They run where there is no Python.
"""

from ..common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)

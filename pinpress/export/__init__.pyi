from .c_code import c_code as c_code
from .fmu import fmu as fmu
from .matlab import matlab as matlab
from .tables import PressTable as PressTable
from .tables import TableState as TableState
from .tables import tabulate as tabulate

from .c_source import c_code as c_code
from .fmi import fmu as fmu
from .m_file import matlab as matlab
from .tables import PressTable as PressTable
from .tables import TableState as TableState
from .tabulation import tabulate as tabulate

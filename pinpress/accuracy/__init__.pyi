from .work_precision import Group as Group
from .work_precision import Measurement as Measurement
from .work_precision import WorkPrecision as WorkPrecision
from .work_precision import compare as compare
from .work_precision import plot as plot

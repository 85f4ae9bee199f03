from .diagram import plot as plot
from .measurements import Measurement as Measurement
from .measurements import WorkPrecision as WorkPrecision
from .work_precision import compare as compare

from .measurements import Measurement as Measurement
from .measurements import WorkPrecision as WorkPrecision
from .measurements import plot as plot
from .page import report as report
from .work_precision import compare as compare

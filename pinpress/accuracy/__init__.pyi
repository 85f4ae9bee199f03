from .measurements import Accuracy as Accuracy
from .measurements import Measurement as Measurement
from .plots import plot_accuracy as plot_accuracy
from .work_precision import accuracy as accuracy

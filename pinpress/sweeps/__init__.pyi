from .operating_points import operating_points as operating_points
from .operating_result import OperatingPoints as OperatingPoints
from .result import FailedPoint as FailedPoint
from .result import Sweep as Sweep
from .sweeping import read as read
from .sweeping import sweep as sweep

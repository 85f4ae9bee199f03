from .experiments import full_factorial as full_factorial
from .experiments import latin_hypercube as latin_hypercube
from .operating_map import OperatingMap as OperatingMap
from .operating_map import operating_points as operating_points
from .sweeping import FailedPoint as FailedPoint
from .sweeping import Sweep as Sweep
from .sweeping import read as read
from .sweeping import sweep as sweep

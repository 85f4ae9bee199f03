from .motion import MotionSensitivity as MotionSensitivity
from .motion import motion_derivatives as motion_derivatives
from .motion import pivot_positions as pivot_positions
from .reshape import reshaped as reshaped

from .acceleration import AccelerationSensitivity as AccelerationSensitivity
from .acceleration import acceleration_derivatives as acceleration_derivatives
from .motion import MotionSensitivity as MotionSensitivity
from .motion import motion_derivatives as motion_derivatives
from .motion import pivot_positions as pivot_positions
from .reshape import reshaped as reshaped

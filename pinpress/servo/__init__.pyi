from .drive import ServoDrive as ServoDrive
from .motion import ServoMotion as ServoMotion
from .motion import evaluate as evaluate
from .paths import Pendulum as Pendulum
from .paths import Pulse as Pulse
from .paths import Stop as Stop
from .paths import Turn as Turn

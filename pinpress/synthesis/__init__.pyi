from .synthesis import Synthesis as Synthesis
from .synthesis import synthesise as synthesise
from .trial import Trial as Trial

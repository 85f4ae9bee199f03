from .result import SynthesisResult as SynthesisResult
from .synthesis import synthesise as synthesise
from .trial import Trial as Trial

from .design import Trial as Trial
from .synthesis import SynthesisResult as SynthesisResult
from .synthesis import synthesise as synthesise

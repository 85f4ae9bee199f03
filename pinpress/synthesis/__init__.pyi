from .design import Trial as Trial
from .pareto_curve import DesignTradeOff as DesignTradeOff
from .pareto_curve import trade_off as trade_off
from .synthesis import SynthesisResult as SynthesisResult
from .synthesis import synthesise as synthesise

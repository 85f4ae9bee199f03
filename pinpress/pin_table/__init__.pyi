from .building import DrawnPress as DrawnPress
from .building import draft as draft
from .dependence import dimension as dimension
from .rods import rods as rods

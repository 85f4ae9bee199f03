from .building import DrawnPress as DrawnPress
from .building import draft as draft
from .dependence import dimension as dimension
from .rod_sections import rods as rods

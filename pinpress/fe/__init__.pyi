from .link_loads import LinkLoads as LinkLoads
from .link_loads import load_cases as load_cases

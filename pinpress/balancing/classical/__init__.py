"""The classical arrangements that balance a rotor or a crank press; `pinpress.balancing.classical.<function>`."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

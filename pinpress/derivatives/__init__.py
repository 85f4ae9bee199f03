"""Exact derivatives of motion and forces by lengths and pivots, and linkages with other lengths."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

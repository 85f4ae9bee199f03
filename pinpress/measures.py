"""Measures of a motion, its forces and a run, in which requirements on a press are stated."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub("pinpress", __file__)

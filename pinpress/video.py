"""Films and pictures of recordings, made with a browser."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub("pinpress", __file__)

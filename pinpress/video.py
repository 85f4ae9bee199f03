"""Films and pictures of recordings, made with a browser and without a window.

    page = pp.record(press, motion, "press.html", reactions=reactions)
    pp.video.image(page, "press.png", time=0.2)  # s from the start of the recording
    pp.video.film(page, "press.mp4", slowdown=5)

They need Chromium or Chrome, and ``pip install 'pinpress[video]'``. A report is filmed like a recording.
"""

from .common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)

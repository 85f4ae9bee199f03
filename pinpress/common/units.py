"""Units beside the SI units."""

from __future__ import annotations

import numpy as np

RPM = 2 * np.pi / 60
"""One revolution per minute [rad/s]: `speed=70 * pp.RPM`."""

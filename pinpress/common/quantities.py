"""Types of arrays, and units beside the SI units."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


RPM = 2 * np.pi / 60
"""One revolution per minute [rad/s]: `speed=70 * pp.RPM`."""

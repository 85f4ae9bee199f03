"""Units beside the SI units."""

from __future__ import annotations

import numpy as np

RPM = 2 * np.pi / 60  # one revolution a minute [rad/s]

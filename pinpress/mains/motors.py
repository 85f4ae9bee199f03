"""Induction motors of a catalogue, and their start from rest.

A catalogue is a CSV file with a row for each motor. Heads may name other units. The column of the frequency may be left out.

    motor, rated power [kW], rated speed [r/min], breakdown ratio, inertia [kg m2], frequency [Hz]
    132S-4, 5.5, 1455, 2.5, 0.018, 50
"""

from __future__ import annotations

import math
import os
from typing import NamedTuple

from ..common.errors import PinpressError, caution
from ..common.reading.columns import Wanted, read_columns
from ..drives.motors import InductionMotor

MAINS = 50.0  # frequency of a catalogue that names none [Hz], that of `InductionMotor`
QUICK = 1e-3  # in which no motor turns its own rotor up to speed by its rated torque [s]: 0.01 to 1 s are usual
CATALOGUE = {
    "motor": Wanted(),
    "rated power": Wanted("W"),
    "rated speed": Wanted("rad/s"),
    "breakdown ratio": Wanted("-", bare="-"),
    "inertia": Wanted("kg m2"),
    "frequency": Wanted("Hz", needed=False),
}


def read_motors(path: str | os.PathLike[str]) -> dict[str, InductionMotor]:
    """Read the motors of a catalogue by their names: a CSV file with a row for each motor, and these heads (units may differ).

        motor, rated power [kW], rated speed [r/min], breakdown ratio, inertia [kg m2], frequency [Hz]

    The frequency may be left out; it is then 50 Hz. The number of poles follows from the rated speed: the synchronous speed is the next one
    above.

    Raises:
        PinpressError: the file cannot be read, does not have these columns, or has no motor; the message names the row.

    Warns:
        PinpressWarning: the rated power is far too large for the inertia, as W under a head in kW.
    """
    table = read_columns(path, CATALOGUE)
    motors: dict[str, InductionMotor] = {}
    for line, row in table.rows():
        name, speed, frequency = row["motor"], row["rated speed"], row.get("frequency", MAINS)
        where = f"{table.file}, line {line}"
        if not name or name in motors:
            problem = f"{name} is there twice" if name else "the row does not name a motor"
            raise PinpressError(f"{where}: {problem}; give each motor a name of its own")
        frequency = MAINS if math.isnan(frequency) else frequency
        if not 0.0 < speed < 2.0 * math.pi * frequency:
            raise PinpressError(f"{where}: {name}: rated speed is {speed:g} rad/s; give one below that of two poles at {frequency:g} Hz")
        own = row["inertia"] * speed**2 / row["rated power"] if row["rated power"] > 0.0 else 0.0
        if 0.0 < own < QUICK:
            quick = f"{name}: its rated torque turns its own rotor up to speed in {own:.1g} s"
            caution(f"{where}: {quick}: write the rated power in the unit of its head")
        poles = 2 * math.floor(2.0 * math.pi * frequency / speed)
        try:
            motors[name] = InductionMotor(
                row["rated power"], speed, frequency, poles, breakdown_ratio=row["breakdown ratio"], inertia=row["inertia"]
            )
        except PinpressError as error:
            raise PinpressError(f"{where}: {name}: {error}") from None
    if not motors:
        raise PinpressError(f"{table.file} has no row under its heads: write one for each motor")
    return motors


class Start(NamedTuple):
    """A start from rest without load.

    Attributes:
        time: time to the rated speed [s].
        heat: heat in the rotor up to the synchronous speed [J].
    """

    time: float
    heat: float


def start(motor: InductionMotor, inertia: float) -> Start:
    """The start of a motor with an inertia on its shaft, its own included [kg m2], by Kloss's formula: J w' = 2 Tb / (s / sb + sb / s).

    Without load the heat in the rotor is the kinetic energy at the synchronous speed, whatever the torque.
    """
    synchronous = motor.synchronous_speed
    rated, breakdown = 1.0 - motor.rated_speed / synchronous, 1.0 - motor.breakdown_speed / synchronous
    slips = (1.0 - rated**2) / (2.0 * breakdown) - breakdown * math.log(rated)
    return Start(inertia * synchronous / (2.0 * float(motor.breakdown_torque)) * slips, 0.5 * inertia * synchronous**2)

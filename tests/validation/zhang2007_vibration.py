"""Chapter 2 of Zhang 2007: vibration of the frame on 10 mm of rubber, its findings in words beside those of a model.

The thesis prints no data of the frame, so all data of it are assumed here; only findings can be compared.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from pinpress import RPM, Linkage, Motion, PinpressError, Reactions, cycle, foundation, inverse_dynamics, load, simulate
from pinpress.common.quantities import Array
from pinpress.drives import Flywheel
from pinpress.foundation import Attachment, Frame, FrameMotion, Mount, MountedPress, Rotor, RubberPad, SpeedResponse
from pinpress.loads import ConstantForce, PointForce

BED = Frame(mass=8000, centre=(0, 0, -1.0), inertia=(3000, 2500, 3000))
# The crown weighs 7 t with what stands aside on it: the flywheel on the crankshaft's end, whose 940 kg and 136 kg m2 the thesis prints,
# and the motor above it. Of the motor it prints the type, YCT280-4A; 450 kg, both places and that they are bolted on are assumed.
CROWN = Frame(mass=5610, centre=(0, 0.05, 0.42), inertia=(1700, 1700, 1700))
ASIDE = {
    "flywheel": Attachment(Frame(mass=940, centre=(0, 0.75, 0), inertia=(70, 136, 70))),
    "motor": Attachment(Frame(mass=450, centre=(0, 0.9, 0.95), inertia=(20, 10, 20))),
}
ROTORS = [Rotor(inertia=136, axis=(0, -1, 0))]  # the flywheel turns with the crank
PAD = RubberPad(length=0.2, width=0.2, thickness=0.01, hardness=65, loss_factor=0.15, stiffening=1.3)
FEET = tuple((x, y, -1.3) for x in (-0.55, 0.55) for y in (-0.5, 0.6))
# four columns, together 2.4 GN/m: 0.5 mm under 1250 kN
COLUMNS = tuple(Mount((x, y, -0.3), (1e8, 1e8, 6e8), loss_factor=0.02) for x in (-0.55, 0.55) for y in (-0.4, 0.5))
WHOLE = Frame(16000, (0, 0, -0.4), (11e3, 10e3, 5500))  # the frame in one part, for the choice of springs
SPRINGS = tuple(Mount(foot, (1e6, 1e6, 1e6), loss_factor=0.05) for foot in FEET)
UNBALANCE = 940 * 0.04e-3  # unbalance of the flywheel, 940 kg of grade G 1.6 at 400 per min, 40 um eccentric [kg m]
FLYWHEEL = Flywheel(136)
# With 1250 kN, and with 100 kN, feet lift off, where the linear model ends. Vibration is proportional to the force, its decay the same.
PILING = ConstantForce(force=50e3, height=4.86e-5)
SIDES = {"motor's side": ("crown", (-0.6, 0.5, 0.1)), "other side": ("crown", (-0.6, -0.4, 0.1))}  # of the columns
POINTS = {"top beam": ("crown", (0, 0, 0.9)), "column": ("crown", (-0.6, 0.5, 0.1)), "lower beam": (0, 0, -1.1)}
SPEEDS = np.linspace(150, 450, 121) * RPM
WORKING = slice(20, 101)  # those from 200 to 400 per min
PRESSES = {"plain": "jf75g_125_plain", "with its counterweight": "jf75g_125", "symmetric": "jf75g_125_symmetric"}
REAL = "with its counterweight"
AT = 350 * RPM  # speed of the thesis's signals
DURATION = 1.2  # of a run under piling [s]
STEP = 1e-4  # step of a run under piling, a sixtieth of the stretching's period [s]


SAID = (  # places and findings of the thesis, in the order of our answers
    "Fig. 2-7: flywheel alone, 350 per min: vibration very small",
    "Figs. 2-8 to 2-15: idle, to 300 per min: not yet marked; 350: strong",
    "Figs. 2-12 to 2-15: idle: signals like a sine, the machine sways",
    "Figs. 2-12 to 2-15: the top beam moves more than columns and lower beam",
    "Figs. 2-8 to 2-15: the columns on the motor's side move more",
    "Figs. 2-17, 2-18: piling: dies away after every stroke",
    "2.3.4: so the speed is far from the natural frequencies",
    "2.3.4: rubber or springs below keep it from the floor",
)


class VibrationFinding(NamedTuple):
    """A finding of the thesis beside ours, in words.

    Attributes:
        place: figure or section of the thesis.
        says: what the thesis finds.
        gives: what the model gives.
        agrees: whether both agree.
    """

    place: str
    says: str
    gives: str
    agrees: str


@dataclass(frozen=True, eq=False)
class Vibration:
    """The presses of the thesis on their mounts and their vibration, computed when first asked for."""

    @cached_property
    def machines(self) -> dict[str, MountedPress]:
        return {name: standing(load(file)) for name, file in PRESSES.items()}

    @cached_property
    def over(self) -> dict[str, SpeedResponse]:
        """Response of each idle press over `SPEEDS`."""
        return {name: foundation.over_speeds(system, SPEEDS, points=POINTS) for name, system in self.machines.items()}

    @cached_property
    def idle(self) -> FrameMotion:
        """One turn of the real press without load."""
        system = self.machines[REAL]
        return foundation.steady_response(system, inverse_dynamics(system.press, cycle(system.press, AT)), points=POINTS)

    @cached_property
    def struck(self) -> FrameMotion:
        """Seven strokes of piling, from rest."""
        system = self.machines[REAL]
        motion = foundation.time_response(system, blows(system, PILING), points=POINTS)
        if not motion.least_load.min() > 0:
            raise PinpressError("a foot lifts off: the linear model does not hold")
        return motion

    def top_beam(self, name: str) -> Array:
        """(speeds,) rms acceleration of the top beam of a press at `SPEEDS` [m/s2]."""
        return np.asarray(np.linalg.norm(self.over[name].rms["top beam"], axis=1))

    def findings(self) -> tuple[VibrationFinding, ...]:
        """The findings of chapter 2, next to ours."""
        answers = (*self._idle_findings(), self._piling(), *self._advice())
        pairs = ((said.partition(": "), answer) for said, answer in zip(SAID, answers, strict=True))
        return tuple(VibrationFinding(place, says, gives, agrees) for (place, _, says), (gives, agrees) in pairs)

    def _idle_findings(self) -> Iterator[tuple[str, str]]:
        alone, moving = _size(flywheel_alone(self.machines[REAL])), _size(self.idle.rms("top beam"))
        yield (
            f"{alone:.2g} m/s² rms on the top beam, {moving / alone:.0f} times less than with the slide",
            "yes",
        )
        two, three, most = np.interp((200, 300, 350), SPEEDS / RPM, self.top_beam(REAL))
        yield (
            f"{three / two:.1f} times from 200 to 300 (square of the speed: 2.25), {most / three:.1f} times from 300 to 350 (1.36)",
            "yes, with these pads",
        )
        across = self.idle.rms("top beam")[0] / moving
        yield (
            f"higher harmonics {100 * _distortion(self.idle):.2g} % of the first on the top beam; {across:.3f} of it along x, across"
            " the machine",
            "yes",
        )
        places = ", ".join(f"{point} {_size(self.idle.rms(point)):.3f}" for point in POINTS)
        yield (f"{places} m/s²", "yes, a little")
        both = foundation.over_speeds(self.machines[REAL], np.array([300, 350]) * RPM, points=SIDES).rms
        more = 100 * (np.divide(*(np.linalg.norm(both[side], axis=1) for side in SIDES)) - 1)
        yield (
            f"{more[0]:+.1f} % at 300 per min, {more[1]:+.1f} % at 350: motor and flywheel shift the centre of mass to their side, and"
            " near the resonance of the sway its inertia twists the frame",
            "at 350 a little, at 300 no: forces of the drive, which the thesis suspects, are not in the model",
        )

    def _piling(self) -> tuple[str, str]:
        seen, damped = _decay(self.machines[REAL], self.struck)
        return (
            f"logarithmic decrement of the stretching {seen:.3f}, of the mode's damping {damped:.3f}",
            "yes",
        )

    def _advice(self) -> Iterator[tuple[str, str]]:
        modes = foundation.modes(self.machines[REAL])
        lowest, stretching = (modes.natural_frequency[k] / (2 * np.pi) for k in (0, modes.motion.index("stretching")))
        yield (
            f"lowest {lowest:.2f} Hz, {60 * lowest:.0f} per min",
            f"no: what rings is the stretching, at {stretching:.0f} Hz",
        )
        soft = foundation.isolate(self.machines["plain"].press, WHOLE, SPRINGS, speeds=SPEEDS[WORKING], transmitted=0.6)
        through = self.over["plain"].transmitted[: WORKING.stop].max()
        yield (
            f"rubber of 10 mm: {through:.2f} of the shaking force of the plain press comes through at most; for 0.6 between 200 and 400"
            f" per min: {soft.stiffness[2] / 1e6:.2f} MN/m together, {1e3 * soft.sag:.0f} mm of sag",
            "springs yes, this rubber no",
        )


def standing(press: Linkage, pad: RubberPad = PAD) -> MountedPress:
    """A press in the assumed frame, on four pads."""
    feet = [foundation.pad_mount(foot, pad) for foot in FEET]
    return foundation.mounted(press, BED, feet, crown=CROWN, uprights=COLUMNS, attached=ASIDE, rotors=ROTORS)


def blows(system: MountedPress, piling: ConstantForce) -> Reactions:
    """Seven strokes of piling from full speed."""
    run = simulate(system.press, DURATION, speed=AT, flywheel=FLYWHEEL, loads=[piling], points=round(DURATION / STEP) + 1)
    return inverse_dynamics(system.press, run, loads=[piling])


def flywheel_alone(system: MountedPress) -> Array:
    """(3,) rms acceleration of the top beam of a press at rest by the flywheel's unbalance, a force that turns in the x-z plane [m/s2]."""
    still = system.press.with_inertias([pin.Inertia.Zero() for _ in system.press.model.inertias])

    def force(motion: Motion) -> Array:
        angle = motion.crank_angle
        return UNBALANCE * AT**2 * np.stack([np.cos(angle), 0 * angle, np.sin(angle)], axis=1)

    # on the crank, whose bearing hands it to the crown
    result = inverse_dynamics(still, cycle(still, AT, points=90), loads=[PointForce("crank", force)])
    return foundation.steady_response(standing(still), result, points=POINTS).rms("top beam")


def _distortion(motion: FrameMotion) -> float:
    """Root of the sum of squares of the higher harmonics of the top beam's acceleration along x, divided by the first harmonic [-]."""
    harmonics = np.abs(np.fft.rfft(motion.acceleration["top beam"][:, 0]))
    return float(np.sqrt((harmonics[2:] ** 2).sum()) / harmonics[1])


def _decay(system: MountedPress, motion: FrameMotion) -> tuple[float, float]:
    """Logarithmic decrement of the stretching, from the signal in five periods after a blow, and from the mode's damping ratio."""
    modes = foundation.modes(system)
    place = modes.motion.index("stretching")
    modal = motion.coordinates @ (system.mass @ modes.shapes[:, place])
    blow = np.abs(motion.acceleration["top beam"][:, 2])
    begin = int(blow[: len(blow) // 2].argmax()) + round(2.5e-3 / STEP)
    ringing = modal[begin : begin + int(5 * 2 * np.pi / modes.natural_frequency[place] / STEP)]
    ratio = float(modes.damping_ratio[place])
    return foundation.logarithmic_decrement(ringing - ringing.mean()), 2 * np.pi * ratio / np.sqrt(1 - ratio**2)


def _size(vector: Array) -> float:
    return float(np.linalg.norm(vector))

"""The textbook crank-slider of any proportions: its URDF, and all that is known of it in closed form, without pinpress.

Crank angle q from bottom dead centre, positive turning x towards z; the slide moves along z, below the crankshaft at the origin. SI units.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from extremes.extreme_case import CLOSE, Outcome, largest, loaded, worst
from scipy.integrate import quad, solve_ivp

import pinpress as pp

BODY = (
    '<link name="{0}"><inertial><origin xyz="0 0 {1!r}"/><mass value="{2!r}"/>'
    '<inertia ixx="{3!r}" ixy="0" ixz="0" iyy="{3!r}" iyz="0" izz="{3!r}"/></inertial></link>'
)
TEXT = """<robot name="crank_slide"><link name="frame"/>
  {crank} {rod} {slide}
  <joint name="O" type="continuous"><parent link="frame"/><child link="crank"/><axis xyz="0 -1 0"/></joint>
  <joint name="P" type="continuous"><parent link="crank"/><child link="rod"/><origin xyz="0 0 {p!r}"/><axis xyz="0 -1 0"/></joint>
  <joint name="slide_guide" type="prismatic"><parent link="frame"/><child link="slide"/><origin xyz="0 0 {drawn!r}"/><axis xyz="0 0 1"/>
    <limit lower="-1e9" upper="1e9" effort="1e9" velocity="1e9"/></joint>
  <loop_joint name="W" type="spherical"><link1 link="rod" xyz="0 0 {w!r}"/><link2 link="slide" xyz="0 0 0"/></loop_joint>
  <transmission name="drive"><joint name="O"/></transmission>
</robot>
"""


@dataclass(frozen=True)
class CrankSlider:
    """Lengths of crank and rod [m]; masses [kg], centres of mass as shares of the lengths from O and P, and moments about them [kg m2].

    With a rod as long as the crank it is the assembly that is drawn, with the slide moving on below the crankshaft as -2 r cos q.
    """

    crank: float = 0.1
    rod: float = 0.4
    crank_mass: float = 20.0
    rod_mass: float = 15.0
    slide_mass: float = 100.0
    crank_inertia: float = 0.1
    rod_inertia: float = 0.2
    crank_centre: float = 0.3
    rod_centre: float = 0.5
    gravity: float = 9.81

    def press(self) -> pp.Linkage:
        return loaded(self.text(), (0.0, 0.0, -self.gravity))

    def text(self, drawn_off: float = 0.0) -> str:
        """The URDF; ``drawn_off``: how far above its place the slide is drawn, its loop open by that [m]."""
        return TEXT.format(
            crank=BODY.format("crank", -self.crank_centre * self.crank, self.crank_mass, self.crank_inertia),
            rod=BODY.format("rod", -self.rod_centre * self.rod, self.rod_mass, self.rod_inertia),
            slide=BODY.format("slide", 0.0, self.slide_mass, 1.0),
            p=-self.crank,
            w=-self.rod,
            drawn=-self.crank - self.rod + drawn_off,
        )

    # Of crank angles, one or an array, complex ones too: `slope` differentiates by them.

    def swing(self, q: Any) -> Any:
        """-d(angle of the rod)/dq: r cos q by the height of the rod, of which nothing is subtracted that would cancel."""
        if self.crank == self.rod:
            return 1.0 + 0.0 * q
        across = self.crank * np.cos(q)
        return across / np.sqrt((self.rod - self.crank) * (self.rod + self.crank) + across * across)

    def slide(self, q: Any) -> Any:
        across = self.crank * np.cos(q)
        if self.crank == self.rod:
            return -2 * across
        return -across - np.sqrt((self.rod - self.crank) * (self.rod + self.crank) + across * across)

    def lever(self, q: Any) -> Any:
        return self.crank * np.sin(q) * (1 + self.swing(q))

    def inertia(self, q: Any) -> Any:
        rest, lever = 1 - self.rod_centre, self.lever(q)
        along, up = rest * self.crank * np.cos(q), rest * self.crank * np.sin(q) + self.rod_centre * lever
        crank = self.crank_inertia + self.crank_mass * (self.crank_centre * self.crank) ** 2
        return crank + self.rod_mass * (along * along + up * up) + self.rod_inertia * self.swing(q) ** 2 + self.slide_mass * lever * lever

    def potential(self, q: Any) -> Any:
        rod = (1 - self.rod_centre) * -self.crank * np.cos(q) + self.rod_centre * self.slide(q)
        crank = -self.crank_mass * self.crank_centre * self.crank * np.cos(q)
        return self.gravity * (crank + self.rod_mass * rod + self.slide_mass * self.slide(q))

    def torque(self, q: Any, w: Any, a: Any) -> Any:
        """By virtual work: I a + I' w^2 / 2 + V'."""
        return self.inertia(q) * a + 0.5 * slope(self.inertia, q) * w * w + slope(self.potential, q)

    def slide_force(self, q: Any, w: Any, a: Any) -> Any:
        """Of the rod on the slide, upwards."""
        return self.slide_mass * (self.lever(q) * a + slope(self.lever, q) * w * w + self.gravity)

    def judge(self, bound: float, size: float = 0.0) -> Callable[[pp.Reactions], Outcome]:
        """Judges motion, torque and the force on the slide, each relative to its peak; forces at least to ``size`` [N]."""

        def judge(result: pp.Reactions) -> Outcome:
            motion = result.motion
            q, w, a = motion.crank_angle, motion.crank_speed, motion.crank_acceleration
            expected = [self.slide(q), self.lever(q) * w, self.lever(q) * a + slope(self.lever, q) * w * w, self.torque(q, w, a)]
            found = [motion.slide_position, motion.slide_velocity, motion.slide_acceleration, result.driving_torque]
            force, errors = self.slide_force(q, w, a), worst(list(zip(found, expected, strict=True)))
            off = float(np.abs(result.bearing_force["W"][:, 2] - force).max()) / max(size, float(np.abs(force).max()))
            return Outcome(largest(errors, off), bound)

        return judge

    def free_run(
        self, flywheel: float, bound: float = CLOSE, more: Callable[[Any], Any] | None = None, at: Sequence[float] = ()
    ) -> Callable[[pp.Run], Outcome]:
        """Judges a run without stop: speeds by the kept energy, and the time by quadrature of 1/speed. ``more``: potential of a load
        over the crank angle [J]; ``at``: crank angles in a turn where the speed has corners. Errors in rad, of speeds by the speed."""

        def judge(run: pp.Run) -> Outcome:
            q, w = run.crank_angle, run.crank_speed
            if (w * w[0] <= 0).any():
                return Outcome(math.inf, bound, f"it turned back at {math.degrees(q[(w * w[0] <= 0).argmax()]):.6g} deg")
            potential = self.potential if more is None else lambda q: self.potential(q) + more(q)
            energy = 0.5 * (self.inertia(q[0]) + flywheel) * w[0] ** 2 + potential(q[0])
            expected = np.sign(w[0]) * np.sqrt(2 * (energy - potential(q)) / (self.inertia(q) + flywheel))
            speeds = np.abs(w / expected - 1).max()

            def pace(q: float) -> float:
                return math.sqrt(float(self.inertia(q) + flywheel) / (2 * float(energy - potential(q))))

            took = lasting(pace, float(q[0]), float(q[-1]), at)
            return Outcome(largest(float(speeds), abs(float((run.time[-1] - took) * w[-1]))), bound)

        return judge

    def integrated(
        self,
        duration: float,
        speed: float,
        angle: float = 0.0,
        flywheel: float = 0.0,
        torque: Callable[[float, float, float], float] | None = None,
        instants: Sequence[float] = (),
    ) -> tuple[float, float]:
        """Crank angle and speed at the end, by SciPy; ``torque`` of (time, angle, speed) on the crank, not smooth at the ``instants``."""

        def rates(t: float, y: Any) -> tuple[float, float]:
            q, w = float(y[0]), float(y[1])
            push = 0.0 if torque is None else torque(t, q, w)
            bend, weight = slope(self.inertia, q), slope(self.potential, q)
            return w, float((push - 0.5 * bend * w * w - weight) / (self.inertia(q) + flywheel))

        y, ends = np.array([angle, speed]), [0.0, *sorted(i for i in instants if 0 < i < duration), duration]
        for begin, end in pairwise(ends):
            y = solve_ivp(rates, (begin, end), y, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        return float(y[0]), float(y[1])


def slope(function: Callable[[Any], Any], q: Any) -> Any:
    """Derivative, exact to rounding: of a step along the imaginary axis nothing is subtracted."""
    return np.imag(function(np.asarray(q) + 1e-40j)) / 1e-40


def lasting(pace: Callable[[float], float], begin: float, end: float, at: Sequence[float] = ()) -> float:
    """The integral of ``pace``, the same in every turn, over crank angles: quarter turn by quarter turn, and from corner to corner ``at``
    (angles within a turn)."""
    low, high = min(begin, end), max(begin, end)
    turns = max(0, math.floor((high - low) / (2 * math.pi)) - 1)
    if turns:
        return turns * lasting(pace, 0.0, 2 * math.pi, at) + lasting(pace, low, high - 2 * math.pi * turns, at)
    places = sorted({0.0, 0.5 * math.pi, math.pi, 1.5 * math.pi, *at})
    around = range(math.floor(low / (2 * math.pi)), math.ceil(high / (2 * math.pi)))
    inner = [x for turn in around for place in places if low < (x := place + 2 * math.pi * turn) < high]
    edges = [low, *inner, high]
    return sum(quad(pace, a, b, epsabs=0.0, epsrel=1e-12, limit=400)[0] for a, b in pairwise(edges))


def spinning(press: pp.Linkage, engine: str, angles: Any, speed: float = 7.0, acceleration: float = 3.0, **more: Any) -> pp.Reactions:
    """Inverse dynamics at crank angles by one engine throughout."""
    motion = pp.servo_cycle(press, speed=speed, angle=angles, acceleration=acceleration, engine=engine)
    return pp.inverse_dynamics(press, motion, engine=engine, **more)

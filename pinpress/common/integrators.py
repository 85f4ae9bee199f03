"""Integrators of differential equations over time, with the interface of SciPy's: Runge-Kutta with a fixed step, and Radau IIA.

Radau IIA with seven stages is implicit, for motions under stiff forces. A disturbance of a stiff damper, speed law or servo dies away
within microseconds, and an explicit method must keep its steps shorter than that for the whole run. Radau IIA is L-stable: its steps are as
long as the smoothness of the solution allows. SciPy's Radau has three stages and an error estimate of order 3, and needs many times as many
steps at the tolerances of a press run. Source: Hairer and Wanner, Solving Ordinary Differential Equations II, IV.5 and IV.8; the
coefficients are computed here from the conditions that define them.
"""

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre
from scipy.integrate import DenseOutput, OdeSolver
from scipy.linalg import lapack

from .numerics import radau_rule
from .quantities import Array

STAGES = 7
ROUNDS = 12  # most rounds of Newton's method in a step
SETTLED = 1e-2  # error that Newton's method may leave, as a share of the tolerance
LOOSER = 100.0  # multiple of the tolerance for integrals along the motion
ROUNDED = 0.5  # share of the tolerance below which a correction may be rounding
ASIDE = (-7e-14, 3e-14)  # relative changes of a state that show how the rates are rounded
EXACT = 1e-15  # rates that are known to this share of themselves are not rounded by forces
ROUNDINGS = 10.0  # multiple of the rounding that stiff forces pass on: no step is shortened for less
SLOWEST = 0.9  # ratio of a correction to the one before above which it does not become smaller
LEAST_CHANGE, MOST_CHANGE = 0.1, 8.0  # factors by which a step may differ from the one before
FASTEST = 0.4  # ratio of a correction to the one before at which Newton's method takes the least time: it grows with the step
FURTHEST = 3.0  # ratio of a step to the one before up to which that one's polynomial is a good first guess
# Change of an entry for a slope, relative to the smaller of itself and its size, and relative to its size where it is zero.
BESIDE, STANDING = 1e-7, 1e-12


# ------------------------------------------------------------------------------------------------------------------ Runge-Kutta, fixed step


class RungeKutta4(OdeSolver):  # type: ignore[misc]
    """The classical Runge-Kutta method of order 4 with a fixed step, interpolated by cubics."""

    t: float
    y: Array

    def __init__(self, fun: Callable[[float, Array], Array], t0: float, y0: Array, t_bound: float, step: float) -> None:
        super().__init__(fun, t0, y0, t_bound, vectorized=False)
        self.fixed, self.f = step, self.fun(t0, self.y)
        self.before = (self.y, self.f)

    def _step_impl(self) -> tuple[bool, str | None]:
        t, y, f = self.t, self.y, self.f
        h = self.fixed if self.t_bound - t > self.fixed * (1 + 1e-9) else self.t_bound - t
        second = self.fun(t + 0.5 * h, y + 0.5 * h * f)
        third = self.fun(t + 0.5 * h, y + 0.5 * h * second)
        fourth = self.fun(t + h, y + h * third)
        self.before = (y, f)
        self.t = self.t_bound if t + h > self.t_bound - 1e-9 * h else t + h
        self.y = y + h / 6 * (f + 2 * (second + third) + fourth)
        self.f = self.fun(self.t, self.y)
        return True, None

    def _dense_output_impl(self) -> DenseOutput:
        return Cubic(self.t_old, self.t, *self.before, self.y, self.f)


class Cubic(DenseOutput):  # type: ignore[misc]
    """The cubic with given values and derivatives at both ends."""

    def __init__(self, t_old: float, t: float, y0: Array, f0: Array, y1: Array, f1: Array) -> None:
        super().__init__(t_old, t)
        self.ends = (y0, f0, y1, f1)

    def _call_impl(self, t: Any) -> Array:
        h = self.t - self.t_old
        s = (np.asarray(t) - self.t_old) / h
        weights = ((1 + 2 * s) * (1 - s) ** 2, h * s * (1 - s) ** 2, s**2 * (3 - 2 * s), h * s**2 * (s - 1))
        parts = [np.multiply.outer(end, weight) for end, weight in zip(self.ends, weights, strict=True)]
        return np.asarray(sum(parts))


# -------------------------------------------------------------------------------------------------------------------------------- Radau IIA


class Method(NamedTuple):
    """Radau IIA of `STAGES` stages with its error estimate.

    Attributes:
        nodes: (s,) of a step, from 0 to 1, the last one at its end.
        matrix: (s, s) from rates at the nodes to their integrals over the step up to each node.
        inverse: (s, s) inverse of the matrix.
        embedded: (s,) weights of the embedded formula less those of the method.
        start: weight of the rate at the start in the embedded formula.
        series: (s + 1, s) from changes at the nodes to the Legendre series over the step of the polynomial through them and zero at the
            start.
        integral: (s + 1, s) from values at the nodes to the Legendre series over the step of the integral of the polynomial through them.
    """

    nodes: Array
    matrix: Array
    inverse: Array
    embedded: Array
    start: float
    series: Array
    integral: Array


@cache
def method() -> Method:
    """The method's coefficients."""
    nodes, _, integral, matrix, _ = radau_rule(STAGES)
    inverse = np.linalg.inv(matrix).astype(np.float64)
    # In the embedded formula of order s the weight of the rate at the start is the inverse of the real eigenvalue of the inverse matrix:
    # its error, filtered by the linear equation with this weight, then agrees with that of the method.
    values = np.linalg.eigvals(inverse)
    start = 1.0 / float(values[np.abs(values.imag).argmin()].real)
    conditions = legendre.legvander(2 * nodes - 1, STAGES - 1).T
    wanted = np.zeros(STAGES)
    wanted[0] = 1.0  # integral of the Legendre polynomials over a step of length 1
    wanted -= start * legendre.legvander(np.array([-1.0]), STAGES - 1)[0]
    embedded = np.linalg.solve(conditions, wanted) - matrix[-1]
    return Method(nodes, matrix, inverse, embedded, start, integral @ inverse, integral)


class RadauIIA(OdeSolver):  # type: ignore[misc]
    """Radau IIA of seven stages, order 13, with steps by error.

    The last ``integrals`` entries of the vector act on no rate: they are integrals along the motion, computed after each step, to `LOOSER`
    tolerances. Steps whose stages do not converge, or reach a state without finite rates, are tried again at a quarter of their length.
    """

    t: float
    y: Array

    def __init__(
        self,
        fun: Callable[[float, Array], Array],
        t0: float,
        y0: Array,
        t_bound: float,
        atol: Array,
        rtol: float,
        integrals: int,
        sizes: Array,
        first_step: float | None = None,
    ) -> None:
        """Begin to integrate.

        Args:
            fun: rates (n,) at a time and vector (n,).
            t0: time at the start [s].
            y0: (n,) vector at the start.
            t_bound: time of the end [s].
            atol: (n,) absolute tolerances of the entries.
            rtol: relative tolerance of the entries.
            integrals: number of entries at the end that are integrals.
            sizes: (n,) of the entries, for slopes where one is zero.
            first_step: length of the first step [s]; None: it is found from the rates.
        """
        super().__init__(fun, t0, y0, t_bound, vectorized=False)
        self.count = len(y0) - integrals
        self.atol, self.rtol, self.sizes = atol.copy(), rtol, sizes[: self.count]
        self.atol[self.count :] *= LOOSER
        self.f = self.fun(self.t, self.y)
        span = t_bound - t0
        self.h_abs = min(span, first_step or self._first_step(span))
        self.before: tuple[float, Array] | None = None  # length of the last step, and changes of its stages (s, m)
        self.error_before: tuple[float, float] | None = None  # length and error of the last step
        self.noise = np.zeros(len(y0))
        self.pace = 0.0  # mean ratio of the last two corrections to those before, in the last step that was tried; 0: too few
        self.stage_rates = np.empty((STAGES, len(y0)))

    def _first_step(self, span: float) -> float:
        """A step over which no entry changes by more than a small part of its size."""
        rate = float(np.max(np.abs(self.f[: self.count]) / self.sizes))
        return min(1e-3 * span, 1e-3 / rate) if rate > 0 and math.isfinite(rate) else 1e-6 * span

    def _step_impl(self) -> tuple[bool, str | None]:
        r, m, t, y = method(), self.count, self.t, self.y
        noise = rounding(self.fun, t, y, self.f)
        slope = slopes(self.fun, t, y, self.f, self.sizes, noise)
        if not np.isfinite(slope).all():
            return False, "the rates beside this state are not finite"
        noise = np.maximum(noise, np.finfo(float).eps * (np.abs(slope) @ np.abs(y[:m])))
        self.noise, jacobian = np.maximum(0.5 * self.noise, noise), slope[:m]
        identity, tolerated, rejected = np.eye(m), self.atol[:m] + self.rtol * np.abs(y[:m]), False
        shortest = 10 * abs(np.nextafter(t, np.inf) - t)
        while True:
            h = min(self.h_abs, self.t_bound - t)
            if self.t_bound - t - h < 0.05 * h:
                h = self.t_bound - t
            if h < min(shortest, self.t_bound - t):
                return False, self.TOO_SMALL_STEP
            smoothing = np.linalg.inv(identity - h * r.start * jacobian)
            scale = np.maximum(tolerated, ROUNDINGS * h * r.start * (np.abs(smoothing) @ self.noise[:m]))
            stages = self._stages(h, jacobian, scale)
            if stages is None:
                # A shorter step converges faster in proportion; the limits keep a step that nearly failed from changing too much.
                self.h_abs = h * max(0.25, min(0.7, FASTEST / max(self.pace, FASTEST)))
                self.before, rejected = None if rejected else self.before, True
                continue
            rates = r.inverse @ stages / h
            change = h * (r.start * self.f[:m] + (r.embedded + r.matrix[-1]) @ rates) - stages[-1]
            filtered = smoothing @ change
            error = float(np.abs(filtered / scale).max())
            if error > 1 and (self.error_before is None or rejected):  # the rate at a start beside the solution counts too much
                moved = self.fun(t, np.append(y[:m] + filtered, y[m:]))[:m]
                change += h * r.start * (moved - self.f[:m])
                filtered = smoothing @ change
                error = float(np.abs(filtered / scale).max())
            summed = np.maximum(self.atol[m:], ROUNDINGS * h * self.noise[m:])
            error = max(error, _unresolved(r.series @ stages, scale), _unresolved(h * (r.integral @ self.stage_rates[:, m:]), summed))
            factor = 0.9 * error ** (-1 / (STAGES + 1)) if error > 0 else MOST_CHANGE  # 1 would just meet the tolerance
            if error > 1:
                self.h_abs, rejected = max(LEAST_CHANGE, factor) * h, True
                continue
            break
        if self.error_before is not None and error > 0:  # Gustafsson: the step that the errors of two steps predict
            length, previous = self.error_before
            factor = min(factor, factor * h / length * (previous / error) ** (1 / (STAGES + 1)))
        if self.pace > FASTEST / factor:
            factor = max(LEAST_CHANGE, FASTEST / self.pace)
        self.error_before = h, max(error, 1e-2)
        after = y.copy()
        after[:m] += stages[-1]
        after[m:] += h * (r.matrix[-1] @ self.stage_rates[:, m:])
        self.before, self.stage_changes = (h, stages), stages
        self.start = y
        self.t = self.t_bound if h == self.t_bound - t else t + h
        self.h_abs = h * min(MOST_CHANGE, max(LEAST_CHANGE, factor if not rejected else min(factor, 1.0)))
        self.y = after
        self.f = self.fun(self.t, after)
        return True, None

    def _stages(self, h: float, jacobian: Array, scale: Array) -> Array | None:
        """Changes (s, m) of the entries up to the nodes, by Newton's method; None if it does not converge."""
        r, m, t, y = method(), self.count, self.t, self.y
        matrix = np.eye(STAGES * m) - h * np.kron(r.matrix, jacobian)
        factors, pivots, info = lapack.dgetrf(matrix)
        if info:
            self.pace = math.inf
            return None
        stages, trial = self._guess(h), y.copy()
        settled, self.pace = False, 0.0
        before, earlier = math.inf, math.inf  # the last corrections
        for done in range(ROUNDS):
            for k in range(STAGES):
                trial[:m] = y[:m] + stages[k]
                self.stage_rates[k] = self.fun(t + r.nodes[k] * h, trial)
            if settled:  # `stage_rates` now are those of the final stages, as the integrals need them
                return stages
            residual = h * (r.matrix @ self.stage_rates[:, :m]) - stages
            if not np.isfinite(residual).all():
                self.pace = math.inf
                return None
            step = lapack.dgetrs(factors, pivots, residual.ravel())[0].reshape(STAGES, m)
            stages = stages + step
            size = float(np.abs(step / scale).max())
            share = size / before
            settled = size <= SETTLED * min(1.0, (1 - share) / share if 0 < share < 1 else 1.0)
            settled |= ROUNDED > size > SLOWEST * before  # what does not become smaller is the rounding of stiff forces
            if size > ROUNDED and earlier < math.inf:
                # An error may pass from one joint to the next before it is gone: two rounds show how fast it falls.
                self.pace = math.sqrt(size / earlier)
                if not settled and size * self.pace ** (ROUNDS - 1 - done) > ROUNDED:
                    return None
            before, earlier = size, before
        return None

    def _guess(self, h: float) -> Array:
        """Changes up to the nodes by the polynomial of the step before."""
        if self.before is None or h > FURTHEST * self.before[0]:
            return np.zeros((STAGES, self.count))
        r, (length, stages) = method(), self.before
        rates = r.inverse @ stages / length
        series = length * (r.integral @ rates)
        beyond = legendre.legvander(1 + 2 * r.nodes * h / length, STAGES)
        return np.asarray(beyond @ series - stages[-1])

    def _dense_output_impl(self) -> DenseOutput:
        r, h = method(), self.t - self.t_old
        rates = np.concatenate([r.inverse @ self.stage_changes / h, self.stage_rates[:, self.count :]], axis=1)
        return Collocated(self.t_old, self.t, self.start, h * (r.integral @ rates))


class Collocated(DenseOutput):  # type: ignore[misc]
    """The polynomial of a step."""

    def __init__(self, t_old: float, t: float, y0: Array, series: Array) -> None:
        super().__init__(t_old, t)
        self.y0, self.series = y0, series

    def _call_impl(self, t: Any) -> Array:
        x = 2 * (np.asarray(t) - self.t_old) / (self.t - self.t_old) - 1
        change = legendre.legval(x, self.series)
        return np.asarray((change.T + self.y0).T if np.ndim(t) else change + self.y0)


def _unresolved(series: Array, scale: Array) -> float:
    """Error of a step's polynomials between its nodes, as a share of the tolerance: the next term of their Legendre series (s + 1, k), if
    the terms go on falling. Under stiff forces the embedded formula shows only the error at the end of the step."""
    last, before = np.abs(series[-1]), np.maximum(np.abs(series[-3]), np.finfo(float).tiny)
    return float((last * np.minimum(1.0, np.sqrt(last / before)) / scale).max(initial=0.0))


def rounding(fun: Callable[[float, Array], Array], time: float, y: Array, f: Array) -> Array:
    """Errors (n,) of rates by rounding, which stiff forces magnify: their distance from a straight line near this state.

    Args:
        fun: rates (n,) at a time and vector (n,).
        time: [s].
        y: (n,) the vector.
        f: (n,) the rates there.
    """
    one, other = ASIDE
    by = one / other
    return np.asarray(np.abs(fun(time, (1 + one) * y) - f - by * (fun(time, (1 + other) * y) - f)) / (1 + abs(by)))


def slopes(fun: Callable[[float, Array], Array], time: float, y: Array, f: Array, sizes: Array, noise: Array) -> Array:
    """Derivatives (n, m) of rates by the first m entries of a vector, by differences.

    Args:
        fun: rates (n,) at a time and vector (n,).
        time: [s].
        y: (n,) the vector.
        f: (n,) the rates there.
        sizes: (m,) of the entries.
        noise: (n,) errors of the rates by `rounding`.

    The change of a small entry is at first relative to itself, not to its size, because a law may change sharply near zero. It grows until
    the change of a rate is clear of rounding: near a rest the rates are nothing but rounding errors.
    """
    m = len(sizes)
    result, moved = np.empty((len(y), m)), y.copy()
    rounded = noise[:m] > EXACT * np.abs(f[:m])
    hidden = 1e4 * noise[:m][rounded]  # a larger change gives four digits of a slope
    for k, (entry, size) in enumerate(zip(y[:m].tolist(), sizes.tolist(), strict=True)):
        step, largest = BESIDE * min(abs(entry), size) or STANDING * size, BESIDE * size
        while True:
            moved[k] = entry + step
            change = fun(time, moved) - f
            if step >= largest or not hidden.size or (np.abs(change[:m][rounded]) > hidden).any():
                break
            step = min(1e3 * step, largest)
        result[:, k] = change / (moved[k] - entry)
        moved[k] = entry
    return result

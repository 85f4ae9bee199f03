"""A job: a press and all that acts on it, from one file; each result is one call of the functions of the library."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from ..common.errors import PinpressError, SimulationError, suggestion
from ..common.frozen import Frozen
from ..common.outlets.described import Section
from ..common.reading.entries import Entry
from ..common.reading.filling import Around, naming
from ..common.results import Tabular
from ..common.tables import Columns
from ..drives.protocol import Drive
from ..drives.transmission import Brake, Clutch, Flywheel, PrescribedSpeed
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..dynamics.reactions import Reactions
from ..dynamics.timing import TimingDiagram, timing
from ..kinematics.cycle import cycle
from ..kinematics.motion import Motion
from ..kinematics.motion_table import read_motion
from ..kinematics.traces import PointTrace, trace
from ..linkage.linkage import Linkage
from ..linkage.loading import presses
from ..loads.link import Friction, Load, StandingLoad
from ..loads.mounts import Frame
from ..pin_table.building import DrawnPress
from ..pin_table.dependence import dimension
from ..ratings.along_motion import MotionRatings, rate_motion
from ..ratings.emergency_stops import StoppingTimes, stopping
from ..ratings.permissible_force import Capacities
from ..ratings.pin_use import PinRatings, pins
from ..ratings.rating import PressRatings, rate
from ..ratings.safety_distance import SafetyDistance
from ..simulation.elastic.description import Elastic, Stiffness
from ..simulation.run import Run
from ..simulation.simulate import simulate
from ..simulation.steady_state import steady_state
from ..visual.reports.header import Header
from .bearings import bearings_of, clearances_of, elastic_of, frictions_of, pins_of
from .grammar import SECTIONS
from .kinds import Bearing
from .reading import check_names, counted_from, press_of, read_value
from .sources import OF_PRESS, Change, Source, changed, of_variant, source

if TYPE_CHECKING:
    from ..balancing.result import BalancedPress
    from ..fe.link_loads import LinkLoads
    from ..foundation.mounted_press import MountedPress
    from ..mains.drive_choice import DriveChoice
    from ..servo.cam_tables import CamPoints
    from ..servo.motion_optimum import MotionOptimum
    from ..servo.sizing import MotorChoice
    from ..tolerances.accuracy_budget import AccuracyBudget
    from ..tolerances.allocation import AllocatedTolerances
    from ..tolerances.dead_centre_scatter import DeadCentreScatter
    from ..tolerances.dimension_table import DimensionTable

POINTS = 720  # states of a turn: fewer miss peaks of short blows
MOST_STATES = 100_000  # of a period, for the vibration of the frame
OF_DISTANCE = ("edition", "resolution", "two_hand", "reach", "supplement")  # keys of the section stopping
SPEEDS = 61  # at which the press on its mounts is shown


def job(file: str | os.PathLike[str] | None = None, /, *, variant: str | None = None, set: Sequence[str] = (), **changes: Any) -> Job:
    """Read a job: a press and all that acts on it.

        job = pp.job("press.yaml", variant="hard_steel", **{"loads.draw.force": 1.9e6})
        job.press, job.loads["draw"], job.reactions(), job.steady_state(), job.rate()
        job.write_report("press.html")

    The page "A job file" of the manual lists the sections and their keys. In a file every number has its unit; here bare numbers are in SI
    units. A section may also be given as the mapping that stands in a file, or with parts that are made already.

    Args:
        file: a job or a table of pins (.yaml), a URDF, SDF or MJCF file, or the name of a shipped press; None: ``changes`` are the job.
        variant: name of one of the job's variants.
        set: changes as texts, as on the command line: "loads.draw.force=1200 kN", "r=150".
        changes: sections, or values by their paths with points between the names; None removes an entry.

    Raises:
        PinpressError: the press cannot be built or loaded, an entry is unknown, lacks its unit, or cannot be; with file, line and remedy.
    """
    return read_job(source(file, variant, set, changes), raise_first)


def raise_first(error: PinpressError) -> None:
    """Refuse a job with its first error."""
    raise error


def as_inputs(job: Job | None) -> list[tuple[str, str]]:
    """The files of a job with their SHA-256, its variant, and what was changed, for the inputs of a result."""
    if job is None:
        return []
    rows = [("variant", f"{job.source.variant} of {job.source.file}")] if job.source.variant else []
    rows += [("read", f"{path}, SHA-256 {digest}") for path, digest in job.files.items()]
    return rows + [("changed", f"{each.path}: {each.before or 'nothing'} -> {each.now or 'nothing'}") for each in job.changed]


def read_job(found: Source, refuse: Callable[[PinpressError], Any]) -> Job:
    """The job of these entries.

    Args:
        found: the entries.
        refuse: takes every error of a section; it raises the first one, or collects them all.
    """
    items = found.items
    made = found.press_sections()
    drawn = found.drawn()
    as_drawn = press_of(found, made, drawn)
    press = counted_from(as_drawn, made.get("zero", "drawn"))
    around = Around(drivers=dict(zip(press.drivers, press.driver_coordinates, strict=True)))
    for name, section in SECTIONS.items():
        if name in items and name not in (*OF_PRESS, "variants"):
            try:
                made[name] = read_value(section.value, items[name], around, refuse)
                check_names(name, items[name], made[name], press)
            except PinpressError as error:
                made.pop(name, None)
                refuse(error)
    models = [] if drawn is not None or isinstance(found.model, str) else [found.model]
    files = {path: _digest(path) for path in (*found.files, *models, *around.files) if path.is_file()}
    result = Job(press, as_drawn, made, found, drawn, files)
    try:
        result._check()
    except PinpressError as error:
        refuse(error)
    return result


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


@dataclass(frozen=True, eq=False, repr=False)
class Job(Frozen):
    """A press and all that acts on it.

    Attributes:
        press: the press, its crank angles counted from ``zero``.
        as_drawn: the press as its file draws it.
        sections: name of a section that the job has -> what stands in it, with numbers in SI units.
        source: the entries from which it was read.
        drawn: the press as its table draws it; None if it comes from another file.
        files: files that were read -> their SHA-256.
    """

    press: Linkage
    as_drawn: Linkage
    sections: Mapping[str, Any]
    source: Source = field(repr=False)
    drawn: DrawnPress | None = None
    files: Mapping[Path, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        given = ", ".join(name for name in self.sections if name not in OF_PRESS)
        return f"Job of {self.press.name}: {given or 'the press alone'}" + (f"; {len(self.changed)} changes" if self.changed else "")

    @property
    def parameters(self) -> Mapping[str, str]:
        """Parameters of the table that were changed, by their names."""
        return {each.path.partition(".")[2]: each.now for each in self.changed if each.path.startswith("parameters.")}

    def with_zero(self, press: Linkage) -> Linkage:
        """A press with crank angles counted as those of this job."""
        return counted_from(press, self.sections.get("zero", "drawn"))

    # ------------------------------------------------------------------------------------------------------------------- what acts

    @property
    def changed(self) -> tuple[Change, ...]:
        """What variant and changes have changed on top of the file."""
        return self.source.changes

    @property
    def speed(self) -> float | None:
        """Speed of the driver [rad/s], of one that slides [m/s]; None if a motion is given, or neither."""
        speed: float | None = self.sections.get("speed")
        return speed

    @property
    def loads(self) -> Mapping[str, Load]:
        """The loads by their names."""
        return dict(self.sections.get("loads", {}))

    @cached_property
    def bearings(self) -> Mapping[str, Bearing]:
        """What is said of each bearing and guide, with what is said of all."""
        with self._naming("bearings"):
            return bearings_of(self.press, self.sections.get("bearings", {}))

    @cached_property
    def friction(self) -> Mapping[str, Friction]:
        """Friction of the bearings and guides that have some."""
        with self._naming("bearings"):
            return frictions_of(self.press, self.bearings)

    @property
    def motor(self) -> Drive | PrescribedSpeed | Mapping[str, Drive] | None:
        """What drives the press; of several drivers by their names."""
        motor: Drive | PrescribedSpeed | Mapping[str, Drive] | None = self._of_drivers("motor")
        return motor

    @property
    def flywheel(self) -> Flywheel | Mapping[str, Flywheel] | None:
        """The flywheel at the driver joint; of several drivers by their names."""
        flywheel: Flywheel | Mapping[str, Flywheel] | None = self._of_drivers("flywheel")
        return flywheel

    @property
    def clutch(self) -> Clutch | None:
        """The clutch between flywheel and crank."""
        return self.sections.get("clutch")

    @property
    def brake(self) -> Brake | None:
        """The brake on the crank."""
        return self.sections.get("brake")

    @cached_property
    def header(self) -> Header | None:
        """Title and title block of the page; None if the job says nothing of them."""
        given = self.sections.get("report", {})
        parts = {each.name: given[each.name] for each in fields(Header) if each.name in given}
        with self._naming("report"):
            return Header(**parts) if parts else None

    @cached_property
    def capacities(self) -> Capacities:
        """What the press may bear, with the permissible forces of its bearings, and the flywheel where a drop of speed is given."""
        given = dict(self.need("capacities"))
        for name in ("contact_height", "dwell_tolerance", "at_speed"):
            given.pop(name, None)
        torque = given.pop("torque", {})
        one = len(self.press.drivers) == 1
        bearings = {name: each.permissible for name, each in self.bearings.items() if each.permissible is not None}
        wheel = self.flywheel if "speed_drop" in given else None
        inertia = float(np.ravel(wheel.inertia)[0]) if isinstance(wheel, Flywheel) else None
        efforts = {"torque": torque.get(self.press.driver)} if one else {"drivers": torque}
        with self._naming("capacities"):
            return Capacities(**given, **efforts, bearings=bearings, flywheel_inertia=inertia)

    @cached_property
    def elastic(self) -> Elastic | None:
        """The press on springs; None for a rigid press."""
        if "elastic" not in self.sections:
            return None
        with self._naming("elastic"):
            return elastic_of(self.press, self.drawn, self.bearings, self.sections["elastic"], self._rigid_frame)

    @cached_property
    def mounted(self) -> MountedPress | None:
        """The press on its mounts; None if it has no foundation."""
        if "foundation" not in self.sections:
            return None
        from ..foundation.mounted_press import mounted  # seldom needed

        parts = {name: part for name, part in self.sections["foundation"].items() if name not in ("points", "speed_range", "lift_off")}
        return mounted(self.press, **parts, motion=self.motion() if "motion" in self.sections else None)

    def _rigid_frame(self) -> Mapping[str, Any]:
        """The one rigid frame on mounts of a press on springs."""
        parts = self.sections.get("foundation")
        if parts is None:
            return {}
        more = [name for name in ("crown", "attached", "rotors") if parts.get(name)]
        if more or type(parts["frame"]).__name__ != "Frame":
            what = more[0] if more else "beams or matrices"
            self._refuse("foundation", f"a press on springs stands on one rigid frame, without {what}", "leave out elastic, or these")
        return {"mounted_frame": parts["frame"], "mounts": parts["mounts"]}

    def _naming(self, section: str) -> AbstractContextManager[None]:
        """Let errors about arguments name the section from which they are."""
        entry = self.source.items.get(section)
        if entry is None:
            return nullcontext()
        return naming(entry, entry.value if isinstance(entry.value, Mapping) else None)

    def _of_drivers(self, section: str) -> Any:
        parts = self.sections.get(section)
        return None if parts is None else parts[self.press.driver] if len(self.press.drivers) == 1 else parts

    def need(self, name: str) -> Mapping[str, Any]:
        """What stands in a section that a result needs; raises PinpressError with an example if the job lacks it."""
        if name not in self.sections:
            raise PinpressError(f"{self.source.file}: the job has no {name}; write it, such as {SECTIONS[name].example}")
        section: Mapping[str, Any] = self.sections[name]
        return section

    def _refuse(self, section: str, problem: str, remedy: str) -> NoReturn:
        entry = self.source.items.get(section)
        if entry is None:
            raise PinpressError(f"{self.source.file}: {section}: {problem}; {remedy}")
        entry.refuse(problem, remedy)

    def _check(self) -> None:
        """Refuse sections that do not go together."""
        has = self.sections
        if "speed" in has and "motion" in has:
            self._refuse("motion", "speed and motion both say how the driver moves", "leave out one of them")
        if "capacities" in has:
            if ("speed_drop" in has["capacities"]) and not isinstance(self.flywheel, Flywheel):
                self._refuse("capacities", "speed_drop without a flywheel", "add flywheel: 6000 kg m2")
            _ = self.capacities
        if "before" in has.get("report", {}):
            self._check_before(self.source.items["report"].items("keys with values")["before"])
        _ = self.friction, self.header
        if "run" in has:  # deflections alone take parts that are rigid, a run does not
            _ = self.elastic

    def _check_before(self, entry: Entry) -> None:
        name, below = entry.text("a variant or press"), self.source.below
        variants = below["variants"].items("names with values") if "variants" in below else {}
        if name not in ("none", *variants, *presses()) and not (entry.folder / name).exists():
            known = f"name one of {', '.join(variants)}, or a press" if variants else "name a press"
            entry.refuse(f"no variant or press {name!r}{suggestion(name, variants)}", known)

    # ------------------------------------------------------------------------------------------------------------------- results

    def motion(self) -> Motion:
        """One period at constant speed, or the motion of the table."""
        return self._motion

    @cached_property
    def _motion(self) -> Motion:
        if "motion" in self.sections:
            given = self.sections["motion"]
            return read_motion(self.press, given["file"], period=given.get("period"))
        if self.speed is None:
            coordinate = self.press.driver_coordinates[0]
            if len(self.press.drivers) > 1:
                raise PinpressError(f"{self.source.file}: the press has several drivers; write motion: {{file: motion.csv}}, their motion")
            raise PinpressError(f"{self.source.file}: the job has no speed; write speed: {'70 r/min' if coordinate.turns else '80 mm/s'}")
        return cycle(self.press, speed=self.speed, points=self._points)

    @property
    def _points(self) -> int:
        """States of a period at constant speed."""
        turns = self.press.period_turns if self.press.driver_coordinates[0].turns else 1
        points: int = self.sections.get("points", POINTS * turns)
        return points

    def reactions(self) -> Reactions:
        """Driving torque and bearing forces of the motion under the loads, as `inverse_dynamics` finds them."""
        return self._reactions

    @cached_property
    def _reactions(self) -> Reactions:
        return inverse_dynamics(self.press, self.motion(), list(self.loads.values()), self.friction, stiffness=self.stiffness)

    @property
    def stiffness(self) -> Mapping[str, float]:
        """Stiffnesses by which redundant bearings share their forces."""
        return {name: each.stiffness for name, each in self.bearings.items() if each.stiffness is not None}

    def steady_state(self) -> Run:
        """One period of the steady state of the rigid press under its motor, near its speed."""
        return self._steady_state

    @cached_property
    def _steady_state(self) -> Run:
        _ = self.need("motor")
        if self.speed is None:
            raise PinpressError(f"{self.source.file}: a steady state is found near a speed; write speed: 70 r/min")
        driven = self._driven
        if isinstance(self.flywheel, Flywheel):  # it turns with the crank: the clutch is closed
            driven["flywheel"] = replace(self.flywheel, speed=None)
        run: Run = steady_state(self.press, self.speed, **driven, points=self._points)
        return run

    @property
    def _driven(self) -> dict[str, Any]:
        """What drives and resists the press, as arguments of `simulate`."""
        return {"drive": self.motor, "flywheel": self.flywheel, "loads": list(self.loads.values()), "friction": self.friction}

    @cached_property
    def _run(self) -> Run:
        """The run of `simulate`, which is computed once."""
        return self.simulate()

    def simulate(self, progress: Callable[[float], None] | None = None) -> Run:
        """The run that the section ``run`` describes, or its steady state; on springs where the job has ``elastic``.

        Args:
            progress: is told the simulated time [s] now and then.
        """
        given = dict(self.need("run"))
        start = {name: given.pop(name, {}) for name in ("speed", "angle")}
        if not start["speed"] and self.speed is not None:
            start["speed"] = {self.press.driver: self.speed}
        speeds, angles = ([start[name].get(driver, 0.0) for driver in self.press.drivers] for name in ("speed", "angle"))
        one = len(self.press.drivers) == 1
        driven = self._driven | ({} if self.elastic is None else {"elastic": self.elastic})
        if given.pop("steady", False):
            if beside := [name for name in ("duration", "method", "step") if name in given]:
                self._refuse("run", f"{beside[0]} does not go with steady", "leave out one of them")
            if not one:
                self._refuse("run", "several drivers have no stroke that repeats itself", "write duration: 3 s in place of steady")
            _ = self.need("motor")
            points = given.pop("points", POINTS * self.press.period_turns)
            run: Run = steady_state(self.press, speeds[0], angle=angles[0], **driven, points=points, **given)
            return run
        if "duration" not in given:
            self._refuse("run", "it says neither duration nor steady", "write duration: 3 s, or steady: yes")
        start_at = {"speed": speeds[0], "angle": angles[0]} if one else {"speed": speeds, "angle": angles}
        run = simulate(
            self.press, given.pop("duration"), **start_at, **driven, clutch=self.clutch, brake=self.brake, progress=progress, **given
        )
        return run

    def traces(self) -> list[PointTrace]:
        """The points of ``traces`` over the motion that the page of the job shows."""
        motion = motion_of(self).motion
        return [trace(self.press, motion, link, point, name) for name, link, point in named_traces(self)]

    def rate(self) -> PressRatings | MotionRatings:
        """The process force that the capacities permit, over the stroke or along the motion.

        Loads that always act, such as balance cylinders, count ``at_speed`` and along a motion.
        """
        return self._ratings

    @cached_property
    def _ratings(self) -> PressRatings | MotionRatings:
        given = self.need("capacities")
        beside = [load for load in self.loads.values() if isinstance(load, StandingLoad)]
        if "motion" in self.sections:
            return rate_motion(self.press, self.motion(), self.capacities, loads=beside, friction=self.friction)
        at_speed = given.get("at_speed", False)
        more = {name: given[name] for name in ("contact_height", "dwell_tolerance") if name in given}
        if self.speed is None:
            raise PinpressError(f"{self.source.file}: ratings are those at a speed; write speed: 70 r/min")
        return rate(
            self.press, self.speed, self.capacities, at_speed=at_speed, loads=beside if at_speed else [], friction=self.friction, **more
        )

    def pins(self) -> PinRatings:
        """The pins and rolling bearings in the motion of the page."""
        found = pins_of(self.press, self.bearings)
        if not found:
            lacking = "no bearing has diameter and width, or rolling"
            self._refuse("bearings", lacking, "write bearings: {W: {diameter: 80 mm, width: 80 mm}}")
        with self._naming("bearings"):
            return pins(motion_of(self), found)

    def load_cases(self) -> LinkLoads:
        """The load cases of the link in the section ``fe``, in the motion of the page."""
        from ..fe.link_loads import load_cases  # seldom needed

        given = self.need("fe")
        with self._naming("fe"):
            return load_cases(self.press, motion_of(self), given["link"], given.get("at", "extremes"))

    def stopping(self) -> StoppingTimes:
        """The stops under the brake after a signal at any crank angle, with the loads that always act, such as balance cylinders."""
        return self._stopping

    @cached_property
    def _stopping(self) -> StoppingTimes:
        given, brake = dict(self.need("stopping")), self.brake
        if brake is None:
            self._refuse("stopping", "the job has no brake", "write brake: {torque: 25 kN m, rise: 50 ms}")
        if self.speed is None:
            raise PinpressError(f"{self.source.file}: a stop begins at a speed; write speed: 50 r/min")
        if "edition" not in given and (of := [name for name in OF_DISTANCE if name in given]):
            self._refuse("stopping", f"{of[0]} is of a distance, and there is no edition", "write edition: ISO 13855:2010")
        for name in OF_DISTANCE:
            given.pop(name, None)
        beside = [load for load in self.loads.values() if isinstance(load, StandingLoad)]
        with self._naming("stopping"):
            return stopping(self.press, self.speed, brake.torque, rise=brake.rise, loads=beside, **given)

    def safety_distance(self) -> SafetyDistance:
        """The safety distance by the edition in the section ``stopping``."""
        given = self.need("stopping")
        if "edition" not in given:
            self._refuse("stopping", "it has no edition", "write edition: ISO 13855:2010")
        with self._naming("stopping"):
            return self.stopping().distance(**{name: given[name] for name in OF_DISTANCE if name in given})

    def balance(self) -> BalancedPress:
        """The best counterweights in the regions of the job, over its dies, settings and speeds."""
        return self._balanced

    @cached_property
    def _balanced(self) -> BalancedPress:
        from ..balancing.optimum import balance  # seldom needed

        given = self.need("balance")
        return balance(
            self.press, [*self._conditions(given)], regions=[*given["regions"].values()], minimise=given["minimise"], limits=given["limits"]
        )

    def _conditions(self, given: Mapping[str, Any]) -> Iterator[Any]:
        """The operating conditions: every setting with every die at every speed."""
        from ..balancing.counterweights import OperatingCondition, with_die  # seldom needed

        several = len(given.get("speeds", ())) > 1
        for setting in given.get("settings") or [{}]:
            jobs = self.with_(**setting) if setting else self
            words = ", ".join(f"{name}={value}" for name, value in setting.items())
            for die in given.get("dies") or [None]:
                slide = jobs.press.slide
                if die is not None and slide is None:
                    self._refuse("balance", f"{self.press.name} has no slide to fix a die to", "leave out dies")
                press = jobs.press if die is None else with_die(jobs.press, die, str(slide))
                name = ", ".join(part for part in (words, "" if die is None else f"die of {die:g} kg") if part)
                for number, speed in enumerate(given.get("speeds") or [self.speed]):
                    motion = self.motion() if speed is None else cycle(press, speed=speed, points=self.sections.get("points", 360))
                    said = f"{name} ({number})" if name and several else name
                    yield OperatingCondition(motion, list(self.loads.values()), press if setting or die is not None else None, said)

    def best_motion(self) -> MotionOptimum:
        """The best motion of the servo drive, with its proof; of a catalogue that of the smallest sufficient motor."""
        if "motors" in self.need("servo"):
            best = self.choose_motor().best
            if best is None:
                raise PinpressError("no motor of the catalogue is sufficient: give larger motors, other ratios, more time or a pause")
            return best
        return self._best_motion

    @cached_property
    def _best_motion(self) -> MotionOptimum:
        from ..servo.optimum import best_motion  # seldom needed

        given = dict(self.need("servo"))
        if "drive" not in given:
            self._refuse("servo", "it has neither a drive nor motors", f"write {SECTIONS['servo'].example.partition(': ')[2]}")
        for name in ("step", "gear_inertia", "pause"):
            if name in given and name != "step":
                self._refuse("servo", f"{name} goes with motors", "leave it out: the drive has its gear_inertia")
            given.pop(name, None)
        return best_motion(self.press, given.pop("drive"), list(self.loads.values()), friction=self.friction, **given)

    def choose_motor(self) -> MotorChoice:
        """The smallest sufficient motor of the catalogue in the section ``servo``, and its ratio."""
        return self._choice

    @cached_property
    def _choice(self) -> MotorChoice:
        from ..servo.motors import read_motors  # seldom needed
        from ..servo.sizing import choose_motor

        given = dict(self.need("servo"))
        if "drive" in given or given.get("minimise", "heat") != "heat":
            which = "drive" if "drive" in given else "minimise"
            self._refuse("servo", f"motors chooses the motor by its heat, and {which} stands beside it", f"leave out {which} or motors")
        if "ratios" not in given or "time" not in given:
            self._refuse("servo", "motors needs ratios and the time of a stroke", "write ratios: 40 60 80 and strokes_per_minute: 25")
        for name in ("step", "minimise"):
            given.pop(name, None)
        return choose_motor(self.press, read_motors(given.pop("motors")), list(self.loads.values()), **given)

    def timing(self) -> TimingDiagram:
        """The timing diagram of a period at constant speed."""
        return self._timing

    @cached_property
    def _timing(self) -> TimingDiagram:
        given = self.need("feed")
        with self._naming("feed"):
            loads = list(self.loads.values())
            return timing(self.press, self.motion(), given["above"], feed_time=given.get("time"), loads=loads, bars=given.get("bars", {}))

    def cam_tables(self) -> list[CamPoints]:
        """The cam tables of the servo drive's best motion; of a job without one those of the motion that its page shows."""
        return self._cam_tables

    @cached_property
    def _cam_tables(self) -> list[CamPoints]:
        from ..servo.cam_tables import cam_table  # seldom needed

        given = dict(self.need("cam_table"))
        more = {"layout": given.pop("layout")} if "layout" in given else {}
        if not given:
            self._refuse("cam_table", "it has neither height nor angle", "write height: 1 um, the tolerance of the table")
        motion = self.best_motion().motion.motion if "servo" in self.sections else motion_of(self).motion
        period = self.sections.get("motion", {}).get("period")
        if not {"motion", "servo", "run"} & {*self.sections} and not self.press.driver_coordinates[0].turns:
            period = len(motion.time) * float(motion.time[1])  # there and back in equal steps, the end left out
        with self._naming("cam_table"):
            return [cam_table(self.press, motion, of=of, tolerance=given[of], period=period, **more) for of in given]

    def choose_drive(self) -> DriveChoice:
        """Motor, gear and flywheel of the catalogue in the section ``mains``."""
        return self._drive_choice

    @cached_property
    def _drive_choice(self) -> DriveChoice:
        from ..mains.drive_choice import choose_drive  # seldom needed
        from ..mains.motors import read_motors

        given = dict(self.need("mains"))
        with self._naming("mains"):
            return choose_drive(self.press, read_motors(given.pop("motors")), list(self.loads.values()), self.friction, **given)

    @cached_property
    def dimensions(self) -> DimensionTable:
        """The dimensions with their tolerances."""
        from ..tolerances.dimension_table import dimensions_of, read_dimensions  # seldom needed

        given = self.need("tolerances")["dimensions"]
        of_table = None if self.drawn is None else partial(dimension, self.drawn)
        if isinstance(given, Path):
            return read_dimensions(self.press, given, of_table)
        return dimensions_of(self.press, [(name, {"dimension": name, **row}) for name, row in given.items()], "dimensions", of_table)

    def scatter(self) -> DeadCentreScatter:
        """Scatter of the dead centres with the tolerances of the dimensions."""
        return self._scatter

    @cached_property
    def _scatter(self) -> DeadCentreScatter:
        from ..tolerances.dead_centre_scatter import bottom_dead_centre  # seldom needed

        given = self.need("tolerances")
        asked = {name: given[name] for name in ("forces", "speeds", "samples", "seed") if name in given}
        return bottom_dead_centre(self.press, self.dimensions.parts, motion=self._given_motion, **asked)

    @property
    def _given_motion(self) -> Motion | None:
        return self.motion() if "motion" in self.sections else None

    def allocate(self) -> AllocatedTolerances:
        """The cheapest tolerances that keep the targets."""
        from ..tolerances.allocation import allocate  # seldom needed

        given, table = self.need("tolerances"), self.dimensions
        if not given.get("targets"):
            self._refuse("tolerances", "it has no targets", "write targets: {height: 50 um}")
        return allocate(self.press, table.parts, table.costs, given["targets"], table.bounds, motion=self._given_motion)

    def budget(self) -> AccuracyBudget:
        """Shifts of bottom dead centre over speed, process and temperature, by clearances, springs and heat."""
        from ..tolerances.accuracy_budget import budget  # seldom needed
        from ..tolerances.temperatures import STEEL, Temperatures

        given = self.need("tolerances").get("budget")
        if given is None:
            self._refuse("tolerances", "it has no budget", "write budget: {speeds: 10 50 70 r/min, warm: {rod: 10 K}}")
        warm = given.get("warm")
        heat = Temperatures(warm, given.get("expansion", STEEL), given.get("table"), given.get("face")) if warm else None
        return budget(
            self.press,
            speeds=given["speeds"],
            clearance=clearances_of(self.bearings) or None,
            stiffness=Stiffness(self.stiffness) if self.stiffness else None,
            temperatures=heat,
            process=given.get("process", 0.0),
            machining=self.scatter(),
        )

    # ------------------------------------------------------------------------------------------------------------------- other jobs

    def variant(self, name: str) -> Job:
        """The job with one of its variants, and with no other change."""
        return read_job(of_variant(self.source, name), raise_first)

    def with_(self, **changes: Any) -> Job:
        """The job with other values, by their paths, on top of all changes so far.

        Args:
            changes: as of `job`.
        """
        return read_job(changed(self.source, (), changes), raise_first)

    def write_report(self, path: str | os.PathLike[str]) -> Path:
        """Write the page with all that the sections of the job allow; return its path.

        Raises:
            PinpressError: as the results, or the page cannot be written.
        """
        return write_report(self, path)


# ---------------------------------------------------------------------------------------------------------- all that a job allows


@dataclass(frozen=True, eq=False, repr=False)
class NoAnswer(Tabular):
    """What a job asks for and cannot have, in place of the result: its name, and the reason."""

    name: str
    reason: str

    @property
    def title(self) -> str:
        return f"{self.name}: none"

    def columns(self) -> Columns:
        return {}

    def described(self, page: object = None) -> tuple[Section, ...]:
        return (Section(self.name, note=f"None: {self.reason}"),)


def results_of(job: Job) -> Iterator[Tabular]:
    """The results of a job in the order of the page."""
    has, moving = job.sections, "motion" in job.sections
    if "traces" in has:
        yield from job.traces()
    if "capacities" in has:
        yield job.rate()
    if pins_of(job.press, job.bearings):
        yield job.pins()
    if "fe" in has:
        yield job.load_cases()
    if "stopping" in has:
        yield from stopping_results(job)
    if "feed" in has:
        yield job.timing()
    if "mains" in has:
        yield job.choose_drive()
    if "motor" in has and not moving and len(job.press.drivers) == 1:
        try:
            yield job.steady_state()
        except SimulationError as error:  # a motor that is too weak; the rest of the page holds without it
            yield NoAnswer("Steady state under the motor", str(error))
    if "elastic" in has:
        yield from on_springs(job)
    if "run" in has and not has["run"].get("steady"):
        yield job._run
    if "balance" in has:
        yield job.balance()
    if job.mounted is not None:
        yield from _on_mounts(job, job.mounted)
    if "tolerances" in has:
        yield job.scatter()
        if "targets" in has["tolerances"]:
            yield job.allocate()
        if "budget" in has["tolerances"]:
            yield job.budget()
    if "servo" in has:
        yield from servo_results(job)
    if "cam_table" in has:
        yield from job.cam_tables()


def stopping_results(job: Job) -> Iterator[Tabular]:
    """The stops, and the safety distance where an edition is given."""
    yield job.stopping()
    if "edition" in job.sections["stopping"]:
        yield job.safety_distance()


def servo_results(job: Job) -> Iterator[Tabular]:
    """The motor of the catalogue if there is one, the best motion, its comparison with usual motions, and a capacitor for its energy."""
    from ..servo.comparison import compare_motions  # seldom needed
    from ..servo.sizing import capacitor
    from ..servo.stroke_laws import ready_motions

    given = job.sections["servo"]
    if "motors" in given:
        yield job.choose_motor()
    best = job.best_motion()
    limits, path = given.get("limits", []), given.get("path")
    more = {} if path is None else {"path": path}
    motions = ready_motions(job.press, best.drive, list(job.loads.values()), time=best.motion.duration, limits=limits, **more)
    yield best
    yield compare_motions({f"least {given.get('minimise', 'heat')}": best.motion, **motions}, limits)
    yield capacitor(best.motion)


def on_springs(job: Job) -> Iterator[Tabular]:
    """Compliance of the slide, and its deflection in the motion."""
    from ..elasticity.slide_under_load import slide_deflection  # seldom needed
    from ..elasticity.unit_load import compliance
    from .bearings import stiffness_of

    with job._naming("elastic"):
        stiffness = stiffness_of(job.press, job.drawn, job.bearings, job.sections["elastic"])
    if len(job.press.drivers) == 1:  # it is over the crank angle
        yield compliance(job.press, stiffness)
    yield slide_deflection(job.press, job.motion(), stiffness, loads=list(job.loads.values()))


def _on_mounts(job: Job, system: MountedPress) -> Iterator[Tabular]:
    """Modes of the press on its mounts, and its vibration in the motion, with feet that lift off, and over the speed."""
    from ..foundation.lifting import lifting_response  # seldom needed
    from ..foundation.mounted_press import modes
    from ..foundation.response import steady_response, time_response
    from ..foundation.speed_response import over_speeds
    from ..foundation.whirl_modes import whirl

    given, motion = job.sections["foundation"], job.sections.get("motion")
    reactions = _resolved(job, system)
    points = shown_points(system) | given.get("points", {})
    period = None if motion is None else motion.get("period")
    top = float(np.abs(reactions.motion.crank_speed).max())
    low, high = given.get("speed_range", (0.0, top))
    yield system
    yield modes(system)
    if system.rotors:
        yield whirl(system, np.linspace(0.0, max(top, high), SPEEDS))
    if motion is not None and period is None:
        yield time_response(system, reactions, points=points)
    else:
        yield steady_response(system, reactions, points=points, period=period)
    if "lift_off" in given:
        yield lifting_response(system, reactions, points=points, strokes=given["lift_off"], period=period)
    if "speed_range" in given:
        yield over_speeds(system, np.linspace(low, high, SPEEDS), points=points)


def _resolved(job: Job, system: MountedPress) -> Reactions:
    """The reactions over a period with enough states for the vibration: more than the page has if a blank breaks."""
    from ..foundation.response import states_that_resolve  # seldom needed

    reactions = job.reactions()
    if "motion" in job.sections:  # its states are those of the table
        return reactions
    while len(reactions.motion.crank_angle) < (states := states_that_resolve(system, reactions)) <= MOST_STATES:
        motion = cycle(system.press, speed=float(reactions.motion.crank_speed[0]), points=states)
        reactions = inverse_dynamics(system.press, motion, list(job.loads.values()), job.friction)
    return reactions


def shown_points(system: MountedPress) -> Mapping[str, Any]:
    """Points whose vibration is shown: centres of rigid parts, or bed and carrier of a flexible frame; and machines on the frame."""
    frame, crown = system.frame, system.crown
    if not isinstance(frame, Frame):
        own: dict[str, Any] = {name: name for name in (frame.carrier, frame.bed)}
    elif crown is None:
        own = {"centre of the frame": frame.centre}
    else:
        own = {"centre of the bed": frame.centre, "centre of the crown": ("crown", crown.centre)}
    return own | {name: (name, each.body.centre) for name, each in system.attached.items()}


def traces_of(job: Job) -> list[tuple[str, Any]]:
    """Links and the points of them whose paths are drawn."""
    return [(link, point) for _, link, point in named_traces(job)]


def named_traces(job: Job) -> Iterator[tuple[str | None, str, Any]]:
    """Name, link and point of the points whose paths are drawn; None for those that stand under their link and have no name."""
    for name, given in job.sections.get("traces", {}).items():
        if isinstance(given, dict):
            yield name, given["link"], given["at"]
        else:
            yield from ((None, name, point) for point in given)


def motion_of(job: Job) -> Reactions:
    """The reactions that a page of the job shows.

    They are those of the motion or at constant speed; of a job without either those of the servo drive's best motion, or of the run.
    """
    if "motion" not in job.sections and job.speed is None:
        loads = list(job.loads.values())
        if "servo" in job.sections:
            return inverse_dynamics(job.press, job.best_motion().motion.motion, loads, job.friction)
        if "run" in job.sections:
            return inverse_dynamics(job.press, job._run, loads, job.friction)
    return job.reactions()  # it says what the job lacks


def write_report(
    job: Job,
    path: str | os.PathLike[str],
    *,
    results: Sequence[Tabular] | None = None,
    reactions: Reactions | None = None,
    before: Reactions | None = None,
) -> Path:
    """Write the page of a job.

    Args:
        job: the job.
        path: of the page.
        results: what it shows beside the motion; None: all that the job allows.
        reactions: to the motion that it shows; None: those of `motion_of`.
        before: those that it compares with, beside ``reactions``.
    """
    from ..visual.reports.report import report  # slow to import

    name, its = "", None
    if reactions is None:
        reactions = motion_of(job)
        before, name, its = before_of(job)
    results, rows = [*results_of(job)] if results is None else results, as_inputs(job)
    return report(
        reactions._press,
        reactions.motion,
        path,
        reactions=reactions,
        traces=traces_of(job),
        before=before,
        results=results,
        flywheel=job.flywheel,
        header=job.header,
        inputs=rows,
        before_name=name,
        before_inputs=[row for row in as_inputs(its) if row not in rows],
    )


def before_of(job: Job) -> tuple[Reactions | None, str, Job | None]:
    """The reactions of the variant or press with which the page compares, its name if it is a variant, and its job; None without one.

    A press whose file says nothing of its motion moves as that of the job, and without loads of its own under the job's.
    """
    section = job.source.items.get("report")
    entry = None if section is None else section.items("keys with values").get("before")
    if entry is None or entry.value == "none":
        return None, "", None
    name, variants = entry.text("a variant or press"), job.source.below.get("variants")
    if variants is not None and name in variants.items("names with values"):
        other = job.variant(name)
        return motion_of(other), f"variant {name} of {other.press.name}", other
    path = entry.folder / name
    other = read_job(source(path if path.exists() else name, None, (), {}), raise_first)
    if "motion" in other.sections or other.speed is not None:
        return motion_of(other), "", other
    if "motion" in job.sections:
        given = job.sections["motion"]
        motion = read_motion(other.press, given["file"], period=given.get("period"))
    elif job.speed is not None:
        motion = cycle(other.press, speed=job.speed, points=job._points)
    else:
        entry.refuse(f"neither the job nor {name} says how the driver moves", "write speed: 70 r/min")
    return inverse_dynamics(other.press, motion, list((other.loads or job.loads).values()), other.friction), "", other

"""Right values of the small robot files in this folder.

Each mechanism was made up for these tests. Its torques were found twice: from the equations of motion with multipliers, by Pinocchio's
terms, and by those of MuJoCo, from the mechanism written as MJCF. The two agree to 2e-11 of their size. Positions follow from closing the
loops. Freedoms that no driver moves are free: the table has the accelerations that follow from zero torque, with this torque.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import pinpress as pp

FOLDER = Path(__file__).parent


@dataclass(frozen=True)
class Case:
    """One state of a mechanism under gravity of 9.81 m/s2 along -z, in the joints' zeros of the file.

    Attributes:
        file: below `FOLDER`.
        mobility: degrees of freedom of the closed linkage, with idle spins, joints on springs, and what `load` holds unless told otherwise.
        drivers: independent joints: those with motors, then others that have no torque.
        at: their positions [rad or m].
        speed: their speeds [rad/s or m/s].
        acceleration: their accelerations [rad/s2 or m/s2].
        others: positions of other joints [rad or m], but those that an idle spin changes.
        torque: of the drivers [N m or N].
        load: arguments of `load`.
        tolerance: relative, of torques; the table has ten digits.
    """

    file: str
    mobility: int
    drivers: tuple[str, ...]
    at: tuple[float, ...]
    speed: tuple[float, ...]
    acceleration: tuple[float, ...]
    others: Mapping[str, float]
    torque: tuple[float, ...]
    load: Mapping[str, Any] = field(default_factory=dict)
    tolerance: float = 1e-9

    @property
    def path(self) -> Path:
        return FOLDER / self.file

    @cached_property
    def press(self) -> pp.Linkage:
        """As `load` gives it; read-only, so that tests can share it and what it has found out."""
        return pp.load(self.path, **self.load)

    @property
    def id(self) -> str:
        return "_".join([Path(self.file).parts[0].partition(".")[0], *map(str, self.load.values())]).replace(" ", "")


KNEES = {"knee_a": -0.3506709364, "knee_b": 0.3415501242}
TORQUES = (-1.534725584, 1.69914532)


def _five_bar(file: str, torque: tuple[float, ...] = TORQUES, at: tuple[float, ...] = (0.25, -0.15), **others: Any) -> Case:
    changed = {"mobility": 2, "others": KNEES, "acceleration": (3.0, 4.0), "drivers": ("turn_a", "turn_b"), "speed": (1.2, -0.7)} | others
    return Case(file=file, at=at, torque=torque, **changed)


BASE = ("root_x", "root_y", "root_z", "root_rz", "root_ry", "root_rx")
BASE_ACCELERATION = (0.05465089152, 0.0, -9.787072993, 0.0, 2.012452185, 0.0)  # in world axes; the base is at rest and not turned
BASE_WRENCH = (-0.8086415531, 0.0, 53.35177828, 0.0, -0.3343495943, 0.0)  # force and moment of a held base, in its axes at its origin
SPRUNG_EQUILIBRIUM = 0.3672696236  # turn_b of 22 at rest, with turn_a at 0.25 [rad]; stable
OTHER_ASSEMBLY = {"knee_a": -2.513378, "knee_b": 2.895991}  # of 14, at the same driver places

CASES = (
    _five_bar("01_material_in_collision.urdf"),
    _five_bar("02_origin_in_link.urdf"),
    _five_bar("03_rpy_on_axis.urdf"),
    _five_bar("04_parent_world_undeclared.urdf"),
    _five_bar("05_flat_inertia.urdf", (-1.534725424, 1.699138451)),
    _five_bar("06_moving_link_without_inertial.urdf", (-0.9909419, 1.69914532)),
    _five_bar("07_closing_frames_ball.urdf"),
    _five_bar("08_closing_frames_hinge.urdf"),
    _five_bar("09_companion_yaml_3d/robot.urdf"),
    Case(
        "10_companion_yaml_6d_types/robot.urdf",
        1,
        ("crank_turn",),
        (0.3,),
        (2.0,),
        (5.0,),
        {"rocker_turn": -0.04481888036, "ball_r_Z": 0.1185061796, "ball_r_Y": -0.609587379},
        (4.932775542,),
    ),
    _five_bar("11_two_link1.urdf"),
    _five_bar("12_urdfplus_independent.urdf"),
    Case("13_urdfplus_coupling.urdf", 1, ("shoulder",), (0.5,), (1.0,), (2.0,), {"spindle": 3.0}, (1.756711562,)),
    _five_bar("14_open_pose.urdf", (0.245244974, 0.3476776995), others={"knee_a": -0.1662852715, "knee_b": 0.09275437687}),
    Case(
        "15_flat_zero_pose.urdf",
        1,
        ("crank_turn",),
        (0.6,),
        (1.5,),
        (2.0,),
        {"pin": -0.6, "rocker_turn": 0.6},
        (1.942446104,),
        {"pose": {"rocker_turn": 0.6}},
    ),
    Case(  # 1 idle spin, of both halves: the rod has almost no inertia about its own axis, so that the torque hardly depends on it
        "16_rod_cut_in_middle.urdf",
        2,
        ("crank_turn",),
        (0.3,),
        (2.0,),
        (5.0,),
        {"rocker_turn": -0.04481888036},
        (4.925070774,),
        tolerance=1e-8,
    ),
    Case(  # 2 idle spins, each of two bodies that turn together
        "17_legs_between_two_balls.urdf",
        4,
        ("stroke1", "stroke2"),
        (0.02, -0.015),
        (0.1, 0.2),
        (1.0, -1.0),
        {"tilt_x": -0.0244020546, "tilt_y": -0.1063197526},
        (3.407297337, 2.479555658),
        tolerance=1e-8,
    ),
    _five_bar("18_floating_base.urdf", load={"base": "fixed"}),
    _five_bar(
        "18_floating_base.urdf",
        (0.006510758648, 0.01081461152, *[0.0] * 6),
        (0.25, -0.15, *[0.0] * 6),
        mobility=8,
        drivers=("turn_a", "turn_b", *BASE),
        speed=(1.2, -0.7, *[0.0] * 6),
        acceleration=(3.0, 4.0, *BASE_ACCELERATION),
        load={"base": "floating"},
    ),
    _five_bar("19_no_driver.urdf", load={"driver": ["turn_a", "turn_b"]}),
    _five_bar("20_ros2_control.urdf"),
    _five_bar("21_keyframe_home.xml", at=(1.55, -1.35), others={"knee_a": -1.750670936, "knee_b": 1.841550124}),
    _five_bar(  # turn_b is passive: its torque is 0; named, because else the sprung joint knee_a would be the coordinate
        "22_motor_and_spring.xml",
        (3.76462034, 0.0),
        acceleration=(3.0, 58.22628394),
        load={"driver": ["turn_a", "turn_b"]},
    ),
    _five_bar("23_two_points_on_a_hinge.xml", tolerance=1e-6),  # values of the first point alone
    Case("24_actuator_on_a_tendon.xml", 1, ("grip_l",), (0.3,), (1.0,), (4.0,), {"grip_r": 0.3}, (-0.02923525222,)),
    _five_bar("25_empty_numbers.sdf", load={"driver": ["turn_a", "turn_b"]}),
    _five_bar("26_world_beside_the_root.urdf"),
    _five_bar("27_drawn_outside_limits.urdf"),
)

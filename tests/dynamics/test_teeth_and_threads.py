"""What teeth and threads do to bodies and bearings, without losses and with: values of an independent NumPy script in maximal coordinates,
closed forms of threads and worms, bodies cut free, and runs against inverse dynamics."""

from typing import Any

import numpy as np
import pytest
from support.generators.machine_elements import GEARED, TEETH
from support.generators.meshed import planar
from support.generators.random_gears import geared_cranks, random_gears
from support.oracles.cut_free import cut_free
from support.texts import load, shipped

import pinpress as pp

ENGINES = ("plane", "space", "pinocchio")
MASSLESS = 1e-12
Friction = pp.loads.Friction


def geared_crank(mass=MASSLESS, inertia=1e-16, driver="Q", efficiency=1.0, angle=20.0):
    """The crank-slide with a wheel of 100 teeth on its crank, and a pinion of 20 at (-0.6, 0)."""
    pinion = f"""<link name="pinion"><inertial><mass value="{mass}"/>
      <inertia ixx="{inertia}" ixy="0" ixz="0" iyy="{inertia}" iyz="0" izz="{inertia}"/></inertial></link>
    <joint name="Q" type="continuous"><parent link="frame"/><child link="pinion"/><origin xyz="-0.6 0 0"/><axis xyz="0 -1 0"/></joint>
    <gear_mesh name="teeth" gear1="pinion" gear2="crank" teeth1="20" teeth2="100" efficiency="{efficiency}" pressure_angle="{angle}"/>"""
    return load(shipped("crank_slide").text.decode().replace("</robot>", f"{pinion}</robot>"), drivers=(driver,))


# crank angle [deg], acceleration, load on the slide, pinion; teeth on the pinion x, z; O x, z; Q x, z [N]; torque on the pinion [N m]
PRINTED = {
    "massless pinion": (
        *(90, 0, 0, {}),
        *((-66.2022688217, 181.8892387044), (26.0878253334, 1228.67543223), (66.2022688217, -181.889238704), -18.1889238704),
    ),
    "slide pushed up": (
        *(90, 0, 1e5, {}),
        *((-7213.2024165023, -19818.1107612955), (-32940.8012971, -118771.324568), (7213.2024165, 19818.1107613), 1981.81107613),
    ),
    "other flank": (
        *(270, 0, 1e5, {}),
        *((-7213.2024165023, 19818.1107612957), (18514.3964641, -79135.1030452), (7213.2024165, -19818.1107613), -1981.81107613),
    ),
    "speeding up": (
        *(90, 5, 0, {"mass": 30, "inertia": 0.15}),
        *((-70.8174113922, 194.5692387044), (35.3508730868, 1301.85543223), (70.8174113922, 99.7307612956), -23.2069238704),
    ),
}


@pytest.mark.parametrize("name", PRINTED)
def test_a_geared_crank(name, engine):
    degrees, acceleration, push, pinion, teeth, o, q, torque = PRINTED[name]
    press = geared_crank(**pinion)
    angle = -5 * np.radians(degrees)
    motion = pp.servo_cycle(press, angle=[angle], speed=[-50.0], acceleration=[-5.0 * acceleration])
    found = pp.inverse_dynamics(press, motion, [pp.loads.PointForce("slide", (0, 0, push))], engine=engine)
    for of, expected in (("teeth", -np.array(teeth)), ("O", o), ("Q", q)):
        np.testing.assert_allclose(found.bearing_force[of][0, [0, 2]], expected, rtol=5e-12, atol=1e-9)
    np.testing.assert_allclose(found.driving_torque, torque, rtol=3e-12)
    assert np.abs(found.power_residual).max() < 1e-14
    if name == "massless pinion":
        np.testing.assert_allclose(found.bearing_force["P"][0, [0, 2]], [152.290094155, 850.586193522], rtol=3e-12)


def test_a_lever_gear(engine):
    """A ring that drives a planet which is fixed to the connecting rod."""
    press = planar(
        {
            "A1": ("frame", "turns", (0, 0), 8, (0, 0), 0.0576),
            "A": ("frame", "turns", (0, 0), 2, (0.03, 0), 0.0006),
            "B": ("A", "turns", (0.06, 0), 3, (0.18, 0), 0.0144),
            "slide": ("frame", "x", (0.3, 0), 5, (0.3, 0), 0.01),
        },
        '<gear_mesh name="teeth" gear1="A1_body" gear2="B_body" teeth1="-40" teeth2="20"/>',
        ("A1",),
        {"C": ("B", "slide", (0.3, 0))},
    )
    motion = pp.servo_cycle(press, angle=np.radians([10, 20, 30]), speed=10.0, acceleration=0.0, engine=engine)
    crank, slide = (press.joints.index(name) for name in ("A", "slide"))
    np.testing.assert_allclose(np.degrees(motion.joint_position[:, crank]), [26.3769178476, 51.2417145560, 73.8978862480], rtol=1e-12)
    np.testing.assert_allclose(0.3 + motion.joint_position[:, slide], [0.2922685075, 0.2729574102, 0.2496150883], rtol=0, atol=6e-11)
    np.testing.assert_allclose(motion.v[1, crank], 23.7973607047, rtol=3e-12)
    found = pp.inverse_dynamics(press, motion, [pp.loads.PointForce("slide_body", (-1000.0, 0, 0))], engine=engine)
    printed = {
        "teeth": (540.2614485139, -890.6136782363),
        "A": (340.883677221, 430.246625649),
        "A1": (540.261448514, -812.133678236),
        "B": (356.048796872, 442.025878877),
        "C": (937.736865279, -430.918919518),
        "slide": (0.0, 479.968919518),
    }
    for name, expected in printed.items():
        np.testing.assert_allclose(found.bearing_force[name][1, [0, 2]], expected, rtol=3e-12, atol=1e-9)
    np.testing.assert_allclose(abs(found.mesh["teeth"].tangential[1]), 978.849056469, rtol=1e-12)
    np.testing.assert_allclose(found.driving_torque[1], -117.461886776, rtol=3e-12)
    assert np.abs(found.power_residual).max() < 1e-14


def planetary(efficiencies=(1.0, 1.0), planets=1, drawn=1, massless=False, teeth=(20, 30, 80)):
    """A planetary gear with its ring on the frame and its centres 250 mm apart; ``planets`` for which each stands that is ``drawn``."""

    light = MASSLESS if massless else 1.0
    bodies: dict[str, Any] = {
        "S": ("frame", "turns", (0, 0), 10 * light, (0, 0), 0.05 * light),
        "C": ("frame", "turns", (0, 0), 40 * light, (0.125, 0), 0.8 * light),
    }
    elements = []
    for k in range(drawn):
        place = 0.25 * np.cos(2 * np.pi * k / drawn), 0.25 * np.sin(2 * np.pi * k / drawn)
        bodies[f"P{k}"] = ("C", "turns", tuple(map(float, place)), 12 * light, tuple(map(float, place)), 0.14 * light)
        for name, first, own, efficiency in (("sun", "S_body", teeth[0], efficiencies[0]), ("ring", "frame", -teeth[2], efficiencies[1])):
            gears = f'gear1="{first}" gear2="P{k}_body" teeth1="{own}" teeth2="{teeth[1]}"'
            elements.append(f'<gear_mesh name="{name}{k}" {gears} efficiency="{efficiency}" planets="{planets}"/>')
    return planar(bodies, "".join(elements), ("S",))


def stage(press):
    motion = pp.servo_cycle(press, angle=[np.radians(100)], speed=[50.0], acceleration=[0.0])
    return motion, [pp.loads.PointMoment("C_body", -1000.0)]


def test_a_planetary_gear(engine):
    press = planetary()
    motion = pp.servo_cycle(press, angle=[np.radians(100)], speed=[50.0], acceleration=[20.0])
    np.testing.assert_allclose(motion.v[0, press.joints.index("C")], 10.0, rtol=1e-13)
    found = pp.inverse_dynamics(press, motion, [pp.loads.PointMoment("C_body", -1000.0)], engine=engine)
    printed = {
        "sun0": (0.0, 2307.1430135),
        "ring0": (-1478.7466921706, 1762.3016829311),
        "S": (0.0, 2405.24301349),
        "C": (716.047950955, -3802.87064721),
        "P0": (1192.73466421, -4043.05442796),
    }
    for name, expected in printed.items():
        np.testing.assert_allclose(found.bearing_force[name][0, [0, 2]], expected, rtol=1e-11, atol=1e-9)
    tangential = [abs(found.mesh[name].tangential[0]) for name in ("sun0", "ring0")]
    np.testing.assert_allclose(tangential, [2168.00526487, 2161.78304265], rtol=3e-12)
    np.testing.assert_allclose(found.driving_torque, 217.800526487, rtol=3e-12)
    # what the machine does to its foundation, the ring's teeth among it: the weight less the momentum's change
    bodies = press.engine().body_motion(motion.states(press), range(1, 4)).points(np.array([i.lever for i in press.model.inertias][1:]))
    masses = np.array([inertia.mass for inertia in press.model.inertias])[1:]
    momentum = np.einsum("b,bin->ni", masses, bodies.acceleration)
    np.testing.assert_allclose(found.shaking_force, masses.sum() * np.array([[0, 0, -9.81]]) - momentum, rtol=0, atol=1e-9)


def test_efficiency_of_a_planetary_gear(engine):
    """The loss of the mesh with the ring loads that with the sun, too."""
    press = planetary((0.99, 0.985), massless=True)
    motion, loads = stage(press)
    found = pp.inverse_dynamics(press, motion, loads, engine=engine)
    np.testing.assert_allclose(1000.0 * 10.0 / (found.driving_torque * 50.0), 0.980445452286, rtol=1e-12)
    lost = sum(power[0] for power in found.friction_power.values())
    np.testing.assert_allclose(lost, found.driving_torque[0] * 50 - 1e4, rtol=1e-11)
    np.testing.assert_allclose(found.mesh["sun0"].power, found.friction_power["sun0"])
    assert np.abs(found.power_residual).max() < 1e-14


@pytest.mark.parametrize("engine", ENGINES[1:])  # redundant gears are no blocks of the plane
@pytest.mark.parametrize("efficiencies", [(1.0, 1.0), (0.99, 0.985)])
def test_one_planet_for_four_and_all_that_are_drawn(engine, efficiencies):
    """Four helical planets that are drawn share alike, as one drawn for four does; sun and carrier carry nothing but axial forces."""
    both = []
    for planets, drawn in ((4, 1), (1, 4)):
        text = planetary(efficiencies, planets, drawn, massless=True).text.decode()
        for gear, hand in (("S_body", "right"), ("frame", "left")):
            text = text.replace(f'gear1="{gear}"', f'helix="15" hand="{hand}" gear1="{gear}"')
        press = load(text, drivers=("S",))
        motion, loads = stage(press)
        both.append(pp.inverse_dynamics(press, motion, loads, engine=engine))
        for name in ("S", "C"):
            np.testing.assert_allclose(both[-1].bearing_force[name][:, [0, 2]], 0.0, rtol=0, atol=1e-8)
            np.testing.assert_allclose(both[-1].bearing_moment[name][:, [0, 2]], 0.0, rtol=0, atol=1e-9)
        thrust = both[-1].mesh["sun0"].axial * 4
        np.testing.assert_allclose(both[-1].bearing_force["S"][:, 1], np.abs(thrust), rtol=1e-11)
        assert np.abs(both[-1].power_residual).max() < 1e-13
    one, all_ = both
    np.testing.assert_allclose(all_.driving_torque, one.driving_torque, rtol=1e-11)
    for name in ("sun0", "ring0", "P0", "S", "C"):
        np.testing.assert_allclose(all_.bearing_moment[name], one.bearing_moment[name], rtol=1e-10, atol=1e-9)
        np.testing.assert_allclose(all_.bearing_force[name], one.bearing_force[name], rtol=1e-10, atol=1e-8)
        sizes = [np.linalg.norm(all_.bearing_force[name.replace("0", str(k))]) for k in range(4)]
        np.testing.assert_allclose(sizes, sizes[0], rtol=1e-10)
    for name in ("sun0", "P0"):
        assert all_.indeterminate[name][[0, 2]].all()
        assert not one.indeterminate[name][[0, 2]].any()


WITH_STIFFNESS = {
    "planets": [{}, {"P0": 1e8, "P1": 3e8, "P2": 1e8, "P3": 5e8, "S": 1e9, "C": 1e9}, {"P1": 1e7}],
    "cranks": [{}, {"WL": 1e8, "OR": 1e9}],
}


@pytest.mark.parametrize("kind", WITH_STIFFNESS)
def test_redundant_teeth_share_by_stiffness(kind):
    """Four planets whose weights load them unevenly; two geared cranks, whose idle force runs through teeth, rods and slide. Teeth have no
    pressure angle here: what pushes gears apart is left out where forces are shared."""
    text = planetary(drawn=4).text.decode().replace("<gear_mesh ", '<gear_mesh carrier="C_body" pressure_angle="0" ')
    press = load(text, drivers=("S",)) if kind == "planets" else geared_cranks(1)
    motion = pp.servo_cycle(press, angle=[0.3, 1.0], speed=[50.0, 20.0], acceleration=[20.0, 3.0])
    for stiffness in WITH_STIFFNESS[kind]:
        states = [cut_free(press, motion, i, (), stiffness) for i in range(2)]
        for engine in press.engines:
            found = pp.inverse_dynamics(press, motion, stiffness=stiffness, engine=engine)
            assert np.abs(found.power_residual).max() < 1e-13
            for i, state in enumerate(states):
                forces = np.array([found.bearing_force[name][i] for name in press.bearings])
                np.testing.assert_allclose(forces, state.wrenches[:, :3], rtol=0, atol=1e-11 * np.abs(state.wrenches).max())
                marks = np.array([found.indeterminate[name] for name in press.bearings])
                np.testing.assert_array_equal(marks[:, [0, 2]], state.open[:, [0, 2]])


def test_friction_where_teeth_are_redundant():
    """Every pin loses what its own force says, also where teeth and rods share; without friction nothing jumps."""
    press, pins = geared_cranks(2, 20.0), ("OL", "OR", "PL", "PR")
    motion = pp.servo_cycle(press, angle=[0.3, 1.0], speed=[5.0, 2.0], acceleration=[20.0, 3.0])
    smooth = pp.inverse_dynamics(press, motion)
    for engine in press.engines:
        found, nearly = (
            pp.inverse_dynamics(press, motion, friction={name: Friction(by, radius=0.02) for name in pins}, engine=engine)
            for by in (0.1, 1e-12)
        )
        for name in pins:
            lost = 0.1 * 0.02 * np.linalg.norm(found.bearing_force[name], axis=1) * np.abs(motion.v[:, press.joints.index(name)])
            np.testing.assert_allclose(found.friction_power[name], lost, rtol=1e-11)
            np.testing.assert_allclose(nearly.bearing_force[name], smooth.bearing_force[name], rtol=0, atol=1e-8)
        assert np.abs(found.power_residual).max() < 1e-13


KINDS = ("planetary", "lever gear", "lever gear by a loop")
SEEDS = [0, *(pytest.param(seed, marks=pytest.mark.exhaustive) for seed in range(1, 20))]


def random_states(kind, seed):
    press, random = random_gears(seed, kind), np.random.default_rng(seed)
    motion = pp.servo_cycle(
        press, angle=random.uniform(-0.3, 0.3, 3), speed=random.uniform(2, 5, 3), acceleration=random.uniform(-20, 20, 3)
    )
    return press, motion, [pp.loads.PointForce("slide", tuple(1e3 * random.normal(size=3)))]


@pytest.mark.one_in(3)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", SEEDS)
def test_bodies_cut_free(kind, seed):
    """Teeth between bodies on moving carriers, also on one that only a loop joins to its gear, in planes that stand anyhow."""
    press, motion, loads = random_states(kind, seed)
    states = [cut_free(press, motion, i, loads) for i in range(len(motion.q))]
    size = max(np.abs(state.wrenches[:, :3]).max() for state in states)
    for engine in press.engines:
        found = pp.inverse_dynamics(press, motion, loads, engine=engine)
        assert np.abs(found.power_residual).max() < 1e-12
        for i, state in enumerate(states):
            forces = np.array([[found.bearing_force[name][i], found.bearing_moment[name][i] / press.size] for name in press.bearings])
            expected = state.wrenches.reshape(-1, 2, 3) / np.array([1.0, press.size])[:, None]
            np.testing.assert_allclose(forces, expected, rtol=0, atol=1e-12 * size)
            np.testing.assert_allclose(found.driving_torque[i], state.drives[0], rtol=0, atol=1e-12 * size * press.size)
            teeth = [abs(each.tangential[i]) for each in found.mesh.values()]
            np.testing.assert_allclose(teeth, np.abs(state.teeth), rtol=0, atol=1e-12 * size)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", SEEDS)
def test_friction_of_bearings_that_teeth_push_apart(kind, seed):
    """Every bearing loses what its own force and speed say, which teeth and their losses are in; one engine as the other."""
    press, motion, loads = random_states(kind, seed)
    elements = press.text.decode().replace("pressure_angle", 'efficiency="0.97" pressure_angle')
    press = load(elements, drivers=press.drivers)
    pins = [name for name in press.bearings if name != "G"]
    results = [
        pp.inverse_dynamics(press, motion, loads, {name: Friction(0.02, radius=0.05 * press.size) for name in pins}, engine=engine)
        for engine in press.engines
    ]
    size = max(np.abs(results[0].bearing_force[name]).max() for name in press.bearings)
    normal = press.engine().turning_axes()[0]
    for found in results:
        assert np.abs(found.power_residual).max() < 1e-13
        for name in press.joints:
            if name in pins:
                across = np.linalg.norm(np.cross(found.bearing_force[name], normal), axis=1)
                lost = 0.02 * 0.05 * press.size * across * np.abs(motion.v[:, press.joints.index(name)])
                np.testing.assert_allclose(found.friction_power[name], lost, rtol=1e-11, atol=1e-12 * size * press.size)
        for name in (*press.bearings, *found.mesh):
            np.testing.assert_allclose(found.bearing_force[name], results[0].bearing_force[name], rtol=0, atol=1e-11 * size)
            np.testing.assert_allclose(found.friction_power[name], results[0].friction_power[name], rtol=0, atol=1e-10 * size * press.size)


def test_a_pinion_of_a_rack_and_the_friction_of_its_bearing():
    press = planar(
        {"O": ("frame", "turns", (0, 0), 1, (0, 0), 1e-4), "ram": ("frame", "z", (0.024, 0), 5, (0.024, 0), 0.01)},
        '<rack name="teeth" pinion="O_body" rack="ram_body" radius="0.024" side="left" pressure_angle="20"/>',
        ("O",),
    )
    loads = [pp.loads.PointForce("ram_body", (0, 0, 1e4))]
    for engine in ENGINES:
        motion = pp.servo_cycle(press, angle=np.radians([0.0, -5.0]), speed=[-1.0, -1.0], acceleration=[0.0, 0.0])
        smooth = pp.inverse_dynamics(press, motion, loads, engine=engine)
        rough = pp.inverse_dynamics(press, motion, loads, {"O": Friction(0.1, radius=0.012)}, engine=engine)
        printed = {"teeth": (3621.8496026713, -9950.95), "O": (3621.84960267, -9941.14), "ram": (-3621.84960267, 0.0)}
        for name, expected in printed.items():
            np.testing.assert_allclose(smooth.bearing_force[name][:, [0, 2]], [expected] * 2, rtol=2e-12, atol=1e-9)
        np.testing.assert_allclose(smooth.bearing_moment["ram"][:, 1], [0.0, -7.58558406944], rtol=1e-12, atol=1e-11)
        np.testing.assert_allclose(smooth.driving_torque, -238.8228, rtol=1e-12)
        np.testing.assert_allclose(smooth.driving_torque - rough.driving_torque, 12.69643434, rtol=1e-9)


INERTIA = f"""<inertial><mass value="{MASSLESS}"/>
  <inertia ixx="{MASSLESS}" ixy="0" ixz="0" iyy="{MASSLESS}" iyz="0" izz="{MASSLESS}"/></inertial>"""


def screw(lead, diameter, friction, flank, collar=0.0, driver="spindle"):
    """A spindle that lifts a nut as it turns positively; lengths in mm."""
    return load(
        f"""<robot name="screw"><link name="frame"/><link name="spindle">{INERTIA}</link><link name="nut">{INERTIA}</link>
        <joint name="spindle" type="continuous"><parent link="frame"/><child link="spindle"/><axis xyz="0 0 1"/></joint>
        <joint name="guide" type="prismatic"><parent link="frame"/><child link="nut"/><axis xyz="0 0 1"/>
        <limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
        <screw name="thread" screw="spindle" nut="nut" lead="{1e-3 * lead}" diameter="{1e-3 * diameter}" flank="{flank}"
        friction="{friction}" hand="left" collar_friction="{collar}" {'collar_diameter="0.08"' if collar else ""}/></robot>""",
        drivers=(driver,),
    )


# load [N], lead, mean diameter [mm], friction, flank [deg], friction of the collar; torque up, torque down [N m], efficiency, and backwards
SCREWS = [
    (1e5, 9, 55.5, 0.12, 15, 0.0, 491.10473131, -200.193181, 0.29166782491, None),
    (1e5, 9, 55.5, 0.12, 15, 0.1, 891.10473131, -600.193181, None, None),
    (4e6, 200, 300, 0.06, 15, 0.0, 166734.714, 88937.205223, 0.76363194812, 0.69851117639),
    (5e4, 20, 50, 0.004, 45, 0.0, 166.31706533, 152.00308934, 0.95693693715, 0.95506357759),
]


@pytest.mark.parametrize("engine", ENGINES[1:])
@pytest.mark.parametrize("row", SCREWS)
def test_screws(row, engine):
    force, *sizes, up, down, efficiency, back = row
    press = screw(*sizes)
    motion = pp.servo_cycle(press, angle=[0.0, 0.0, 0.0], speed=[1.0, -1.0, 0.0], acceleration=[0.0, 0.0, 0.0])
    found = pp.inverse_dynamics(press, motion, [pp.loads.PointForce("nut", (0, 0, -force))], engine=engine)
    ideal = force * 1e-3 * sizes[0] / (2 * np.pi)
    np.testing.assert_allclose(found.driving_torque, [up, down, ideal], rtol=1e-8)
    for value, expected in ((ideal / found.driving_torque[0], efficiency), (found.driving_torque[1] / ideal, back)):
        assert expected is None or abs(value - expected) < 3e-11
    np.testing.assert_allclose(found.bearing_force["thread"], [[0, 0, force]] * 3, rtol=1e-12)
    np.testing.assert_allclose(found.bearing_force["guide"], 0.0, rtol=0, atol=1e-9 * force)
    assert np.abs(found.power_residual).max() < 1e-14


def test_a_nut_drives_a_screw_that_locks_backwards_only():
    """Driven by its nut a self-locking spindle stands against any torque, and turns where a torque on the spindle drives with it."""
    press = screw(9, 55.5, 0.12, 15, driver="guide")
    motion = pp.servo_cycle(press, angle=[0.0], speed=[0.1], acceleration=[0.0])
    with pytest.raises(pp.PinpressError, match="friction locks the linkage"):
        pp.inverse_dynamics(press, motion, [pp.loads.PointMoment("spindle", (0, 0, -100.0))])
    found = pp.inverse_dynamics(press, motion, [pp.loads.PointMoment("spindle", (0, 0, 491.10473131))])
    np.testing.assert_allclose(found.driving_torque, -1e5, rtol=1e-10)


@pytest.mark.parametrize("friction", [0.1, 0.12])
def test_a_nut_drives_a_screw_that_nearly_locks(friction):
    """Of what the nut gives 18 or 2 parts of a hundred turn the spindle; both are found to the last digits."""
    press = screw(20, 50, friction, 15, driver="guide")
    motion = pp.servo_cycle(press, angle=[0.0], speed=[0.1], acceleration=[0.0])
    found = pp.inverse_dynamics(press, motion, [pp.loads.PointMoment("spindle", (0, 0, -100.0))])
    lead = np.arctan(20 / (np.pi * 50))
    angle = lead - np.arctan(friction / np.cos(np.arctan(np.tan(np.radians(15)) * np.cos(lead))))
    np.testing.assert_allclose(found.driving_torque, 100 / (0.025 * np.tan(angle)), rtol=1e-12)


def worm_gear(starts=2, friction=0.05, driver="worm"):
    return load(
        f"""<robot name="worm"><link name="frame"/><link name="worm">{INERTIA}</link><link name="wheel">{INERTIA}</link>
        <joint name="worm" type="continuous"><parent link="frame"/><child link="worm"/><origin xyz="0 0 0.2"/><axis xyz="1 0 0"/></joint>
        <joint name="wheel" type="continuous"><parent link="frame"/><child link="wheel"/><axis xyz="0 -1 0"/></joint>
        <worm name="teeth" worm="worm" wheel="wheel" starts="{starts}" teeth="40" module="0.008" quotient="10" pressure_angle="20"
        friction="{friction}" hand="right"/></robot>""",
        drivers=(driver,),
    )


@pytest.mark.parametrize("engine", ENGINES[1:])
@pytest.mark.parametrize(
    ("against", "around", "apart", "torque"), [(1, 3199.1558129, 4689.6343637, 127.96623251), (-1, 1815.5680209, None, 72.622720835)]
)
def test_a_worm_gear(engine, against, around, apart, torque):
    press = worm_gear()
    motion = pp.servo_cycle(press, angle=[0.3], speed=[1.0], acceleration=[0.0])
    sense = np.sign(motion.v[0, press.joints.index("wheel")])
    load_ = pp.loads.PointMoment("wheel", (0.0, against * sense * 2000.0, 0.0))  # its axis is -y
    found = pp.inverse_dynamics(press, motion, [load_], engine=engine)
    np.testing.assert_allclose(found.driving_torque, against * torque, rtol=5e-11)
    teeth = found.mesh["teeth"]
    np.testing.assert_allclose(np.abs([teeth.tangential[0], teeth.axial[0]]), [12500.0, around], rtol=3e-11)
    assert apart is None or abs(teeth.radial[0] - apart) < 1e-7
    assert np.abs(found.power_residual).max() < 1e-14


def test_a_worm_that_locks():
    press = worm_gear(1, 0.12, "wheel")
    motion = pp.servo_cycle(press, angle=[0.3], speed=[1.0], acceleration=[0.0])
    with pytest.raises(pp.PinpressError, match="friction locks the linkage"):
        pp.inverse_dynamics(press, motion, [pp.loads.PointMoment("worm", (-10.0, 0.0, 0.0))])


def test_helical_teeth(engine):
    """Their thrust is that on the shafts' bearings, which also hold its moment."""
    press = planar(
        {"A": ("frame", "turns", (0, 0), MASSLESS, (0, 0), 1e-16), "B": ("frame", "turns", (0.3, 0), MASSLESS, (0.3, 0), 1e-16)},
        '<gear_mesh name="teeth" gear1="A_body" gear2="B_body" teeth1="20" teeth2="40" pressure_angle="20" helix="15"/>',
        ("A",),
    )
    motion = pp.servo_cycle(press, angle=[0.3], speed=[1.0], acceleration=[0.0])
    found = pp.inverse_dynamics(press, motion, [pp.loads.PointMoment("B_body", 2000.0)], engine=engine)
    printed = np.array([3768.0971391408, 2679.4919243112, 1e4])
    np.testing.assert_allclose(found.bearing_force["A"], [printed], rtol=1e-12)
    np.testing.assert_allclose(found.bearing_force["B"], [-printed], rtol=1e-12)
    np.testing.assert_allclose(found.bearing_moment["A"], [[0, -1000, 0.1 * printed[1]]], rtol=1e-11, atol=1e-9)
    np.testing.assert_allclose(found.bearing_moment["B"], [[0, 0, 0.2 * printed[1]]], rtol=1e-11, atol=1e-9)


@pytest.mark.parametrize(("method", "bearings"), [("auto", ()), ("auto", ("O", "P", "Q", "W")), ("implicit", ("Q",))])
def test_runs_lose_what_inverse_dynamics_says(method, bearings):
    """Losses between teeth alone, and with bearings that the teeth push apart."""
    press, loads = geared_crank(30, 0.15, "O", 0.97), [pp.loads.PointForce("slide", (0, 0, 3e3))]
    friction = {name: Friction(0.05, radius=0.03) for name in bearings}
    run = pp.simulate(
        press, 0.2, speed=10.0, points=20, loads=loads, friction=friction, flywheel=pp.drives.Flywheel(inertia=3.0), method=method
    )
    found = pp.inverse_dynamics(press, run, loads, friction)
    np.testing.assert_allclose(found.driving_torque, -3.0 * run.crank_acceleration, rtol=0, atol=1e-8 * 90)
    assert found.friction_power["teeth"].max() > 10
    engines = [pp.inverse_dynamics(press, run, loads, friction, engine=engine) for engine in ENGINES]
    for other in engines[1:]:
        np.testing.assert_allclose(other.driving_torque, engines[0].driving_torque, rtol=0, atol=1e-10)
        np.testing.assert_allclose(other.bearing_force["O"], engines[0].bearing_force["O"], rtol=0, atol=1e-9)


@pytest.mark.parametrize("method", ["auto", "implicit"])
def test_a_run_of_a_screw_that_turns_back(method):
    """A load stops the spindle and drives it back: the thread loses by its forward angle first, then by that backwards."""
    text = screw(200, 300, 0.06, 15, 0.1).text.decode().replace(f'<mass value="{MASSLESS}"/>', '<mass value="450"/>')
    press, loads = load(text.replace(f'="{MASSLESS}"', '="2.5"'), drivers=("spindle",)), [pp.loads.PointForce("nut", (0, 0, -2e3))]
    run = pp.simulate(press, 0.3, speed=3.0, points=30, loads=loads, method=method)
    assert run.crank_speed.max() > 2
    assert run.crank_speed.min() < -2
    found = pp.inverse_dynamics(press, run, loads)
    assert np.abs(found.driving_torque).max() < 1e-7 * np.abs(found.mesh["thread"].axial).max() * 0.2
    lift = 0.2 / (2 * np.pi * 0.15)
    friction = np.arctan(0.06 / np.cos(np.arctan(np.tan(np.radians(15)) * np.cos(np.arctan(lift)))))
    forward, backward = np.tan(np.arctan(lift) + friction) - lift, lift - np.tan(np.arctan(lift) - friction)
    share = 0.15 * np.where(run.crank_speed > 0, forward, backward) + 0.1 * 0.04
    lost = share * np.abs(found.mesh["thread"].axial * run.crank_speed)
    np.testing.assert_allclose(found.friction_power["thread"], lost, rtol=1e-10)


def test_results_name_contacts():
    press = geared_crank(30, 0.15, "O", 0.97)
    motion = pp.cycle(press, speed=10.0, points=24)
    found = pp.inverse_dynamics(press, motion)
    assert {"force_teeth_x [N]", "friction_power_teeth [W]"} <= found.columns().keys()
    assert any(row.quantity == "force in teeth, magnitude" for row in pp.measures.extremes(found))
    some = pp.inverse_dynamics(press, motion, bearings=["teeth"])
    np.testing.assert_array_equal(some.bearing_force["teeth"], found.bearing_force["teeth"])
    assert set(some.left_out) == set(press.bearings)
    none = pp.inverse_dynamics(press, motion, bearings=())
    np.testing.assert_allclose(none.driving_torque, found.driving_torque, rtol=1e-13)
    np.testing.assert_allclose(none.shaking_moment, found.shaking_moment, rtol=0, atol=1e-9)
    with pytest.raises(pp.PinpressError, match="'teeht'"):
        pp.inverse_dynamics(press, motion, bearings=["teeht"])


def test_cranks_side_by_side_tilt_the_slide_by_what_their_rods_push():
    """One pinion drives two cranks, whose bearings yield unequally: the guide holds the moment of the rods' forces in their planes."""
    table = GEARED | {"meshes": {"teeth": TEETH}, "copies": [{"links": "crank rod", "y": [-300, 300], "names": "_front _back"}]}
    press = pp.build(**table)
    motion = pp.servo_cycle(press, np.array([0.3, 1.1]), speed=3.0, acceleration=5.0)
    stiffness = {name: 1e8 * (1 + k) for k, name in enumerate(press.bearings)}
    for engine in ENGINES:
        found = pp.inverse_dynamics(press, motion, loads=[pp.loads.PointForce("slide", (3e3, 0, 1e5))], stiffness=stiffness, engine=engine)
        apart = 0.3 * (found.bearing_force["W_back"] - found.bearing_force["W_front"])
        assert np.abs(apart[:, 2]).min() > 100.0
        np.testing.assert_allclose(found.bearing_moment["slide_guide"][:, 0], -apart[:, 2], rtol=1e-9)
        np.testing.assert_allclose(found.bearing_moment["slide_guide"][:, 2], apart[:, 0], rtol=0, atol=1e-6)

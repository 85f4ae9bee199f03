"""Andrews' squeezing mechanism: seven bodies in the plane, three closed loops, a spring and a constant torque, no gravity; and what is
known of it.

Data and published solution: Test Set for Initial Value Problem Solvers, problem "andrews" (Mazzia and Magherini, Bari 2008; Hairer and
Wanner, Solving Ordinary Differential Equations II, VI.9), solved there by PSIDE at tolerances of 1e-14. It is problem A03 of the IFToMM
library of multibody benchmarks. The signs of the centres of mass of K3, K5 and K7, which that motion does not depend on, are those of the
latter's figure.

The second reference was computed for these tests in 80-bit arithmetic (Gragg-Bulirsch-Stoer extrapolation of order 14 on the equations of
Hairer and Wanner, without a line of pinpress): runs of 1000 and 1500 steps agree to 7e-14 relative in every number. PSIDE differs from it
by 7e-11 in the positions, up to 5e-8 in the rates and 1.3e-6 in accelerations and multipliers: its positions are ours 1.0e-12 s later.

The plane is x-z. Coordinates are those of the test set, in its order; the URDF is drawn in the initial pose, so pinpress's are less by
`START`.
"""

import numpy as np

NAMES = ("beta", "Theta", "gamma", "Phi", "delta", "Omega", "epsilon")
TORQUE = 0.033  # on K1 [N m]
ANCHOR = (0.014, 0.072)  # of the spring on the frame [m]
SPRING = {"stiffness": 4530.0, "free_length": 0.07785}  # [N/m, m]
ON_K3 = (0.02, -0.018)  # of the spring [m]

START = {
    "beta": -0.0617138900142764496358948458001,
    "Theta": 0.0,
    "gamma": 0.455279819163070380255912382449,
    "Phi": 0.222668390165885884674473185609,
    "delta": 0.487364979543842550225598953530,
    "Omega": -0.222668390165885884674473185609,
    "epsilon": 1.23054744454982119249735015568,
}  # [rad]
FIRST_ACCELERATION = np.array([14222.4439199541138705911625887, -10666.8329399655854029433719415, 0, 0, 0, 0, 0])  # [rad/s2]
FIRST_MULTIPLIERS = np.array([98.5668703962410896057654982170, -6.12268834425566265503114393122, 0, 0, 0, 0])  # [N] on K3, K4, K6 at E

# Link, parent, joint, its place in the parent [m], mass [kg], moment of inertia about the centre of mass [kg m2], centre of mass [m].
BODIES = (
    ("K1", "frame", "beta", (0.0, 0.0), 0.04325, 2.194e-6, (0.00092, 0.0)),
    ("K2", "K1", "Theta", (0.007, 0.0), 0.00365, 4.410e-7, (-0.0115, 0.0)),
    ("K3", "frame", "gamma", (-0.03635, 0.03273), 0.02373, 5.255e-6, (0.01043, -0.01874)),
    ("K5", "frame", "delta", (-0.06934, -0.00227), 0.07050, 1.169e-5, (0.02308, 0.00916)),
    ("K4", "K5", "Phi", (0.04, 0.0), 0.00706, 5.667e-7, (0.0, -0.00579)),
    ("K7", "frame", "epsilon", (-0.06934, -0.00227), 0.05498, 1.912e-5, (-0.00449, -0.01228)),
    ("K6", "K7", "Omega", (0.0, -0.04), 0.00706, 5.667e-7, (0.00579, 0.0)),
)
# Loop, link of its second end, that end there [m]; the first end is on K2.
LOOPS = (("E3", "K3", (0.0, -0.035)), ("E4", "K4", (0.0, -0.02)), ("E6", "K6", (0.02, 0.0)))
ON_K2 = -0.028  # [m]

# Time [s] -> positions [rad], rates [rad/s], accelerations [rad/s2], multipliers [N], pin F, pin E [m]; 80-bit.
REFERENCE = {
    0.01: (
        [2.160113131531527, -1.883364231107044, 0.1585167580012267, -0.3286410751746703, 0.5251547747977295, 0.3286410751746703,
         1.068427204632401],
        [711.9231528311040, -786.7700808599398, -136.4381913781197, -240.2930292678645, 4.791548225371054, 240.2930292678645,
         -41.14056696161049],
        [209058.2785325412, -369745.6001716134, -6373.773935841838, -5657.410330994542, -11869.75053455847, 5657.410330994542,
         34721.43750143154],
        [57.02529043750258, 2.967904246249483, 3.218860385008939, -18.17926986794036, 5.159502718032351, 34.24011729160661],
        [-0.003890552388649432, 0.005819244118541015],
        [-0.03082511927739470, -0.001831187667685617],
    ),
    0.02: (
        [8.184905889661675, -7.890505363730449, 0.2095369133846976, -0.2383255965958511, 0.5225369171559964, 0.2383255965958511,
         1.086275108599873],
        [726.5583426091276, -748.6324206323289, -145.7392375844047, -259.5007994767750, 9.790501855163074, 259.5007994767750,
         -57.75747174274602],
        [177724.3327445664, -341202.0452724511, -33195.92383628789, -49292.53467841330, -10758.94170672346, 49292.53467841330,
         24149.46019522106],
        [48.49325698174942, 9.300377345734371, 2.303233131287062, -15.77388980796829, 2.942253254517544, 22.98803241922790],
        [-0.002274420924160496, 0.006620197086170541],
        [-0.02906975624304963, -0.0015044570694408],
    ),
    0.03: (
        [15.81077119515371, -15.75637105841184, 0.04082224011964581, -0.5347301163420796, 0.5244099658799541, 0.5347301163420796,
         1.048080741041938],
        [1139.920302259106, -1424.379295177540, 11.03291191061872, 19.29337410503226, 0.5735699148295089, -19.29337410503226,
         0.3231791492491347],
        [-24631.76312287507, 51850.31963646490, 324102.6007075786, 566749.4220009953, 16743.63541834544, -566749.4220009953,
         9826.507801544173],
        [199.1753481045386, -29.75530997497180, 23.06654361162215, 31.45272527577113, 22.64249478639438, 11.61739235261127],
        [-0.006963039427046851, -0.0007183884307191049],
        [-0.03492161839530312, -0.002240841082126743],
    ),
}  # fmt: skip

# At 0.03 s: positions, rates, accelerations, multipliers, as the test set prints them.
PSIDE = (
    [0.1581077119629904e2, -0.1575637105984298e2, 0.4082224013073101e-1, -0.5347301163226948, 0.5244099658805304, 0.5347301163226948,
     1.048080741042263],
    [1139.920302151208, -1424.379294994111, 11.03291221937134, 19.29337464421385, 0.5735699284790808, -19.29337464421385,
     0.3231791658026955],
    [-24631.76316945196, 51850.37701610329, 324102.5686413781, 566749.3645176213, 16743.62929479361, -566749.3645176222,
     9826.520791458422],
    [199.1753333731910, -29.75531228015052, 23.06654119098399, 31.45271365475927, 22.64249232082739, 11.61740700019673],
)  # fmt: skip

# Bearing -> force on the second-named body of a pair in the plane [N], at 0 and 0.03 s; computed apart with the 80-bit states.
PINS = {
    "beta": ((98.614979623, -5.344125605), (332.628490706, 22.673053595)),  # O, frame on K1
    "Theta": ((98.580077216, -5.908959324), (281.298221731, 16.391923520)),  # F, K1 on K2
    "gamma": ((-45.575772418, 107.119019522), (-28.770273835, 172.413296976)),  # B, frame on K3
    "delta": ((0.0, 0.0), (-24.584870691, -9.421042937)),  # A, frame on K5
    "Phi": ((0.0, 0.0), (-1.583570879, -27.589789433)),  # G, K5 on K4
    "epsilon": ((0.0, 0.0), (6.920886972, -4.416604461)),  # A, frame on K7
    "Omega": ((0.0, 0.0), (1.506953909, -8.954126088)),  # H, K7 on K6
    "E3": ((98.566870396, -6.122688344), (199.175348105, -29.755309975)),  # K2 on K3
    "E4": ((0.0, 0.0), (23.066543612, 31.452725276)),  # K2 on K4
    "E6": ((0.0, 0.0), (22.642494786, 11.617392353)),  # K2 on K6
}


def urdf() -> str:
    """The mechanism as a URDF, drawn in its initial pose."""
    parts = ['<robot name="andrews">', '  <link name="frame"/>']
    for link, parent, joint, (x, z), mass, inertia, (cx, cz) in BODIES:
        about = f'ixx="{inertia}" ixy="0" ixz="0" iyy="{inertia}" iyz="0" izz="{inertia}"'
        parts += [
            f'  <link name="{link}">',
            f'    <inertial><origin xyz="{cx} 0 {cz}"/><mass value="{mass}"/><inertia {about}/></inertial>',
            "  </link>",
            f'  <joint name="{joint}" type="continuous">',
            f'    <parent link="{parent}"/><child link="{link}"/>',
            f'    <origin xyz="{x} 0 {z}" rpy="0 {-START[joint]!r} 0"/><axis xyz="0 -1 0"/>',
            "  </joint>",
        ]
    for loop, link, (x, z) in LOOPS:
        ends = f'<link1 link="K2" xyz="{ON_K2} 0 0"/><link2 link="{link}" xyz="{x} 0 {z}"/>'
        parts.append(f'  <loop_joint name="{loop}" type="spherical">{ends}</loop_joint>')
    parts += ['  <transmission name="drive"><joint name="beta"/></transmission>', "</robot>"]
    return "\n".join(parts) + "\n"

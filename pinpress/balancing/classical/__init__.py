"""The classical arrangements that balance a rotor or a crank press, after Zhang 2007, chapter 3.

    from pinpress.balancing import classical

    press = pp.load("jf75g_125_plain")
    classical.complete_balance(press, rod_radius=0.3, crank_radius=0.15)  # counterweights for with_counterweights
    classical.with_balance_shafts(press, radius=0.15, shaft_distance=0.8)  # a new press
    classical.with_opposed_balancer(press, crank_radius=0.03, die_mass=300.0)
    classical.mirrored(press, shaft_distance=0.5)

| arrangement | Zhang 2007 | remaining shaking force, without the weight | remaining moment |
|---|---|---|---|
| `static_balance`, `two_plane_balance` of a rotor | 3.1.1 | nothing | a couple; nothing |
| `complete_balance` | 3.3 | nothing | larger than before |
| `approximate_balance` | 3.4 | first order (1 - share) along, share across; higher orders along | changed |
| `with_balance_shafts` for the orders 1 and 2 | 1.2.1 | fourth and higher orders along | as before, except for the rotating masses |
| `with_opposed_balancer`, same ratio of rod and crank | 3.5 | nothing | odd orders, from the rods' inertia |
| `mirrored` crank-slider | 3.6 | all along the slide, nothing across | nothing |
| `mirrored` press with opposed balancer | 3.6 | nothing | nothing |

`as_crank_slider` reads lengths and masses of a press, and `unbalance` the unbalance of a rotor. `harmonic_coefficients` computes the orders
of a crank-slider's forces, and `compare_harmonics` compares the orders of two presses.
"""

from ...common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)

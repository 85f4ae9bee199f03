"""Motion found from drives and loads.

What must hold of every run, whatever its solver (tests/simulation/test_invariants.py tries it):

1. Speed. Where a solver calls an energy solved, it has computed every force at the speed which that energy gives.
2. Limits. A number may be limited so that an iteration can go on. A result that rests on a limited number is not solved.
3. Audit. The energy balance of a run uses the states of the result, and no numbers of the iteration that led to it.
4. Guess. A guess changes the number of rounds. It changes neither the answer nor what is solved.
5. Unsolved panels. A guess on finer panels is the energy at the start where the coarser panels were not solved.
6. Path. Between two states the crank travels no farther than its largest speed times the time.
7. Second opinion. The default method ends where "implicit" does, or one of them refuses.
8. Scenarios. A batch is its single runs. A call that is repeated gives equal bits.
9. Order. What follows a panel does not change the panel.
10. States. No kinetic energy is negative, time rises strictly, and every torque is finite.
11. Rest. At rest the torque needed lies within what brake, friction, loads and gears can hold.
"""

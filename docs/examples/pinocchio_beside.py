"""Does Pinocchio's constraint dynamics agree?

A press is a `pin.Model` with constraint models. Driven by the torque of inverse dynamics, Pinocchio's own constraint
dynamics must give the accelerations of the motion back.
"""

import matplotlib.pyplot as plt
import numpy as np
import pinocchio as pin

import pinpress as pp

press = pp.load("zxn2_3000b")
motion = pp.cycle(press, speed=70 * pp.RPM, points=360)
torque = pp.inverse_dynamics(press, motion).driving_torque

model, data = press.model, press.model.createData()
contacts = pin.StdVec_RigidConstraintModel([pin.convertToRigidConstraintModel(model, loop) for loop in press.constraint_models()])
datas = pin.StdVec_RigidConstraintData([contact.createData() for contact in contacts])
pin.initConstraintDynamics(model, data, contacts, datas)  # without it: a crash
settings = pin.ProximalSettings(0.0, 1e-13, 1e-8, 20)
off = []
for q, v, a, driving in zip(motion.q, motion.v, motion.a, torque, strict=True):
    tau = np.zeros(model.nv)
    tau[press.driver_indices[0]] = driving
    found = pin.constraintDynamics(model, data, q, v, tau, contacts, datas, settings)
    off.append(np.abs(found - a).max())
share = np.array(off) / np.abs(motion.a).max()
print(f"they agree to 1e-12 of the largest: {share.max() < 1e-12}")

figure, axes = plt.subplots(figsize=(6.3, 2.6), layout="constrained")
axes.semilogy(np.degrees(motion.crank_angle), np.maximum(share, 1e-18))
axes.set(xlabel="crank angle [deg]", ylabel="difference of the accelerations,\nby the largest")

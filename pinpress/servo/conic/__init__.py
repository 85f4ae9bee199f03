"""The best motion as a second-order-cone program: coefficients of the press, the problem, the program, and limits that are not convex."""

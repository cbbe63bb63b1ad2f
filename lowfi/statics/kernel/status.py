"""How an iteration of the kernels ends."""

#: Converged, out of iterations, moved without limit, stiffness not positive definite.
CONVERGED, ITERATIONS, NOT_HELD, SINGULAR = range(4)
#: Net force on a ball over the largest force up to which it counts as balanced.
BALANCED = 1e-10
#: Shifts of the stiffness that are tried before it counts as singular, each a hundred times the one before.
SHIFTS = 12

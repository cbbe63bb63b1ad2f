"""One thread for the linear algebra of every worker: the workers share the cores, and many small factors only wait for the
threads of one another."""

import os

for _library in ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "VECLIB_MAXIMUM"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

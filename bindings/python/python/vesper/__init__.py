"""Laws of physics on arrays of numpy, used in place.

    import numpy as np, vesper

    bodies = {"position": np.array([[0.0, 0, 0], [1, 0, 0]]), "velocity": np.array([[0.0, 0, 0], [0, 1, 0]]), "mass": [1.0, 1e-3]}
    engine = vesper.Engine(domains={"bodies": bodies}, laws=["motion", ("gravity", {"g": 1.0})], step=1e-3, lend=True)
    engine.advance(1.0)
    print(bodies["position"])  # the array itself has moved

In: arrays, names of laws, functions. Out: engines, arrays that look into them, `Fault` where something does not fit.
Never: a copy where none is asked for.
"""

from ._engine import Engine, Link
from ._laws import Law, law
from ._vector import Vector
from ._vesper import Fault, StepFault, __version__

__all__ = ["Engine", "Fault", "Law", "Link", "StepFault", "Vector", "__version__", "law"]

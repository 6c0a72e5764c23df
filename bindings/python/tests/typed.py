"""What type checkers have to let pass: `mypy --strict` reads this file, and nobody runs it."""

from pathlib import Path
from types import MappingProxyType

import numpy as np
import vesper


class Mine(vesper.Engine):
    """An engine with things of its own."""

    def height(self) -> float:
        return float(self.get("bodies", "position")[0, 2])


@vesper.law(adds="force")
def drag(velocity: object) -> object:
    return velocity


BODIES = {"position": np.zeros((2, 3)), "velocity": 0.0, "mass": [1.0, 2.0], "ends": vesper.Link("bodies", [[0, 1]])}
PARAMETERS = MappingProxyType({"g": 1.0})

one = vesper.Engine(domains={"bodies": BODIES}, laws=("gravity", {"g": 1.0}), lend="bodies.position", laws_from=Path("laws"))
many = vesper.Engine(laws=["motion", ("gravity", PARAMETERS), {"name": "spring"}, drag], lend={"bodies.mass"}, step=1e-3, threads=2)
height: float = Mine.from_scene("pairs.toml").height()
one["bodies", "position"] = [[0, 0, 0], [1, 0, 0]]
one.copy_to("bodies", "position", np.zeros((2, 3)))
one.add_rows("bodies", {"position": [[0, 0, 0]], "velocity": 0, "mass": 1.0})
report: str = many.report()

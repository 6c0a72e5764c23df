from os import PathLike
from typing import Any, Literal, final

import numpy as np
from numpy.typing import NDArray
from typing_extensions import disjoint_base

from . import Vector

__all__ = ["Assembly", "Engine", "Fault", "StepFault", "__version__"]

__version__: str

class Fault(Exception):
    """What was described or asked for does not fit. The text says who, what, where, and what to do, for every fault."""

class StepFault(Fault):
    """A step could not be taken, or numbers became infinite or NaN; or a law of a module failed in a step, which was taken without
    it. `engine.steps` says how far it came."""

@final
class Assembly:
    """An engine that is being put together: what `vesper.Engine(..)` fills."""

    def __new__(cls, precision: str) -> Assembly: ...
    def domain(self, name: str, rows: int) -> None: ...
    def width(self, property: str) -> int: ...
    def column(self, domain: str, property: str, array: NDArray[Any]) -> None: ...
    def lend(self, domain: str, property: str, array: NDArray[Any]) -> None: ...
    def link(self, domain: str, property: str, target: str, rows: list[int]) -> None: ...
    def laws_from(self, folder: str | PathLike[str]) -> None: ...
    def law(self, name: str, text: str = "") -> None: ...
    def settings(self, text: str) -> None: ...
    def scene(self, text: str, folder: str | PathLike[str]) -> None: ...
    def made_law(
        self,
        name: str,
        function: Any,
        inputs: list[tuple[str, int, bool]],
        outputs: list[tuple[str, str, int]],
        domain: str | None = None,
        label: str | None = None,
        every: int = 1,
    ) -> None: ...

@disjoint_base
class Engine:
    """An engine that runs. `vesper.Engine` puts it together."""

    def __new__(cls, assembly: Assembly) -> Engine: ...
    def step(self, count: int, step: float, /) -> None:
        """Takes `count` steps of `step` s."""
    def advance(self, frame: float, /) -> None:
        """Goes on by `frame` s: by as many steps of the set length as fit, the rest is carried to the next frame; without a set
        step by one step."""
    @property
    def time(self) -> float:
        """The time, in s."""
    @property
    def steps(self) -> int:
        """Steps taken."""
    @property
    def precision(self) -> Literal["f32", "f64"]:
        """What it computes in."""
    def __getitem__(self, key: tuple[str, str], /) -> NDArray[Any] | Vector:
        """A column in place, to look at: the lent array itself; or read-only arrays that look into the engine."""
    def writable(self, domain: str, property: str) -> NDArray[Any] | Vector:
        """A column in place, to change whenever no call runs. While an array of these is there, every call looks anew."""
    def rows(self, domain: str, property: str) -> NDArray[np.uint32] | None:
        """The rows of a column that have a value; None where all have one."""
    def shape(self, domain: str, property: str) -> tuple[int, int]:
        """How many values a column has, and how many numbers each."""
    def kind(self, domain: str, property: str) -> Literal["f32", "f64", "u32"]:
        """The type of the numbers of a column: "u32" for a link."""
    def copy_to(self, domain: str, property: str, array: NDArray[Any]) -> None:
        """Copies all numbers of a column into an array of that many, row after row; `get` makes a new one."""
    def copy_from(self, domain: str, property: str, array: NDArray[Any]) -> None:
        """Changes all numbers of a column; `engine[..] = ..` also takes what is not an array."""
    def append(self, domain: str, rows: int, columns: dict[str, NDArray[Any]]) -> None:
        """Adds rows behind the last, an array for each property; `add_rows` also takes what is not an array."""
    def remove_rows(self, domain: str, rows: Any) -> None:
        """Removes rows, and with them rows that link to them; later rows move up."""
    def enable(self, law: str, on: bool = True) -> None:
        """Switches a law on or off, by its label, or else its name."""
    def observe(self, domain: str, property: str) -> None:
        """Looks at a property that laws compute, from now on."""
    def report(self) -> str:
        """Which laws run, which do not, and why; what nobody uses."""
    def explain(self) -> str:
        """The order of the laws, merged passes, and what moves where."""
    def dot(self) -> str:
        """The graph of the laws in the language of Graphviz."""
    def checkpoint(self) -> str:
        """The complete state, as text."""
    def restore(self, checkpoint: str) -> None:
        """Goes on from a checkpoint of an engine that was put together alike."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, NamedTuple, overload

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

__version__: str

class Fault(Exception):
    """What was described or asked for does not fit. The text says who, what, where, and what to do, for every fault."""

class StepFault(Fault):
    """A step could not be taken, or numbers became infinite or NaN."""

class Link(NamedTuple):
    """A column of rows of another domain: for every row one, or an array of shape (n, ends)."""

    target: str
    rows: ArrayLike

class Vector:
    """The components of a column, each an array that looks into the engine. `np.asarray(vector)` is a copy of shape (n, 3)."""

    def __init__(self, *components: NDArray[Any]) -> None: ...
    @property
    def x(self) -> NDArray[Any]: ...
    @property
    def y(self) -> NDArray[Any]: ...
    @property
    def z(self) -> NDArray[Any]: ...
    @property
    def w(self) -> NDArray[Any]: ...
    @property
    def shape(self) -> tuple[int, int]: ...
    def __iter__(self) -> Iterator[NDArray[Any]]: ...
    def __len__(self) -> int: ...
    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]: ...

_Names = str | Iterable[str]

class Law:
    """A function over whole columns as a law, called once for each evaluation with copies of the columns."""

    name: str
    def __init__(
        self,
        function: Callable[..., Any],
        *,
        adds: _Names = (),
        sets: _Names = (),
        rates: _Names = (),
        amends: _Names = (),
        constants: _Names = (),
        reads: _Names | None = None,
        widths: Mapping[str, int] | None = None,
        name: str | None = None,
        domain: str | None = None,
        label: str | None = None,
        every: int = 1,
    ) -> None: ...
    def __call__(self, *arguments: Any, **named: Any) -> Any: ...

@overload
def law(function: Callable[..., Any], /) -> Law: ...
@overload
def law(
    *,
    adds: _Names = (),
    sets: _Names = (),
    rates: _Names = (),
    amends: _Names = (),
    constants: _Names = (),
    reads: _Names | None = None,
    widths: Mapping[str, int] | None = None,
    name: str | None = None,
    domain: str | None = None,
    label: str | None = None,
    every: int = 1,
) -> Callable[[Callable[..., Any]], Law]: ...

_Parameters = Mapping[str, Any]
_AnyLaw = str | Law | tuple[str, _Parameters] | _Parameters

class Engine:
    """Domains of rows, laws that drive them, and the method that integrates them."""

    def __new__(
        cls,
        *,
        domains: Mapping[str, Mapping[str, ArrayLike | Link]] | None = None,
        constants: Mapping[str, ArrayLike] | None = None,
        laws: _AnyLaw | Iterable[_AnyLaw] = (),
        precision: Literal["f32", "f64"] = "f64",
        lend: bool | Collection[str] = False,
        step: float | None = None,
        integrator: str | _Parameters | None = None,
        scene: str | None = None,
        folder: str | PathLike[str] | None = None,
        **settings: Any,
    ) -> Engine: ...
    @classmethod
    def from_scene(
        cls,
        scene: str | PathLike[str],
        *,
        folder: str | PathLike[str] | None = None,
        precision: Literal["f32", "f64"] | None = None,
        **more: Any,
    ) -> Engine: ...
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
    def precision(self) -> Literal["f32", "f64"]: ...
    def __getitem__(self, key: tuple[str, str]) -> NDArray[Any] | Vector:
        """A column in place, to look at: the lent array itself; or read-only arrays that look into the engine."""
    def __setitem__(self, key: tuple[str, str], values: ArrayLike) -> None:
        """Changes all numbers of a column, also of a constant (domain "scene"). Numbers are finite, or none is changed."""
    def writable(self, domain: str, property: str) -> NDArray[Any] | Vector:
        """A column in place, to change whenever no call runs. While an array of these is there, every call looks anew."""
    def get(self, domain: str, property: str, dtype: DTypeLike | None = None) -> NDArray[Any]:
        """A copy of a column: shape (n,) or (n, 3)."""
    def rows(self, domain: str, property: str) -> NDArray[np.uint32] | None:
        """The rows of a column that have a value; None where all have one."""
    def shape(self, domain: str, property: str) -> tuple[int, int]:
        """How many values a column has, and how many numbers each."""
    def kind(self, domain: str, property: str) -> Literal["f32", "f64", "u32"]:
        """The type of the numbers of a column: "u32" for a link."""
    def add_rows(self, domain: str, columns: Mapping[str, ArrayLike | Link]) -> None:
        """Adds rows behind the last; every property that all rows have needs values for the new ones."""
    def remove_rows(self, domain: str, rows: Sequence[int] | NDArray[Any]) -> None:
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

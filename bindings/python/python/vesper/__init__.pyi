from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, NamedTuple, overload

from numpy.typing import ArrayLike, DTypeLike, NDArray
from typing_extensions import Self

from . import _vesper
from ._vesper import Fault, StepFault, __version__

__all__ = ["Engine", "Fault", "Law", "Link", "StepFault", "Vector", "__version__", "law"]

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

    function: Callable[..., Any]
    name: str
    domain: str | None
    label: str | None
    every: int
    reads: list[str]
    constants: list[str]
    results: list[tuple[str, str]]
    widths: Mapping[str, int]
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
    def add_to(self, assembly: _vesper.Assembly) -> None: ...

@overload
def law(function: Callable[..., Any], /) -> Law: ...
@overload
def law(
    function: None = None,
    /,
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
_Folder = str | PathLike[str]

class Engine(_vesper.Engine):
    """Domains of rows, laws that drive them, and the method that integrates them."""

    def __new__(
        cls,
        *,
        domains: Mapping[str, Mapping[str, Any]] | None = None,
        constants: Mapping[str, Any] | None = None,
        laws: _AnyLaw | Iterable[_AnyLaw] = (),
        precision: Literal["f32", "f64"] = "f64",
        lend: bool | str | Iterable[str] = False,
        step: float | None = None,
        integrator: str | _Parameters | None = None,
        scene: str | None = None,
        folder: _Folder | None = None,
        laws_from: _Folder | Iterable[_Folder] = (),
        **settings: Any,
    ) -> Self: ...
    @classmethod
    def from_scene(
        cls,
        scene: str | PathLike[str],
        *,
        folder: _Folder | None = None,
        precision: Literal["f32", "f64"] | None = None,
        **more: Any,
    ) -> Self:
        """From the text of a scene, or from the file at a path; `more` as for an engine from arrays."""
    def __setitem__(self, key: tuple[str, str], values: ArrayLike) -> None:
        """Changes all numbers of a column, also of a constant (domain "scene"). Numbers are finite, or none is changed."""
    def get(self, domain: str, property: str, dtype: DTypeLike | None = None) -> NDArray[Any]:
        """A copy of a column: shape (n,) or (n, 3)."""
    def add_rows(self, domain: str, columns: Mapping[str, Any]) -> None:
        """Adds rows behind the last; every property that all rows have needs values for the new ones."""
    def remove_rows(self, domain: str, rows: Sequence[int] | NDArray[Any]) -> None:
        """Removes rows, and with them rows that link to them; later rows move up."""

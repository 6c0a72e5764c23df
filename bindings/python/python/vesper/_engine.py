"""Engines from arrays, scenes, names and functions."""

import os
import re
from collections.abc import Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import NamedTuple

import numpy as np

from . import _toml
from ._laws import Law
from ._vesper import Assembly, Fault
from ._vesper import Engine as _Engine

KINDS = {"f32": np.float32, "f64": np.float64, "u32": np.uint32}


class Link(NamedTuple):
    """A column of rows of another domain: for every row one, or an array of shape (n, ends)."""

    target: str
    rows: object


class Engine(_Engine):
    """Domains of rows, laws that drive them, and the method that integrates them."""

    def __new__(
        cls,
        *,
        domains=None,
        constants=None,
        laws=(),
        precision="f64",
        lend=False,
        step=None,
        integrator=None,
        scene=None,
        folder=None,
        laws_from=(),
        **settings,
    ):
        assembly = Assembly(precision)
        for place in [laws_from] if isinstance(laws_from, (str, os.PathLike)) else laws_from:
            assembly.laws_from(Path(place))
        if scene is not None:
            assembly.scene(scene, Path(folder or "."))
        domains = domains or {}
        for name, columns in domains.items():
            _add_domain(assembly, name, columns)
        lent = _lent(lend, domains)
        for name, columns in domains.items():
            for key, values in columns.items():
                _add_column(assembly, (name, key), values, columns, _place(name, key) in lent)
        for key, number in (constants or {}).items():
            assembly.column("scene", key, _numbers(f"constant {key}", number))
        for each in _each_law(laws):
            _add_law(assembly, each)
        given = {"step": step, "integrator": integrator, **settings}
        given = {key: setting for key, setting in given.items() if setting is not None}
        if given:
            assembly.settings(_toml.pairs("the engine", given))
        return super().__new__(cls, assembly)

    @classmethod
    def from_scene(cls, scene, *, folder=None, precision=None, **more):
        """From the text of a scene, or from the file at a path; `more` as for an engine from arrays."""
        if isinstance(scene, os.PathLike) or "\n" not in scene and scene.endswith(".toml"):
            path = Path(scene)
            scene, folder = path.read_text(encoding="utf-8"), folder or path.parent
        said = re.search(r"""^\s*precision\s*=\s*["'](f32|f64)["']""", scene, re.MULTILINE)
        return cls(scene=scene, folder=folder, precision=precision or (said[1] if said else "f64"), **more)

    def get(self, domain, property, dtype=None):
        """A copy of a column: shape (n,) or (n, 3)."""
        rows, width = self.shape(domain, property)
        kind = KINDS[self.kind(domain, property)] if dtype is None else dtype
        array = np.empty(rows if width == 1 and kind is not np.uint32 else (rows, width), dtype=kind)
        self.copy_to(domain, property, array)
        return array

    def __setitem__(self, key, values):
        domain, property = key
        rows, width = self.shape(domain, property)
        what = f"{domain}.{property}"
        numbers = _numbers(what, values)
        shape = (rows,) if width == 1 else (rows, width)
        try:  # Anything of another shape is copied here; what overlaps the column is copied by `copy_from`.
            numbers = np.broadcast_to(numbers, shape)
        except ValueError:
            raise Fault(f"{what} has shape {shape}, and not {numbers.shape}") from None
        self.copy_from(domain, property, np.ascontiguousarray(numbers))

    def add_rows(self, domain, columns):
        """Adds rows behind the last; every property that all rows have needs values for the new ones."""
        rows = _rows_of(domain, columns)
        given = {}
        for key, values in columns.items():
            what = f"{domain}.{key}"
            rows_of = isinstance(values, Link) or _is_rows(values)
            given[key] = _link(what, getattr(values, "rows", values)) if rows_of else _broad(self.shape, what, key, values, rows)
        self.append(domain, rows, given)

    def remove_rows(self, domain, rows):
        """Removes rows, and with them rows that link to them; later rows move up."""
        super().remove_rows(domain, _link(f"rows of {domain}", rows).ravel().tolist())


def _add_domain(assembly, name, columns):
    if not isinstance(columns, Mapping):
        raise Fault(f"domain {name} is a {type(columns).__name__}: give a dict of columns")
    assembly.domain(name, _rows_of(name, columns))


def _rows_of(name, columns):
    """How many rows there are: as many as each array is long. Numbers alone hold for all rows."""
    found = {}
    for key, values in columns.items():
        values = values.rows if isinstance(values, Link) else values
        if np.ndim(values) > 0:
            found.setdefault(len(values), key)
    if len(found) > 1:
        said = ", ".join(f"{key} has {rows}" for rows, key in found.items())
        raise Fault(f"columns of {name} have other numbers of rows: {said}")
    return next(iter(found), 1)


def _place(domain, key):
    """A column's name without the unit that may stand behind it."""
    return f"{domain}.{key.split('[')[0].strip()}"


def _lent(lend, domains):
    """The columns that are lent: all arrays, or those that are named, each of which is there."""
    if lend is False:
        return set()
    given = {_place(name, key): values for name, columns in domains.items() for key, values in columns.items()}
    arrays = {place for place, values in given.items() if isinstance(values, np.ndarray) and values.ndim}
    if isinstance(lend, (bool, np.bool_)):
        return arrays if lend else set()
    lent, faults = set(), []
    for each in [lend] if isinstance(lend, str) else lend:
        place = _place(*each.split(".", 1)) if isinstance(each, str) and "." in each else each
        if place in arrays:
            lent.add(place)
        elif place in given:
            what = "a link" if isinstance(given[place], Link) else f"a {type(given[place]).__name__}"
            faults.append(f"{place} cannot be lent: it is {what}: give an array of numpy, or have it copied")
        else:
            near = get_close_matches(str(place), given, n=1, cutoff=0)
            mend = f"did you mean {near[0]}?" if near else "no domain has a column"
            faults.append(f"{each!r} cannot be lent: no column is named so; {mend}")
    if faults:
        raise Fault("\n".join(faults))
    return lent


def _add_column(assembly, place, values, columns, lends):
    domain, key = place
    what = f"{domain}.{key}"
    if isinstance(values, Link):
        assembly.link(domain, key, values.target, _link(what, values.rows).ravel().tolist())
    elif lends:
        assembly.lend(domain, key, values)
    else:
        numbers = _numbers(what, values)
        rows = _rows_of(domain, columns)
        if numbers.ndim == 0:
            numbers = np.full(rows * max(assembly.width(key), 1), numbers)
        assembly.column(domain, key, np.ascontiguousarray(numbers))


def _broad(shape, what, key, values, rows):
    numbers = _numbers(what, values)
    domain = what[: -len(key) - 1]
    width = shape(domain, key.split("[")[0].strip())[1]
    return np.ascontiguousarray(np.broadcast_to(numbers, (rows,) if width == 1 else (rows, width))) if numbers.ndim == 0 else np.ascontiguousarray(numbers)


def _is_rows(values):
    return isinstance(values, np.ndarray) and values.dtype == np.uint32


def _numbers(what, values):
    """Numbers in float32 or float64, whatever was given."""
    try:
        array = np.asarray(values)
        if array.dtype in (np.float32, np.float64):
            return np.ascontiguousarray(array) if array.ndim else array
        if array.dtype.kind in "iuf":
            return array.astype(np.float64)
    except ValueError as error:
        raise Fault(f"{what}: give numbers: {error}") from None
    raise Fault(f"{what} is {values!r:.60}: give numbers")


def _link(what, rows):
    """Rows as uint32, none of which is lost on the way."""
    array = np.asarray(rows)
    if array.size == 0:
        return array.astype(np.uint32)
    if array.dtype.kind not in "iu" or array.min() < 0 or array.max() > 0xFFFFFFFF:
        raise Fault(f"{what}: give numbers of rows, whole and from 0 on")
    return np.ascontiguousarray(array, dtype=np.uint32)


def _each_law(laws):
    """One law, or several. A name and a table, which has no name of its own, are one law."""
    one = isinstance(laws, (str, Law, Mapping)) or _is_named(laws) and "name" not in laws[1]
    return [laws] if one else laws


def _is_named(given):
    return isinstance(given, tuple) and len(given) == 2 and isinstance(given[0], str) and isinstance(given[1], Mapping)


def _add_law(assembly, given):
    """A name, a name with parameters, `("gravity", {"softening": 0.1})` or `{"name": "gravity", ..}`, or a function."""
    if isinstance(given, Law):
        given.add_to(assembly)
    elif isinstance(given, str):
        assembly.law(given)
    elif isinstance(given, Mapping) and "name" in given:
        parameters = {key: each for key, each in given.items() if key != "name"}
        assembly.law(given["name"], _toml.pairs(f"law {given['name']}", parameters))
    elif _is_named(given):
        assembly.law(given[0], _toml.pairs(f"law {given[0]}", given[1]))
    else:
        raise Fault(f"a law is {given!r}: give its name, a dict with `name` and parameters, or a function under @vesper.law(..)")

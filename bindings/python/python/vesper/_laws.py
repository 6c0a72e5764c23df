"""Functions as laws, for prototypes."""

import inspect
from functools import partial

import numpy as np

from ._vesper import Fault

MODES = ("adds", "sets", "rates", "amends")


class Law:
    """A function over whole columns as a law.

    Its parameters are named as the properties that it looks at, and are arrays of shape (n,) or (n, 3) in float64; those that
    `constants` names are constants of the scene. It returns an array for the property that it `adds` to, `sets`, gives the
    `rates` of, or `amends`; for several of them a dict. It is called once for each evaluation, with copies of the columns.

    `widths` says how many numbers a row has, 1, 3 or 4, of properties that nobody else knows.
    """

    def __init__(
        self,
        function,
        *,
        adds=(),
        sets=(),
        rates=(),
        amends=(),
        constants=(),
        reads=None,
        widths=None,
        name=None,
        domain=None,
        label=None,
        every=1,
    ):
        self.function = function
        self.name = name or getattr(function, "__name__", "law")
        self.constants = _names(constants)
        self.reads = _parameters(function) if reads is None else _names(reads)
        self.results = [(mode, result) for mode, names in zip(MODES, (adds, sets, rates, amends)) for result in _names(names)]
        self.widths = widths or {}
        self.domain, self.label, self.every = domain, label, every
        if not self.results:
            raise Fault(f"law {self.name} gives nothing: say what it adds to, sets, gives the rates of, or amends")
        for constant in self.constants:
            if constant not in self.reads:
                raise Fault(f"law {self.name} does not look at the constant {constant}: name a parameter so")

    def __call__(self, *arguments, **named):
        return self.function(*arguments, **named)

    def add_to(self, assembly):
        def width(name):
            return self.widths.get(name, 1)

        inputs = [(name, width(name), name in self.constants) for name in self.reads]
        outputs = [(mode, name, width(name)) for mode, name in self.results]
        call = partial(_called, self.function, self.name, [name for _, name in self.results])
        assembly.made_law(self.name, call, inputs, outputs, self.domain, self.label, self.every)


def law(function=None, /, **options):
    """Makes a function a `Law`: `@vesper.law(adds="force")`."""
    return partial(law, **options) if function is None else Law(function, **options)


def _called(function, name, results, arguments, shapes):
    """The results as arrays whose numbers stand one behind the other."""
    returned = function(*arguments)
    if len(results) == 1:
        returned = (returned,)
    elif not isinstance(returned, dict) or set(returned) != set(results):
        raise Fault(f"law {name} returns {_said(returned)}: return a dict with {', '.join(results)}")
    else:
        returned = [returned[result] for result in results]
    return [_fit(name, result, array, shape) for result, array, shape in zip(results, returned, shapes)]


def _fit(name, result, array, shape):
    shape = shape if shape[1] > 1 else shape[:1]
    try:
        numbers = np.asarray(array)
        if numbers.dtype.kind not in "iuf":
            raise TypeError
        numbers = numbers.astype(np.float64, copy=False)
        if numbers.shape != shape:
            numbers = np.broadcast_to(numbers, shape)
        return np.ascontiguousarray(numbers)
    except (TypeError, ValueError):
        raise Fault(f"law {name} returns {_said(array)} for {result}: return numbers of shape {shape}") from None


def _said(array):
    if isinstance(array, dict):
        return f"a dict with {', '.join(map(str, array))}"
    shape = getattr(array, "shape", None)
    return type(array).__name__ if shape is None else f"an array of shape {shape}"


def _names(given):
    return [given] if isinstance(given, str) else list(given)


def _parameters(function):
    return list(inspect.signature(function).parameters)

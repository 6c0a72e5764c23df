"""Values of Python in the language of scenes, which is TOML."""

from collections.abc import Mapping

import numpy as np

from ._vesper import Fault


def value(what, given):
    """A number, a text, a list or a table."""
    if isinstance(given, (bool, np.bool_)):
        return "true" if given else "false"
    if isinstance(given, (int, np.integer)):
        return str(int(given))
    if isinstance(given, (float, np.floating)):
        return repr(float(given))
    if isinstance(given, str):
        return text(given)
    if isinstance(given, Mapping):
        return "{ " + pairs(what, given) + " }"
    if isinstance(given, (list, tuple, np.ndarray)):
        return "[" + ", ".join(value(what, each) for each in given) + "]"
    raise Fault(f"{what} is a {type(given).__name__}: give a number, a text, a list or a dict")


def text(given):
    """A text in quotes."""
    quoted = given.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c.isprintable() else f"\\U{ord(c):08X}" for c in quoted) + '"'


def pairs(what, given):
    """`a = 1, b = 2`."""
    return ", ".join(f"{key(name)} = {value(f'{what}, {name}', each)}" for name, each in given.items())


def key(name):
    plain = isinstance(name, str) and name.isascii() and name.replace("_", "").replace("-", "").isalnum()
    return name if plain else text(str(name))

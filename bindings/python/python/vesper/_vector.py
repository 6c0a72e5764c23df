"""A column of vectors that the engine owns: an array for each component, all in place."""

import numpy as np


class Vector:
    """The components of a column, each an array that looks into the engine. `np.asarray(vector)` is a copy of shape (n, 3)."""

    __slots__ = ("_components",)

    def __init__(self, *components):
        self._components = components

    @property
    def x(self):
        return self._components[0]

    @property
    def y(self):
        return self._components[1]

    @property
    def z(self):
        return self._components[2]

    @property
    def w(self):
        """The fourth component, of a quaternion."""
        return self._components[3]

    @property
    def shape(self):
        return len(self._components[0]), len(self._components)

    def __iter__(self):
        return iter(self._components)

    def __len__(self):
        return len(self._components)

    def __array__(self, dtype=None, copy=None):
        if copy is False:
            raise ValueError("the components stand in arrays of their own: one array of them is a copy")
        return np.stack(self._components, axis=1).astype(dtype or self._components[0].dtype, copy=False)

    def __repr__(self):
        return f"Vector({', '.join(map(repr, self._components))})"

"""Scenes that several tests begin with."""

import numpy as np
import pytest
import vesper


@pytest.fixture
def bodies():
    """Two bodies, the light one on a circle around the heavy one."""
    return {
        "position": np.array([[0.0, 0, 0], [1, 0, 0]]),
        "velocity": np.array([[0.0, 0, 0], [0, 1, 0]]),
        "mass": np.array([1.0, 1e-3]),
    }


@pytest.fixture
def two(bodies):
    """Makes an engine of them."""

    def make(**more):
        settings = {"laws": ["motion", ("gravity", {"g": 1.0})], "step": 1e-3} | more
        return vesper.Engine(domains={"bodies": bodies}, **settings)

    return make

"""Pairs on a spring, seven cases in both precisions: the bits that Rust and C give."""

from pathlib import Path

import numpy as np
import pytest
import vesper

STILL = [[0, 0, 0], [0, 0, 0]]
PAIRS = {
    "a": {"velocity": STILL},
    "b": {"velocity": [[0, -10, 0], [0, 10, 0]]},
    "c": {"velocity": [[0, 0, 0], [0, 10, 0]]},
    "d": {"velocity": [[0, 3, 0], [0, 0, 0]], "mass": [10, 1]},
    "e": {"velocity": [[10, 0, 30], [-20, 0, 20]], "stiffness": 0, "gravity": True},
    "f": {"velocity": [[0, 0, 15], [0, 0, 15]], "gravity": True},
    "g": {"velocity": [[0, 0, 15], [0, 0, 15]], "stiffness": 30, "gravity": True},
}
# `cargo run --release -p vesper-c --example pairs` prints them.
EXPECTED = (Path(__file__).parent / "pairs.txt").read_text().splitlines()


def run(precision, lend=False, velocity=STILL, mass=(1, 1), stiffness=100, gravity=False):
    kind = np.float32 if precision == "f32" else np.float64
    place = np.array([[-10, 5, 0], [10, 5, 0]], kind)
    bodies = {"position": place, "velocity": np.array(velocity, kind), "mass": np.array(mass, kind)}
    domains, laws, constants = {"bodies": bodies}, ["motion"], {}
    if stiffness:
        ends = vesper.Link("bodies", [[0, 1]])
        domains["springs"] = {"ends": ends, "stiffness": [stiffness], "damping": [10], "rest_length": [10]}
        laws += ["spring", "damper"]
    if gravity:
        constants["gravity"] = [0, 0, -9.81]
        laws.append("uniform_gravity")
    settings = {"integrator": "runge_kutta_4", "step": 1e-3, "precision": precision, "lend": lend}
    engine = vesper.Engine(domains=domains, constants=constants, laws=laws, **settings)
    engine.advance(10.0)
    return np.stack([np.asarray(engine["bodies", "position"]), np.asarray(engine["bodies", "velocity"])])


@pytest.mark.parametrize("line", EXPECTED, ids=lambda line: line[:5])
def test_a_pair_has_the_bits_of_rust(line):
    case, precision, *bits = line.split()
    for lend in (False, True):
        numbers = run(precision, lend, **PAIRS[case]).ravel()
        whole = numbers.view(np.uint32 if precision == "f32" else np.uint64)
        assert [f"{number:0{2 * numbers.itemsize}x}" for number in whole] == bits, f"lend={lend}"


def test_all_seven_are_there_in_both_precisions():
    assert len(EXPECTED) == 14

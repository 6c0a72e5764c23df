"""Ten thousand calls at random, most of them wrong in some way: exceptions, and no crash."""

import random

import numpy as np
import vesper

NAMES = ["bodies", "springs", "scene", "bodie", "", "position", "velocity", "mass", "force", "ends", "stiffness", "gravity", "\0", "ä"]
KINDS = [np.float64, np.float32, np.uint32, np.int64, np.complex128, object, "S3"]


def array(chance, rows=None):
    shape = chance.choice([(), (rows or chance.randrange(5),), (rows or chance.randrange(5), chance.randrange(5))])
    made = np.zeros(shape, chance.choice(KINDS))
    return chance.choice([made, made.T, made[::2] if made.ndim else made, made.tolist(), 1.0, None, vesper.Link("bodies", made)])


def law(chance):
    def thrown(*columns):
        if chance.random() < 0.02:
            raise ValueError("by chance")
        return chance.choice([0 * columns[0], 0.0, np.nan, None]) if chance.random() < 0.05 else 0 * columns[0]

    return vesper.Law(thrown, adds="force", reads=chance.choice([["velocity"], ["position", "velocity"]]), name="thrown")


def engine(chance):
    rows = chance.randrange(1, 6)
    numbers = np.random.default_rng(chance.randrange(1000))
    kind = chance.choice([np.float32, np.float64])
    bodies = {name: numbers.normal(size=(rows, 3)).astype(kind) for name in ("position", "velocity")} | {"mass": np.ones(rows, kind)}
    springs = {"ends": vesper.Link("bodies", numbers.integers(0, rows, (2, 2))), "stiffness": [1, 1], "rest_length": 1}
    if chance.random() < 0.1:
        bodies[chance.choice(NAMES)] = array(chance, rows)
    laws = ["motion", *chance.choices(["spring", "damper", ("gravity", {"softening": 1.0}), law(chance)], k=chance.randrange(3))]
    precision = chance.choice(["f32", "f64"]) if chance.random() < 0.1 else {4: "f32", 8: "f64"}[np.dtype(kind).itemsize]
    return vesper.Engine(
        domains={"bodies": bodies, "springs": springs},
        laws=laws,
        lend=chance.random() < 0.5,
        precision=precision,
        step=chance.choice([None, 1e-3]),
        integrator=chance.choice(["leapfrog", "runge_kutta_4", "dormand_prince_8"]),
    )


def call(chance, engines, kept):
    one = chance.choice(engines)

    def name():
        return chance.choice(NAMES if chance.random() < 0.3 else ["bodies", "position", "velocity"])

    place = ("bodies", name()) if chance.random() < 0.8 else (name(), name())
    new = {"position": [[0, 0, 1]], "velocity": 0, "mass": 1}
    return chance.choice(
        [
            lambda: engines.__setitem__(chance.randrange(len(engines)), engine(chance)),
            lambda: one.step(chance.randrange(4), chance.choice([1e-3, 1e-3, 0.0, -1.0, float("nan")])),
            lambda: one.step(2, 1e-3),
            lambda: one.advance(chance.choice([1e-3, 0.01, 0.0, float("inf")])),
            lambda: kept.append(one[place]),
            lambda: kept.append(one.writable(*place)),
            lambda: kept.append(one.get(*place)),
            lambda: kept.append(one.rows(*place)),
            lambda: one.__setitem__(place, array(chance)),
            lambda: one.add_rows(place[0], new if chance.random() < 0.7 else {place[1]: array(chance)}),
            lambda: one.remove_rows(place[0], chance.choice([[0], [7], [], [-1], [0.5], None])),
            lambda: one.enable(chance.choice(["gravity", "motion", "spring", "none"]), chance.random() < 0.7),
            lambda: one.observe(*place),
            lambda: one.report() and one.explain(),
            lambda: one.restore(chance.choice(engines).checkpoint()),
            lambda: one.copy_to(*place, np.zeros(chance.randrange(20), chance.choice(KINDS))),
            lambda: kept.clear(),
            lambda: [np.asarray(each).sum() for each in kept if each is not None],
        ]
    )


def test_calls_at_random_are_refused_and_do_not_crash():
    chance = random.Random(1)
    engines, kept, refused, done = [], [], {}, 0
    while len(engines) < 3:
        try:
            engines.append(engine(chance))
        except (vesper.Fault, TypeError, ValueError):
            pass
    for _ in range(10_000):
        try:
            call(chance, engines, kept)()
            done += 1
        except (vesper.Fault, TypeError, ValueError, OverflowError) as error:
            refused[type(error)] = refused.get(type(error), 0) + 1
    assert done > 3000 and refused[vesper.Fault] > 500, (done, refused)

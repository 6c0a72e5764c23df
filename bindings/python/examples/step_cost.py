"""What a step of two bodies costs from Python, in ns, and a frame with nothing to do: the same scenes as
`cargo run --release -p vesper-c --example step_cost`, which tells what they cost in Rust and from C. Medians over engines of the
least of many batches; then what a law in Python costs.
"""

from statistics import median
from time import perf_counter_ns

import numpy as np
import vesper

CALLS, BATCHES, ENGINES, STEP = 1000, 20, 12, 1 / 1024


def two(rows=2, laws=("motion", ("gravity", {"g": 1.0}))):
    numbers = np.random.default_rng(1).normal(size=(rows, 3))
    bodies = {"position": numbers, "velocity": np.zeros((rows, 3)), "mass": 1.0}
    if rows == 2:
        bodies = {"position": [[0, 0, 0], [1, 0, 0]], "velocity": [[0, 0, 0], [0, 1, 0]], "mass": [1, 1e-3]}
    return vesper.Engine(domains={"bodies": bodies}, laws=laws, step=STEP, integrator="leapfrog")


def least(call, arguments, calls=CALLS, batches=BATCHES):
    best = float("inf")
    for _ in range(batches):
        begin = perf_counter_ns()
        for _ in range(calls):
            call(*arguments)
        best = min(best, (perf_counter_ns() - begin) / calls)
    return best


def main():
    engines = [(two(), vesper.Engine(step=STEP)) for _ in range(ENGINES)]
    step = median(least(engine.step, (1, STEP)) for engine, _ in engines)
    frame = median(least(engine.advance, (STEP,)) for engine, _ in engines)
    idle = median(least(idle.advance, (STEP,)) for _, idle in engines)
    loop = least(lambda *_: None, (1, STEP))
    print(f"step of two bodies: Python {step:.1f} ns")
    print(f"frame of two bodies: Python {frame:.1f} ns")
    print(f"frame with nothing to do: Python {idle:.1f} ns (a call of an empty function: {loop:.1f} ns)")

    drag = vesper.Law(lambda velocity: -0.1 * velocity, adds="force", name="drag")
    for rows in (2, 1000, 100_000):
        stock = least(two(rows, ["motion"]).step, (1, STEP), 10, 10)
        ours = least(two(rows, ["motion", drag]).step, (1, STEP), 10, 10)
        print(f"a law in Python, {rows} rows: {(ours - stock) / 1000:.1f} us for each evaluation")


if __name__ == "__main__":
    main()

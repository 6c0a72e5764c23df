"""A spring with many stiffnesses and dampings, each an engine of its own, run as tasks of Dask: here on processes of this machine, on a
cluster with another `Client`. One table comes of it, as CSV: `python sweep_dask.py table.csv`.

A task gets numbers and gives numbers: engines do not travel. Where a scene is a file and the results may be files, too, a task can be a
shard of the command: `subprocess.run(["vesper", "sweep", scene, *varied, "--shard", f"{k}/{n}", "--out", folder], check=True)`, and the
last one to end makes the table.
"""

import csv
import sys
from itertools import product

import numpy as np
import vesper

try:
    from dask.distributed import Client, LocalCluster
except ImportError:
    sys.exit("this example runs on Dask, which is not installed: pip install 'dask[distributed]'")

STIFFNESS = np.geomspace(10, 1000, 6)
DAMPING = np.linspace(0, 20, 4)


def run(stiffness, damping):
    """Two masses on a spring that was pulled apart: how far they are apart after 5 s, and how fast they still are."""
    engine = vesper.Engine(
        domains={
            "bodies": {"position": [[-7.0, 0, 0], [7, 0, 0]], "velocity": 0.0, "mass": 1.0},
            "springs": {"ends": vesper.Link("bodies", [[0, 1]]), "stiffness": [stiffness], "damping": [damping], "rest_length": [10]},
        },
        laws=["spring", "damper", "motion"],
        integrator="runge_kutta_4",
        step=1e-3,
        threads=1,  # Dask has the cores.
    )
    engine.advance(5.0)
    (left, right), velocity = engine.get("bodies", "position"), engine.get("bodies", "velocity")
    return {
        "stiffness": float(stiffness),
        "damping": float(damping),
        "length": float(np.linalg.norm(right - left)),
        "speed": float(np.linalg.norm(velocity[1])),
    }


def main():
    runs = list(product(STIFFNESS, DAMPING))
    # A process for each worker, of one thread: an engine is at work for one task at a time.
    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster, Client(cluster) as client:
        table = client.gather([client.submit(run, *values) for values in runs])

    path = sys.argv[1] if len(sys.argv) > 1 else "sweep_dask.csv"
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, table[0])
        writer.writeheader()
        writer.writerows(table)

    # The same bits in whatever process.
    assert table[0] == run(*runs[0]) and table[-1] == run(*runs[-1])
    calm = max(table, key=lambda row: row["damping"] / row["stiffness"])
    print(f"{len(table)} runs are in {path}; with the most damping for its stiffness the spring is {calm['length']:.3f} m long after 5 s")


if __name__ == "__main__":
    main()

"""Integrates bodies with REBOUND, for `cargo bench -- work_precision`.

In: on standard input, one JSON object: `g`, `bodies` (mass, position, velocity of each), `times`, `runs` (integrator, setting,
options), `repeats` at least, and `seconds`. Out: on standard output, one JSON object: the version, and for each run the times of its repeats in s, and
positions and velocities at the times. Timed is `integrate` alone, as REBOUND's users call it: compiled C, one thread.
"""

import json
import sys
import time

import rebound


def simulation(asked, run):
    """A simulation at the start."""
    simulation = rebound.Simulation()
    simulation.G = asked["g"]
    for mass, (x, y, z), (vx, vy, vz) in asked["bodies"]:
        simulation.add(m=mass, x=x, y=y, z=z, vx=vx, vy=vy, vz=vz)
    simulation.integrator = run["integrator"]
    for option, value in run["options"].items():
        setattr(simulation.integrator, option, int(value) if value.isdigit() else value)
    if run["integrator"] == "ias15":
        simulation.integrator.epsilon = run["setting"]
    else:
        simulation.dt = run["setting"]
    return simulation


def integrated(asked, run):
    """The time that it takes, and the states on the way."""
    bodies = simulation(asked, run)
    spent, states = 0.0, []
    for moment in asked["times"]:
        begin = time.perf_counter()
        bodies.integrate(moment)
        spent += time.perf_counter() - begin
        bodies.synchronize()
        states.append([[[p.x, p.y, p.z], [p.vx, p.vy, p.vz]] for p in bodies.particles])
    return spent, states


def main():
    """Every run, its repeats one after the other."""
    asked = json.load(sys.stdin)
    told = []
    for run in asked["runs"]:
        took = [integrated(asked, run)]
        while len(took) < asked["repeats"] or sum(spent for spent, _ in took) < asked["seconds"] and len(took) < 1000:
            took.append(integrated(asked, run))
        told.append({"seconds": [spent for spent, _ in took], "states": took[0][1]})
    json.dump({"version": rebound.__version__, "runs": told}, sys.stdout)


main()

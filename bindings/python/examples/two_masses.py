# %% [markdown]
# # Two masses and a spring
#
# Two masses hang on a spring and are thrown upwards. One of them is kicked on the way, by writing into an array. Run as cells
# (`# %%`) in an editor or a notebook, or as a whole: `python two_masses.py picture.png`.

# %%
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import vesper

# %% [markdown]
# Columns are arrays of numpy, in SI units. With `lend=True` the engine works in these very arrays.

# %%
position = np.array([[-10.0, 5, 0], [10, 5, 0]])
velocity = np.array([[0.0, 0, 15], [0, 0, 15]])
mass = np.array([1.0, 1.0])


# %% [markdown]
# A law of one's own, as a function over whole columns. Its parameters are named as what it looks at.


# %%
@vesper.law(adds="force")
def drag(velocity):
    return -0.05 * velocity


# %%
engine = vesper.Engine(
    domains={
        "bodies": {"position": position, "velocity": velocity, "mass": mass},
        "springs": {"ends": vesper.Link("bodies", [[0, 1]]), "stiffness": 100.0, "damping": 2.0, "rest_length": 10.0},
    },
    constants={"gravity": [0, 0, -9.81]},
    laws=["spring", "damper", "uniform_gravity", drag, "motion"],
    integrator="runge_kutta_4",
    step=1e-3,
    lend=["bodies.position", "bodies.velocity"],
)
print(engine.report())

# %% [markdown]
# `advance` takes as many steps as fit into a frame. Half way the second mass is kicked: the engine sees it.

# %%
times, places = [], []
for frame in range(300):
    if frame == 150:
        velocity[1] += [0, 0, 12]
    engine.advance(0.01)
    times.append(engine.time)
    places.append(position.copy())
times, places = np.array(times), np.array(places)

# %%
length = np.linalg.norm(places[:, 1] - places[:, 0], axis=1)
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
for body in range(2):
    left.plot(places[:, body, 0], places[:, body, 2], label=f"mass {body}")
left.set(xlabel="x, m", ylabel="z, m", title="paths")
left.legend()
right.plot(times, length)
right.axhline(10, color="grey", linewidth=0.5)
right.set(xlabel="time, s", ylabel="length of the spring, m", title="spring")

# %%
picture = sys.argv[1] if len(sys.argv) > 1 and sys.argv[1].endswith(".png") else "two_masses.png"
figure.savefig(picture, dpi=100)
print(f"after {engine.time:.2f} s the spring is {length[-1]:.3f} m long; {picture} shows the way")

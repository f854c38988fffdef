# %% [markdown]
# # The cost of accuracy
#
# The same swarm of bodies is played at several accuracies. The program prints, for each, the time per frame, the number
# of pairs that may collide, and how many of these are separate. Run it as a program, or open it as a notebook: each
# `# %%` begins a cell. It draws speed_and_error.png if matplotlib is installed.

# %%
import numpy as np

import oncollide
from oncollide import Verdict

rng = np.random.default_rng(3)
knot = oncollide.torus_knot_mesh(2, 3, 0.35, 0.14, 0.06, 3000)
rock = oncollide.sphere_mesh(0.4, 2000)
count, frames = 120, 8
start = np.zeros((count, 7))
start[:, :3] = rng.uniform(0, 4.5, (count, 3))
start[:, 3:] = rng.normal(size=(count, 4))
start[:, 3:] /= np.linalg.norm(start[:, 3:], axis=1, keepdims=True)
velocity = rng.normal(size=(count, 3)) * 0.02  # metres per frame

# %% [markdown] `play` steps a World through all frames and keeps the pairs that are not certainly apart. It takes
# settings by the names of the command's options; the first frames, in which trees grow, are not timed.


# %%
def play(**settings):
    """(milliseconds per frame, pairs of all frames as (frame, a, b))"""
    world = oncollide.World(**settings)
    models = [world.models.add(mesh) for mesh in (knot, rock)]
    bodies = np.concatenate([world.bodies.add(m, start[k::2]) for k, m in enumerate(models)])
    order = np.concatenate([np.arange(count)[0::2], np.arange(count)[1::2]])
    times, pairs = [], set()
    for number in range(frames):
        poses = start.copy()
        poses[:, :3] += number * velocity
        world.bodies.set_pose(bodies, poses[order])
        frame = world.step()
        times.append(frame.ms)
        left = frame.pairs[frame.pairs["verdict"] != Verdict.SEPARATE]
        a, b = oncollide.slots(left["a"]), oncollide.slots(left["b"])  # ids differ from World to World
        pairs |= {(number, *pair) for pair in zip(a.tolist(), b.tolist())}
    return float(np.median(times[3:])), pairs


# %% [markdown] The exact level gives the truth: every colliding pair must be among the pairs that are left over at any
# error. None is ever missed; a larger error only leaves more pairs.

# %%
exact_ms, truth = play(exact="predicates")
errors = [0.3, 0.1, 0.05, 0.02, 0.01, 0.005]
curves = {}
for name, volume in (("oriented boxes", "obb"), ("spheres, as in the paper", "sphere")):
    rows = []
    for error in errors:
        ms, left = play(max_error=error, bounding_volume=volume)
        assert truth <= left, "no collision is missed"
        rows.append((ms, len(left - truth)))
        print(f"{name}, {1000 * error:g} mm: {len(left)} pairs may collide, {len(left - truth)} of them are apart")
    curves[name] = np.array(rows)
print(f"exact: {len(truth)} pairs collide")

# %%
try:
    import matplotlib.pyplot as plt
except ImportError:
    print("no picture: matplotlib is not installed (python3-matplotlib)")
else:
    figure, (time_axes, false_axes) = plt.subplots(1, 2, figsize=(11, 4.5), sharex=True)
    for (name, rows), colour in zip(curves.items(), ("#e69f00", "#0072b2")):
        time_axes.plot(errors, rows[:, 0], "o-", color=colour, label=name)
        false_axes.plot(errors, 100 * rows[:, 1] / len(truth), "o-", color=colour, label=name)
    time_axes.axhline(exact_ms, color="#009e73", linestyle="--", label="exact")
    time_axes.set(title="Time of a frame", xlabel="max_error, m", ylabel="ms", xscale="log", yscale="log")
    false_axes.set(title="Pairs left over that are apart", xlabel="max_error, m", ylabel="% of the collisions", xscale="log")
    time_axes.legend()
    figure.tight_layout()
    figure.savefig("speed_and_error.png", dpi=100)
    print("drawn: speed_and_error.png")

# %% [markdown]
# # Rocks that fall onto a terrain
#
# A World of one terrain and many rocks, stepped as a simulator would: poses in, pairs and bounds out. Run it as a
# program, or open it as a notebook: each `# %%` begins a cell. It draws rocks.png if matplotlib is installed.

# %%
import numpy as np

import oncollide

rng = np.random.default_rng(1)
x, y = np.meshgrid(np.linspace(0, 20, 81), np.linspace(0, 20, 81))
heights = 1.5 * np.sin(0.6 * x) * np.cos(0.5 * y) + 0.05 * rng.normal(size=x.shape)

world = oncollide.World(max_error=0.01)  # metres
land = world.bodies.add(world.models.add(oncollide.terrain(heights, spacing=0.25, name="hills")), static=True)

# %% [markdown]
# All rocks share two models, and with them their trees. `bodies.add` takes many poses as (N, 4, 4), or as position and
# quaternion, (N, 7).

# %%
count = 200
poses = np.zeros((count, 7))
poses[:, :3] = rng.uniform([1, 1, 4], [19, 19, 30], (count, 3))
poses[:, 3:] = rng.normal(size=(count, 4))
poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)
round_rocks = world.bodies.add(world.models.add(oncollide.sphere_mesh(0.3, 500)), poses[: count // 2])
sharp_rocks = world.bodies.add(world.models.add(oncollide.convex_hull(rng.normal(size=(12, 3)) * 0.25)), poses[count // 2 :])
rocks = np.concatenate([round_rocks, sharp_rocks])

# %% [markdown]
# Rocks fall until they meet something; then they rest. Every pair that is not separate has an upper bound on the
# distance of the two bodies.

# %%
speed = np.zeros(count)
resting = np.zeros(count, bool)
index = {int(body): i for i, body in enumerate(rocks)}
history, bounds = [], []
for frame_number in range(300):
    moving = ~resting
    speed[moving] += 9.81 / 60
    poses[moving, 2] -= speed[moving] / 60
    world.bodies.set_pose(rocks[moving], poses[moving])
    frame = world.step()
    close = frame.pairs[frame.pairs["verdict"] != oncollide.Verdict.SEPARATE]
    bounds.append(close["bound"].max(initial=0))
    for body in np.union1d(close["a"], close["b"]):
        if int(body) in index:
            resting[index[int(body)]] = True
    history.append((resting.sum(), len(frame.pairs), frame.ms))
    if resting.all():
        break

print(f"{resting.sum()} of {count} rocks rest after {len(history)} frames")
print(f"every bound is at most 1 cm: {max(bounds) <= 0.01}")

# %% [markdown] How deep is the valley under a rock that rests? `distance` returns certified bounds and the two nearest
# points.

# %%
lowest = rocks[np.argmin(poses[:, 2])]
found = world.pairs.distance(lowest, land)
print(f"the lowest rock is at most {100 * found['upper']:.1f} cm above the ground")

# %%
try:
    import matplotlib.pyplot as plt
except ImportError:
    print("no picture: matplotlib is not installed (python3-matplotlib)")
else:
    history = np.array(history)
    figure, (map_axes, time_axes) = plt.subplots(1, 2, figsize=(11, 4.5))
    shown = map_axes.pcolormesh(x, y, heights, shading="auto", cmap="terrain")
    map_axes.scatter(*poses[resting, :2].T, c="black", s=8, label="at rest")
    map_axes.scatter(*poses[~resting, :2].T, c="red", s=8, label="still falling")
    map_axes.set(title="Where the rocks are", xlabel="x, m", ylabel="y, m", aspect="equal")
    figure.colorbar(shown, ax=map_axes, label="height, m")
    map_axes.legend(loc="upper right")
    time_axes.plot(history[:, 0], label="rocks at rest")
    time_axes.plot(history[:, 1], label="pairs whose AABBs overlap")
    time_axes.set(title="Rocks that rest, and candidates for collisions", xlabel="frame")
    time_axes.legend()
    figure.tight_layout()
    figure.savefig("rocks.png", dpi=100)
    print("drawn: rocks.png")

# %% [markdown]
# # A map of where a body fits
#
# A planner tests many times whether a body collides at a pose. `World.pairs` tests whole arrays of poses at once. Here a
# T-shaped body is tested at every position and rotation of a grid in a flat with two rooms. Run it as a program, or open
# it as a notebook: each `# %%` begins a cell. It draws fits.png if matplotlib is installed.

# %%
import numpy as np

import oncollide


def joined(*boxes):
    """One mesh of several boxes: (centre, half-extents) each, metres."""
    vertices, faces, used = [], [], 0
    for middle, half in boxes:
        box = oncollide.box_mesh(half)
        vertices.append(box.vertices + middle)
        faces.append(box.faces + used)
        used += len(box.vertices)
    return oncollide.mesh(np.concatenate(vertices), np.concatenate(faces))


body = joined(([0, 0, 0], [0.7, 0.1, 0.4]), ([0.6, 0, 0], [0.1, 0.45, 0.4]))
walls = joined(
    ([0, 2.5, 0], [4, 0.1, 1]), ([0, -2.5, 0], [4, 0.1, 1]), ([-4, 0, 0], [0.1, 2.6, 1]), ([4, 0, 0], [0.1, 2.6, 1]),
    ([0, 1.5, 0], [0.1, 1.0, 1]), ([0, -1.5, 0], [0.1, 1.0, 1]),  # a doorway of 1 m
)  # fmt: skip

# %% [markdown]
# Poses are one array, (N, 4, 4), C-contiguous and float64: it is used where it lies. The walls have one pose for all queries.

# %%
steps, turns = 121, 36
grid_x, grid_y = np.linspace(-4, 4, steps), np.linspace(-2.5, 2.5, 76)
angle = np.linspace(0, 2 * np.pi, turns, endpoint=False)
a, y, x = np.meshgrid(angle, grid_y, grid_x, indexing="ij")
poses = np.zeros((a.size, 4, 4))
poses[:, 0, 0] = poses[:, 1, 1] = np.cos(a).ravel()
poses[:, 1, 0] = np.sin(a).ravel()
poses[:, 0, 1] = -poses[:, 1, 0]
poses[:, 0, 3], poses[:, 1, 3] = x.ravel(), y.ravel()
poses[:, 2, 2] = poses[:, 3, 3] = 1

# %%
world = oncollide.World(exact="predicates", threads=0)
body, walls = world.models.add(body), world.models.add(walls)
found = world.pairs.decide((body, poses), (walls, None))
free = (found["verdict"] == oncollide.Verdict.SEPARATE).reshape(a.shape)
print(f"{found.size} poses, {100 * free.mean():.0f} % of them are free")

# %% [markdown]
# In the doorway the body fits at few rotations. `distance` returns the remaining clearance.

# %%
middle = np.argmin(np.abs(grid_x)), np.argmin(np.abs(grid_y))
turns_that_fit = np.flatnonzero(free[:, middle[1], middle[0]])
print(f"in the doorway it fits at {len(turns_that_fit)} of {turns} rotations")
place = poses.reshape(*a.shape, 4, 4)[turns_that_fit, middle[1], middle[0]]
room = world.pairs.distance((body, place), (walls, None))
print(f"and at the best of them it has {100 * room['upper'].max(initial=0):.0f} cm of room")

# %%
try:
    import matplotlib.pyplot as plt
except ImportError:
    print("no picture: matplotlib is not installed (python3-matplotlib)")
else:
    figure, axes = plt.subplots(figsize=(9, 5.5))
    shown = axes.pcolormesh(grid_x, grid_y, free.sum(axis=0), shading="auto", cmap="viridis")
    figure.colorbar(shown, label=f"rotations, of {turns}, at which the body fits")
    axes.set(title="Where a T-shaped body fits", xlabel="x, m", ylabel="y, m", aspect="equal")
    figure.tight_layout()
    figure.savefig("fits.png", dpi=100)
    print("drawn: fits.png")

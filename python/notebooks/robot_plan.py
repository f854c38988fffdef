# %% [markdown]
# # A plan for an arm
#
# An arm of two bars moves between posts. `Robot.check` tests whole arrays of configurations, `Robot.check_edges` whole
# motions: a free one is certified, there is no post between its samples. A planner of forty lines uses it; then gradients
# of `Robot.distances` move the plan away from the posts. Run it as a program, or open it as a notebook: each `# %%`
# begins a cell. It writes plan.html, the plan in 3D, if the command `oncollide` is installed, and draws plan.png if
# matplotlib is.

# %%
import json
import pathlib
import shutil
import subprocess

import numpy as np

import oncollide

bar = '<collision><origin xyz="0.5 0 0"/><geometry><box size="0.9 0.04 0.1"/></geometry></collision>'
pathlib.Path("arm.urdf").write_text(f"""<robot name="arm">
  <link name="base"/> <link name="upper">{bar}</link> <link name="lower">{bar}</link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/>
    <origin xyz="1 0 0"/><axis xyz="0 0 1"/><limit lower="-2.9" upper="2.9"/></joint>
</robot>
""")
posts = [(1.5, 0.4), (1.2, -0.8), (-0.3, 1.3), (0.7, 1.2)]

world = oncollide.World(threads=0)
post = world.models.add(oncollide.cylinder(0.03, 1))
for x, y in posts:
    world.bodies.add(post, [x, y, 0, 0, 0, 0, 1], static=True)
robot = oncollide.Robot(world, "arm.urdf")

# %% [markdown]
# All configurations of a grid, in one call.

# %%
low, high = np.array([-3, -2.9]), np.array([3, 2.9])
shoulder, elbow = np.meshgrid(np.linspace(low[0], high[0], 241), np.linspace(low[1], high[1], 233))
grid = np.stack([shoulder.ravel(), elbow.ravel()], axis=1)
free = robot.check(grid)["verdict"] == oncollide.Verdict.SEPARATE
print(f"{len(grid)} configurations, {100 * free.mean():.0f} % of them are free")

# %% [markdown]
# RRT-Connect: two trees of configurations grow towards random ones and towards each other.


# %%
def grown(tree, target, reach=0.6):
    """Adds a configuration to the tree, at most `reach` away in the direction of the target. None: the motion is not free."""
    points, parents = tree
    near = int(np.argmin(np.linalg.norm(np.array(points) - target, axis=1)))
    way = target - points[near]
    length = np.linalg.norm(way)
    new = target if length <= reach else points[near] + reach / length * way
    if robot.check_edges(points[near], new, first=False)["verdict"] != oncollide.Verdict.SEPARATE:
        return None
    points.append(new)
    parents.append(near)
    return new


def way_to_root(tree):
    """The configurations from the last one of a tree to its first."""
    points, parents = tree
    at, way = len(points) - 1, []
    while at >= 0:
        way.append(points[at])
        at = parents[at]
    return way


def plan(start, goal, seed=1, tries=10_000):
    rng = np.random.default_rng(seed)
    from_start, from_goal = ([start], [-1]), ([goal], [-1])
    for attempt in range(tries):
        a, b = (from_start, from_goal) if attempt % 2 == 0 else (from_goal, from_start)
        new = grown(a, rng.uniform(low, high))
        while new is not None:
            step = grown(b, new)
            if step is None:
                break
            if step is new:  # the trees meet
                return np.array(way_to_root(from_start)[::-1] + way_to_root(from_goal)[1:])
    raise SystemExit("no plan was found")


way = plan(np.array([-1.5, 0.3]), np.array([2.3, 0.4]))
edges = robot.check_edges(way[:-1], way[1:])
print(f"a plan of {len(edges)} motions; all of them are free: {(edges['verdict'] == oncollide.Verdict.SEPARATE).all()}")

# %% [markdown]
# The plan grazes posts. `Robot.distances` returns the least distance of each configuration and its gradient. Steps along
# it, where a post is closer than 10 cm, make the plan wide, steps towards the neighbours' mean make it smooth.
# `Robot.edge_clearance` certifies how near it comes to the posts, between the configurations too: a step that would
# bring it nearer is the last.

# %%
found, before = way, robot.edge_clearance(way[:-1], way[1:])["lower"].min()
knots = np.linspace(0, len(found) - 1, 20 * (len(found) - 1) + 1)
way = np.stack([np.interp(knots, np.arange(len(found)), found[:, joint]) for joint in range(2)], axis=1)
after, next_way = before, way
for step in range(2000):
    pairs, gradients, _ = robot.distances(next_way)
    away = np.clip(0.1 - pairs["upper"], 0, None)[:, None] * gradients
    next_way = next_way.copy()
    next_way[1:-1] += 0.5 * away[1:-1] + 0.1 * (0.5 * (next_way[:-2] + next_way[2:]) - next_way[1:-1])
    if step % 20 == 19:
        clearance = robot.edge_clearance(next_way[:-1], next_way[1:])["lower"].min()
        if clearance < after:
            break
        way, after = next_way, clearance
print(f"the plan comes as near as {1000 * before:.1f} mm to a post; after {step + 1} steps, {1000 * after:.1f} mm")

# %% [markdown]
# The plan in 3D: a scene with a key frame for each pose of the bars, and the page that `oncollide run --view` makes of it.

# %%
frames = 240
share = np.linspace(0, len(way) - 1, frames)
configurations = np.stack([np.interp(share, np.arange(len(way)), way[:, joint]) for joint in range(2)], axis=1)
poses = robot.link_poses(configurations)  # (frames, links, 4, 4)
bodies = [{"geometry": "post", "position": [x, y, 0], "static": True} for x, y in posts]
for link in (1, 2):
    middle = poses[:, link, :3, :3] @ [0.5, 0, 0] + poses[:, link, :3, 3]
    half_angle = 0.5 * np.arctan2(poses[:, link, 1, 0], poses[:, link, 0, 0])
    keys = np.zeros((frames, 8))
    keys[:, 0], keys[:, 1:4] = np.arange(frames), middle
    keys[:, 6], keys[:, 7] = np.sin(half_angle), np.cos(half_angle)
    bodies.append({"name": robot.links[link], "geometry": "bar", "group": 1, "motion": {"keys": keys.tolist()}})
geometries = {"bar": {"shape": {"kind": "box", "half": [0.45, 0.02, 0.05]}},
              "post": {"shape": {"kind": "cylinder", "radius": 0.03, "length": 1}}}  # fmt: skip
pathlib.Path("plan.json").write_text(json.dumps({"frames": frames, "geometries": geometries, "bodies": bodies}))
if shutil.which("oncollide"):
    subprocess.run(["oncollide", "run", "plan.json", "--view", "plan.html", "--exit-code", "--quiet"], check=True)
    print("no frame of plan.html has a contact")
else:
    print("no page: the command oncollide is not installed")

# %%
try:
    import matplotlib.pyplot as plt
except ImportError:
    print("no picture: matplotlib is not installed (python3-matplotlib)")
else:
    figure, axes = plt.subplots(figsize=(6.5, 6))
    axes.pcolormesh(shoulder, elbow, free.reshape(shoulder.shape), shading="auto", cmap="gray", vmin=-1)
    axes.plot(found[:, 0], found[:, 1], "o-", color="tab:orange", label="the plan")
    axes.plot(way[:, 0], way[:, 1], color="tab:red", label="smoothed")
    axes.set(title="Configurations: free ones are white", xlabel="shoulder, rad", ylabel="elbow, rad", aspect="equal")
    axes.legend()
    figure.tight_layout()
    figure.savefig("plan.png", dpi=100)
    print("drawn: plan.png")

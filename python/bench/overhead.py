"""Measures the overhead of a call over the same call in C++: prints a table, and CSV.

    ninja -C build/release oncollide_python oncollide_python_baseline
    PYTHONPATH=build/release/python python3 python/bench/overhead.py --baseline build/release/python/oncollide_python_baseline
"""

import argparse
import csv
import platform
import subprocess
import timeit

import numpy as np

import oncollide

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--baseline", help="the program that times the same calls in C++; without it there is no overhead column")
parser.add_argument("--csv", help="where to write the table")
parser.add_argument("--seconds", type=float, default=0.2, help="about, per call")
parser.add_argument("--rounds", type=int, default=3, help="of all calls; the least time counts")
options = parser.parse_args()


def at(x):
    pose = np.eye(4)
    pose[0, 3] = x
    return pose


def poses(xs):
    made = np.tile(np.eye(4), (len(xs), 1, 1))
    made[:, 0, 3] = xs
    return made


empty, world = oncollide.World(exact="predicates"), oncollide.World(exact="predicates")
ball = world.models.add(oncollide.sphere(1.0))
a, b = world.bodies.add(ball), world.bodies.add(ball, at(3))
places = poses(100 + 3 * np.arange(10_000))
many = world.bodies.add(ball, places)
pose, far, here = at(3), at(50), np.eye(4)
count = 100_000
batch = poses(3 + 1e-5 * np.arange(count))
batch_here, balls = np.tile(here, (count, 1, 1)), np.full(count, int(ball), np.uint64)

# Name, call, number of items that it processes.
CALLS = [
    ("bodies.is_static", lambda: world.bodies.is_static(b), 1),
    ("bodies.pose", lambda: world.bodies.pose(b), 1),
    ("bodies.set_pose", lambda: world.bodies.set_pose(b, pose), 1),
    ("space.overlaps", lambda: world.space.overlaps(ball, far), 1),
    ("pairs.distance", lambda: world.pairs.distance(a, b), 1),
    ("World.step", lambda: empty.step(), 1),
    ("bodies.set_pose of many", lambda: world.bodies.set_pose(many, places), 10_000),
    ("pairs.decide of many", lambda: world.pairs.decide((balls, batch_here), (balls, batch)), count),
]


def nanoseconds(call, items):
    timer = timeit.Timer(call)
    calls = 1
    while timer.timeit(calls) < options.seconds / 10:
        calls *= 2
    return 1e9 * min(timer.repeat(5, calls)) / calls / items


def baseline():
    done = subprocess.run([options.baseline, str(options.seconds)], capture_output=True, text=True, check=True)
    return {name: float(ns) for name, ns in (line.rsplit(" ", 1) for line in done.stdout.splitlines())}


least, native = {}, {}
for _ in range(options.rounds):  # in rounds, so that other processes affect all calls alike
    if options.baseline:
        for name, ns in baseline().items():
            native[name] = min(ns, native.get(name, ns))
    for name, call, items in CALLS:
        ns = nanoseconds(call, items)
        least[name] = min(ns, least.get(name, ns))

rows = [
    {
        "call": name,
        "items": items,
        "python_ns": f"{least[name]:.0f}",
        "cpp_ns": f"{native[name]:.0f}" if native else "",
        "overhead_ns": f"{least[name] - native[name]:.0f}" if native else "",
    }
    for name, _, items in CALLS
]
print(f"nanoseconds per item, least of several runs; Python {platform.python_version()}, NumPy {np.__version__}")
for row in [dict(zip(rows[0], rows[0])), *rows]:
    print(f"{row['call']:24}{row['items']:>8}{row['python_ns']:>12}{row['cpp_ns']:>10}{row['overhead_ns']:>14}")
if options.csv:
    with open(options.csv, "w", newline="") as out:
        writer = csv.DictWriter(out, rows[0], lineterminator="\n")
        writer.writeheader(), writer.writerows(rows)

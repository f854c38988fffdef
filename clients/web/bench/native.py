#!/usr/bin/env python3
"""Times the native library on the meshes, poses and moving bodies of bench.mjs, which starts this program (--native).

usage: native.py FOLDER     FOLDER has the files of bench.mjs; the times go to standard output, as JSON
"""
import json
import pathlib
import sys
import time

import numpy as np

import oncollide

FOLDER = pathlib.Path(sys.argv[1])
GIVEN = json.loads((FOLDER / "given.json").read_text(encoding="utf-8"))
ROUNDS = GIVEN["rounds"]


def numbers(name, kind=np.float64):
    return np.fromfile(FOLDER / name, kind)


def poses(flat):
    """Matrices of poses that are written column by column."""
    return np.ascontiguousarray(flat.reshape(-1, 4, 4).transpose(0, 2, 1))


def geometry(name):
    return oncollide.mesh(numbers(f"{name}.vertices").reshape(-1, 3), numbers(f"{name}.faces", np.uint32).reshape(-1, 3))


def least_us(count, run):
    """Microseconds for each of `count` queries: the least of the rounds. The first round makes the trees."""
    run()
    best = float("inf")
    for _ in range(ROUNDS):
        began = time.perf_counter()
        run()
        best = min(best, time.perf_counter() - began)
    return 1e6 * best / count


def pair(name):
    world = oncollide.World(exact="predicates", threads=1)
    model, places = world.models.add(geometry(name)), poses(numbers(f"{name}.poses"))
    still = np.tile(np.eye(4), (len(places), 1, 1))
    models = np.full(len(places), int(model), np.uint64)
    apart = np.array(json.loads((FOLDER / f"{name}.apart").read_text(encoding="utf-8")), int)
    decide = lambda: world.pairs.decide((models, still), (models, places))
    distance = lambda: world.pairs.distance((models[apart], still[apart]), (models[apart], places[apart]))
    return {"colliding": int(np.sum(decide()["verdict"] == 2)),
            "decide_us": least_us(len(places), decide), "distance_us": least_us(len(apart), distance)}


def crowd(count, kinds, frames):
    world = oncollide.World(exact="predicates", threads=1)
    models = [world.models.add(geometry(f"kind{k}")) for k in range(kinds)]
    places = numbers(f"crowd{count}").reshape(frames, count, 4, 4).transpose(0, 1, 3, 2).copy()
    bodies = np.array([world.bodies.add(models[i % kinds], places[0, i]) for i in range(count)], np.uint64)
    times, met = [], 0
    for frame in places:
        began = time.perf_counter()
        world.bodies.set_pose(bodies, frame)
        made = world.step()
        pairs = made.pairs
        times.append(time.perf_counter() - began)
        met = int(np.sum(pairs["verdict"] == 2))
    return {"median_ms": 1000 * float(np.median(times[10:])), "pairs": met}


print(json.dumps({"pairs": [pair(name) for name in GIVEN["pairs"]],
                  "crowds": [crowd(c["bodies"], c["kinds"], c["frames"]) for c in GIVEN["crowds"]]}))

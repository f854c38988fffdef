"""Queries: batches from arrays, without copies."""

import tracemalloc

import numpy as np
import pytest

import oncollide
from conftest import at, matrices, random_poses
from oncollide import Queries, Verdict

KNOT = oncollide.torus_knot_mesh(2, 3, 1, 0.4, 0.15, 400)
ALL = [KNOT, oncollide.sphere(0.7), oncollide.box([0.5, 0.7, 0.9]), oncollide.hills(10, 10, 0.3, 0.5, 2),
       oncollide.occupancy_map([[0, 0, 0], [1, 0, 0], [1, 1, 0]], 0.4)]  # fmt: skip


def test_batches_answer_as_a_world_does_for_every_two_kinds():
    count = 500
    a, b = np.arange(count) % len(ALL), np.arange(count) // len(ALL) % len(ALL)
    poses_a, poses_b = random_poses(count, 1, 1), random_poses(count, 1, 2)
    verdict, bound = Queries(ALL, exact="predicates").run(a, b, poses_a, poses_b)
    assert (verdict.dtype, bound.dtype, verdict.shape, bound.shape) == (np.uint8, np.float64, (count,), (count,))
    world = oncollide.World(exact="predicates")
    models = [world.add(geometry) for geometry in ALL]
    for i in range(count):
        body = world.add_body(models[b[i]], poses_b[i])
        hits = world.query(models[a[i]], poses_a[i])
        assert hits["verdict"].tolist() == ([] if verdict[i] == Verdict.SEPARATE else [verdict[i]]), i
        world.remove_body(body)
    assert 100 < np.count_nonzero(verdict) < 450


def test_results_depend_on_no_threads_no_types_and_no_company():
    count = 20_000
    poses = matrices(random_poses(count, 2.5, 3))
    one, three = Queries(ALL), Queries(ALL, threads=3)
    expected = one.run(0, 1, np.eye(4), poses)
    for got in [
        three.run(0, 1, np.eye(4), poses),
        one.run(np.zeros(count, np.uint32), np.ones(count, np.uint32), np.tile(np.eye(4), (count, 1, 1)), poses),
        one.run([0] * count, np.uint8(1), [0, 0, 0, 0, 0, 0, 1], np.asfortranarray(poses)),
        one.run(np.zeros(2 * count, int)[::2], np.ones(count, np.int8), np.eye(4, dtype=int), poses.astype(np.longdouble)),
    ]:
        assert np.array_equal(got[0], expected[0]) and np.array_equal(got[1], expected[1])
    for i in range(0, count, 4999):
        verdict, bound = one.run(0, 1, np.eye(4), poses[i])
        assert (verdict[0], bound[0]) == (expected[0][i], expected[1][i])


def test_distances_are_those_of_a_world():
    poses = random_poses(40, 3, 4)
    found = Queries(ALL).distances(0, 2, np.eye(4), poses, tolerance=1e-3)
    world = oncollide.World()
    still, moving = world.add_body(world.add(ALL[0])), world.add_body(world.add(ALL[2]))
    for i, pose in enumerate(poses):
        world.set_pose(moving, pose)
        exact = world.distance(still, moving)
        assert found["lower"][i] <= exact["upper"] and exact["lower"] <= found["upper"][i] <= found["lower"][i] + 1.1e-3
    for name in ("cutoff", "farthest"):
        assert np.isinf(Queries(ALL).distances(0, 2, np.eye(4), at(9), **{name: 1.0})["upper"]).all()


def test_contiguous_doubles_are_not_copied():
    count = 100_000
    queries = Queries([oncollide.sphere(1.0)])
    poses = np.tile(at(5), (count, 1, 1))
    number = np.zeros(count, np.uint32)

    def peak(of):
        tracemalloc.start()
        queries.run(number, number, of, of)
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return most

    assert peak(poses) < 1.2e6, "the results take 0.9 MB"
    assert peak(poses.astype(np.float32)) > poses.nbytes, "float32 arrays are copied, which shows that the test detects copies"


def test_no_queries_give_no_results():
    verdict, bound = Queries(ALL).run([], 1, np.empty((0, 4, 4)), np.eye(4))
    assert verdict.shape == bound.shape == (0,)
    assert len(Queries(ALL)) == 5 and len(Queries([])) == 0 and Queries(ALL).bytes >= 0


def test_queries_keep_their_geometries():
    queries = Queries([oncollide.sphere_mesh(1.0, 200)])  # the only reference
    verdict, _ = queries.run(0, 0, np.eye(4), np.stack([at(0.5), at(5)]))
    assert verdict.tolist() == [Verdict.COLLIDING, Verdict.SEPARATE]


def test_the_query_that_is_wrong_is_named():
    poses = np.tile(np.eye(4), (10, 1, 1))
    poses[7, 0, 0] = np.nan
    with pytest.raises(oncollide.Error, match="pair 7: b: the pose is not finite"):
        Queries(ALL).run(0, 1, np.eye(4), poses)

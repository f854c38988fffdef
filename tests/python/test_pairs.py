"""Pairs: one or many, bodies and models at poses, from arrays without copies."""

import tracemalloc

import numpy as np
import pytest

import oncollide
from conftest import at, matrices, random_poses
from oncollide import Verdict

KNOT = oncollide.torus_knot_mesh(2, 3, 1, 0.4, 0.15, 400)
ALL = [KNOT, oncollide.sphere(0.7), oncollide.box([0.5, 0.7, 0.9]), oncollide.hills(10, 10, 0.3, 0.5, 2),
       oncollide.occupancy_map([[0, 0, 0], [1, 0, 0], [1, 1, 0]], 0.4)]  # fmt: skip


def world_of(*geometries, **settings):
    world = oncollide.World(**settings)
    return world, [world.models.add(geometry) for geometry in geometries]


def test_batches_answer_as_space_does_for_every_two_kinds():
    count = 500
    world, models = world_of(*ALL)
    a = [models[i % len(ALL)] for i in range(count)]
    b = [models[i // len(ALL) % len(ALL)] for i in range(count)]
    poses_a, poses_b = random_poses(count, 1, 1), random_poses(count, 1, 2)
    found = world.pairs.decide((a, poses_a), (b, poses_b))
    assert found.dtype.names == ("verdict", "kind", "bound") and found.shape == (count,)
    assert (found["verdict"].dtype, found["bound"].dtype) == (np.uint8, np.float64)
    for i in range(count):
        body = world.bodies.add(b[i], poses_b[i])
        hits = world.space.overlaps(a[i], poses_a[i])
        verdict = found["verdict"][i]
        assert hits["verdict"].tolist() == ([] if verdict == Verdict.SEPARATE else [verdict]), i
        world.bodies.remove(body)
    assert 100 < np.count_nonzero(found["verdict"]) < 450


def test_results_depend_on_no_threads_no_types_and_no_company():
    count = 20_000
    poses = matrices(random_poses(count, 2.5, 3))
    world, (knot, ball, *_) = world_of(*ALL)
    expected = world.pairs.decide((knot, None), (ball, poses)).tobytes()
    three, (other_knot, other_ball, *_) = world_of(*ALL, threads=3)
    assert three.pairs.decide((other_knot, None), (other_ball, poses)).tobytes() == expected
    numbers = np.full(count, int(knot), np.uint64)
    for a, b in [
        ((numbers, np.tile(np.eye(4), (count, 1, 1))), ([ball] * count, poses)),
        ((knot, [0, 0, 0, 0, 0, 0, 1]), (ball, np.asfortranarray(poses))),
        ((np.repeat(numbers, 2)[::2], np.eye(4, dtype=int)), (np.array([ball] * count), poses.astype(np.longdouble))),
    ]:
        assert world.pairs.decide(a, b).tobytes() == expected
    found = world.pairs.decide((knot, None), (ball, poses))
    for i in range(0, count, 4999):
        assert world.pairs.decide((knot, None), (ball, poses[i])) == found[i]


def test_sides_are_bodies_or_models_one_or_many():
    world, (knot, ball, *_) = world_of(*ALL)
    poses = matrices(random_poses(30, 2, 4))
    still, moving = world.bodies.add(knot), world.bodies.add(ball, poses)
    for query in (world.pairs.decide, world.pairs.distance, world.pairs.penetration):
        expected = query((knot, None), (ball, poses)).tobytes()
        for a, b in [(still, moving), (still, (ball, poses)), ((knot, None), moving), ([still] * 30, moving.tolist())]:
            assert query(a, b).tobytes() == expected
        one = query(still, moving[3])
        assert one.shape == () and one == query((knot, None), (ball, poses))[3] == query(still, (ball, poses[3]))
        assert query(still, moving[3:4]).shape == (1,), "many of one"
    assert world.pairs.max_error(still, (ball, None)) == world.pairs.max_error(still, moving[0])


def test_lists_of_many_pairs_have_offsets():
    world, (knot, _, box, *_) = world_of(*ALL)
    poses = matrices(random_poses(20, 1.5, 5))
    for query, result in [(world.pairs.contacts, 0), (lambda a, b: world.pairs.near_features(a, b, 0.05), 0)]:
        items, offsets = query((knot, None), (box, poses))
        assert offsets.shape == (21,) and offsets[-1] == len(items) > 0
        for i in range(20):
            assert np.array_equal(query((knot, None), (box, poses[i])), items[offsets[i] : offsets[i + 1]])
    regions, points, offsets, complete = world.pairs.manifold((knot, None), (box, poses), margin=0.01)
    one = world.pairs.manifold((knot, None), (box, poses[7]), margin=0.01)
    assert complete.shape == (20,) and len(one[0]) == offsets[8] - offsets[7]
    assert np.array_equal(one[0]["depth_upper"], regions[offsets[7] : offsets[8]]["depth_upper"])
    few = world.pairs.manifold((knot, None), (box, poses), points_in_all=5)
    assert len(few[1]) <= 5 and not few[3].all()


def test_manifolds_of_a_frame_are_those_of_its_pairs():
    world = oncollide.World(clearance=0.01)
    box = world.models.add(oncollide.box([0.5, 0.5, 0.5]))
    with pytest.raises(oncollide.Error, match="call World::step\\(\\) first"):
        world.manifolds()
    stack = [world.bodies.add(box, pose=at(0, 0, 0.999 * k)) for k in range(3)]
    tracker, ids = oncollide.ManifoldTracker(), None
    for shift in (0, 1e-4, 0):
        world.bodies.set_pose(stack[2], at(shift, 0, 1.998))
        world.step()
        found = world.manifolds(margin=0.01)
        assert [tuple(pair) for pair in found.pairs] == [(stack[0], stack[1]), (stack[1], stack[2])]
        assert found.complete.all() and list(found.offsets) == [0, 1, 2] and len(found.points) == 8
        assert np.allclose(found.regions["normal"], [0, 0, 1]) and np.allclose(found.points["depth"], 0.001)
        assert np.isnan(found.regions["area"]).all()
        one = world.pairs.manifold(stack[1], stack[2], margin=0.01, measures=True)
        assert one[0]["depth_upper"][0] == found.regions["depth_upper"][1] and abs(one[0]["area"][0] - 1) < 1e-3
        previous, now, ended = tracker.update(world, found)
        assert len(ended) == 0 and (previous == (-1 if ids is None else np.arange(8))).all()
        assert ids is None or np.array_equal(now, ids)
        ids = now
    world.bodies.set_pose(stack[2], at(9, 0, 0))
    with pytest.raises(oncollide.Error, match="changed since the last frame"):
        world.manifolds()
    with pytest.raises(oncollide.Error, match="margin of -1"):
        world.manifolds(margin=-1)


def test_distances_are_certified_and_limited():
    poses = random_poses(40, 3, 4)
    world, (knot, _, box, *_) = world_of(*ALL)
    found = world.pairs.distance((knot, None), (box, poses), tolerance=1e-3)
    exact = world.pairs.distance((knot, None), (box, poses))
    assert (found["lower"] <= exact["upper"]).all() and (exact["lower"] <= found["upper"]).all()
    assert (found["upper"] <= found["lower"] + 1.1e-3).all()
    assert np.isinf(world.pairs.distance((knot, None), (box, at(9)), cutoff=1.0)["upper"])


def test_contiguous_doubles_are_not_copied():
    count = 100_000
    world, (ball,) = world_of(oncollide.sphere(1.0))
    poses = np.tile(at(5), (count, 1, 1))
    balls = np.full(count, int(ball), np.uint64)

    def peak(of):
        tracemalloc.start()
        world.pairs.decide((balls, of), (balls, of))
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return most

    assert peak(poses) < 1e5
    assert peak(poses.astype(np.float32)) > poses.nbytes, "float32 arrays are copied, which shows that the test detects copies"


def test_no_pairs_give_no_results():
    world, (ball, *_) = world_of(*ALL)
    assert world.pairs.decide(([], np.empty((0, 4, 4))), (ball, None)).shape == (0,)
    assert world.pairs.decide([], np.empty(0, np.uint64)).shape == (0,)
    contacts, offsets = world.pairs.contacts((ball, np.empty((0, 7))), (ball, None))
    assert contacts.shape == (0,) and offsets.tolist() == [0]


def test_the_pair_that_is_wrong_is_named():
    world, (knot, ball, *_) = world_of(*ALL)
    poses = np.tile(np.eye(4), (10, 1, 1))
    numbers = np.full(10, int(ball), np.uint64)
    numbers[6] = int(knot) + 7
    with pytest.raises(oncollide.Error, match="pair 6: b: model 7"):
        world.pairs.decide((knot, None), (numbers, poses))
    poses[7, 0, 0] = np.nan
    for query in (world.pairs.decide, world.pairs.distance, world.pairs.contacts):
        with pytest.raises(oncollide.Error, match="pair 7: b: the pose is not finite"):
            query((knot, None), (ball, poses))

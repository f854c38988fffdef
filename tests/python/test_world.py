"""World: bodies, frames, queries, contacts, distances."""

import subprocess
import sys

import numpy as np
import pytest

import oncollide
from conftest import at, matrices, random_poses
from oncollide import ContactKind, Verdict


@pytest.fixture
def cubes():
    """A World with three unit cubes: 0 and 1 overlap, 2 is 1 m from 1."""
    world = oncollide.World(exact="predicates")
    model = world.models.add(oncollide.box_mesh([0.5, 0.5, 0.5]))
    ids = world.bodies.add(model, np.stack([at(0), at(0.75), at(2.75)]))
    return world, model, ids


def test_a_step_finds_what_collides_and_what_began_and_ended(cubes):
    world, _, ids = cubes
    assert ids.dtype == np.uint64 and oncollide.slots(ids).tolist() == [0, 1, 2] and len(world.bodies) == 3
    frame = world.step()
    assert frame.frame == 0 and frame.ms > 0
    assert frame.pairs.dtype.names == ("a", "b", "verdict", "stage", "kind", "bound")
    pair = frame.pairs[0]
    assert (pair["a"], pair["b"], pair["verdict"], pair["bound"]) == (ids[0], ids[1], Verdict.COLLIDING, 0)
    assert frame.began.tolist() == [(ids[0], ids[1])] and len(frame.ended) == 0
    world.bodies.set_pose(ids[1], at(5))
    later = world.step()
    assert later.ended.tolist() == [(ids[0], ids[1])] and len(later.began) == 0
    assert frame.began.tolist() == [(ids[0], ids[1])], "an older frame stays as it was"
    assert [s["stage"] for s in later.stages] == [s.name.lower() for s in oncollide.Stage] == ["bounds", "delimitation", "broad", "refine", "exact"]
    assert later.trees["narrowed"] >= 0 and world.inspect()["totals"][0]["frames"] == 2 and pair["stage"] == oncollide.Stage.EXACT


def test_equal_input_gives_an_equal_hash_on_any_number_of_threads():
    def run(threads):
        world = oncollide.World(max_error=0.01, threads=threads)
        model = world.models.add(oncollide.torus_knot_mesh(2, 3, 1, 0.4, 0.15, 400))
        ids = world.bodies.add(model, random_poses(60, 3, 1))
        hashes = []
        for frame in range(3):
            world.bodies.set_pose(ids[::2], random_poses(30, 3, 10 + frame))
            hashes.append(world.step().hash)
        return hashes, world.hash

    assert run(1) == run(3)


def test_positions_and_quaternions_are_the_same_poses(cubes):
    world, _, ids = cubes
    poses = random_poses(3, 10, 3)
    world.bodies.set_pose(ids, poses)
    assert np.allclose([world.bodies.pose(i) for i in ids], matrices(poses), atol=1e-15)
    world.bodies.set_pose(ids[0], poses[1])
    assert np.array_equal(world.bodies.pose(ids[0]), world.bodies.pose(ids[1]))
    world.bodies.set_pose(ids, at(7))
    assert np.array_equal(world.bodies.pose(ids[2]), at(7))


def test_filters_keep_bodies_apart(cubes):
    world, model, ids = cubes
    touching = lambda: len(world.step().began)  # noqa: E731
    assert touching() == 1
    world.bodies.set_filter(ids[:2], group=5)
    assert len(world.step().ended) == 1
    world.bodies.set_filter(ids[1], group=0)
    assert touching() == 1
    world.bodies.exclude(ids[0], ids[1])
    assert len(world.step().ended) == 1
    world.bodies.include(ids[0], ids[1]), world.bodies.set_filter(ids[0], layer=2, mask=2)
    assert touching() == 0
    world.bodies.set_filter(ids[0], 1, 0xFFFFFFFF)
    assert touching() == 1
    world.bodies.set_static(ids[:2], True)
    assert len(world.step().ended) == 1 and world.bodies.is_static(ids[0]) is True
    assert len(world.space.overlaps(model, at(0.3), group=7)) == 2 and len(world.space.overlaps(model, at(0.3), mask=4)) == 0


def test_ids_of_what_was_removed_are_stale(cubes):
    world, model, ids = cubes
    world.bodies.set_user(ids[1], 2**64 - 1)
    assert world.bodies.user(ids[1]) == 2**64 - 1 and world.bodies.model(ids[1]) == model and {world.bodies.model(ids[1])} == {model}
    world.bodies.remove(ids[1])
    assert ids[1] not in world.bodies and ids[0] in world.bodies
    again = world.bodies.add(model)
    assert again == ids[1] + 2**32, "the same slot, another generation"
    with pytest.raises(oncollide.Error, match="body 1 .generation 1.: was removed; its id is stale"):
        world.bodies.set_pose(ids[1], at(0))
    world.bodies.set_pose(np.uint64(again), at(3))
    with pytest.raises(oncollide.Error, match="bodies use it"):
        world.models.remove(model)
    world.bodies.remove([ids[0], ids[2], again])
    world.models.remove(model)
    assert len(world.bodies) == len(world.models) == 0 and model not in world.models
    with pytest.raises(oncollide.Error, match="was removed; its id is stale"):
        world.bodies.add(model)


def test_a_model_can_be_replaced(cubes):
    world, model, ids = cubes
    world.models.replace(model, oncollide.sphere(2.0))
    assert len(world.step().began) == 3
    ball = world.models.add(oncollide.sphere(0.01))
    world.bodies.set_model(ids[1], ball), world.bodies.set_model(ids[2], ball)
    assert world.step().ended.tolist() == [(ids[0], ids[2]), (ids[1], ids[2])]


def test_queries_hit_what_is_there_and_add_nothing(cubes):
    world, model, ids = cubes
    hits = world.space.overlaps(model, at(0.3))
    assert hits.dtype.names == ("body", "verdict", "kind", "bound") and hits["body"].tolist() == ids[:2].tolist()
    assert set(hits["verdict"]) == {Verdict.COLLIDING}
    many, offsets = world.space.overlaps(model, np.stack([at(0.3), at(50), at(2.8)]))
    assert offsets.tolist() == [0, 2, 2, 3] and many["body"].tolist() == ids.tolist()
    assert world.space.overlaps_segment([-9, 0, 0], [9, 0, 0])["body"].tolist() == ids.tolist()
    many, offsets = world.space.overlaps_segment([[-9, 0, 0], [-9, 5, 0]], [[9, 0, 0], [9, 5, 0]])
    assert offsets.tolist() == [0, 3, 3] and many["body"].tolist() == ids.tolist()
    assert world.space.overlaps_box([2, -1, -1], [4, 1, 1])["body"].tolist() == [ids[2]]
    many, offsets = world.space.overlaps_box([[2, -1, -1], [7, 7, 7]], [[4, 1, 1], [8, 8, 8]])
    assert offsets.tolist() == [0, 1, 1] and many["body"].tolist() == [ids[2]]
    assert len(world.bodies) == 3


def test_casts_find_the_first_point_of_segments(cubes):
    world, model, ids = cubes
    hits = world.space.cast([[-9, 0, 0], [-9, 5, 0], [9, 0.125, 0.25]], [[9, 0, 0], [9, 5, 0], [-9, 0.125, 0.25]])
    assert hits["body"].tolist() == [ids[0], 0, ids[2]]
    assert hits["verdict"].tolist() == [Verdict.COLLIDING, Verdict.SEPARATE, Verdict.COLLIDING]
    assert hits["fraction_lower"][0] <= 8.5 / 18 <= hits["fraction_upper"][0]
    assert np.allclose(hits["point"][[0, 2]], [[-0.5, 0, 0], [3.25, 0.125, 0.25]])
    assert hits["normal"][[0, 2]].tolist() == [[-1, 0, 0], [1, 0, 0]]
    assert hits["triangle"].max() < 12 and not hits["cell"].any()
    assert world.space.cast([-9, 0, 0], [9, 0, 0]) == hits[0]
    several, offsets = world.space.cast_all([-9, 0, 0], [[9, 0, 0], [9, 5, 0]])
    assert offsets.tolist() == [0, 3, 3] and several["body"].tolist() == ids.tolist()
    assert world.space.cast_all([-9, 0, 0], [9, 0, 0])["body"].tolist() == ids.tolist()
    assert world.space.cast_all([9, 0, 0], [-9, 0, 0])["body"].tolist() == ids[::-1].tolist()


def test_contacts_are_structured_arrays_of_what_meets(cubes):
    world, model, ids = cubes
    contacts = world.pairs.contacts(ids[0], ids[1])
    assert len(contacts) > 8 and contacts["ends"].shape == (len(contacts), 2, 3)
    assert np.abs(np.linalg.norm(contacts["normal_a"], axis=1) - 1).max() < 1e-12
    assert contacts["ends"][..., 0].min() >= 0.25 - 1e-12 and contacts["ends"][..., 0].max() <= 0.5 + 1e-12
    assert set(contacts["kind"]) <= {ContactKind.TOUCHING, ContactKind.CROSSING}
    assert contacts["triangle_a"].max() < 12 and not contacts["cell_a"].any()
    lists, offsets = world.pairs.contacts(ids[[0, 0, 1]], ids[[1, 2, 0]])
    assert offsets.tolist() == [0, len(contacts), len(contacts), 2 * len(contacts)]
    assert np.array_equal(lists[: offsets[1]], contacts)
    cell = world.bodies.add(world.models.add(oncollide.occupancy_map([[3, 0, 0]], 1.0)))
    assert world.pairs.contacts(cell, ids[2])[0]["cell_a"].tolist() == [3, 0, 0, 1]


def test_manifolds_are_regions_and_points():
    world = oncollide.World()
    ground = world.bodies.add(world.models.add(oncollide.box([5, 5, 1])), at(0, 0, -1))
    box = world.models.add(oncollide.box([0.5, 0.25, 0.5]))
    ids = world.bodies.add(box, np.stack([at(0, 0, 0.499), at(2, 0, 0.51)]))
    regions, points, complete = world.pairs.manifold(ids[0], ground, measures=True)
    assert complete and len(regions) == 1 and len(points) == regions[0]["count"] == 4
    assert np.allclose(regions[0]["normal"], [0, 0, -1]) and abs(regions[0]["area"] - 0.5) < 1e-9
    assert regions[0]["depth_lower"] <= 0.001 <= regions[0]["depth_upper"] and not regions[0]["open"]
    assert np.allclose(points["depth"], 0.001) and len(set(points["feature_a"].tolist())) == 4
    regions, points, offsets, complete = world.pairs.manifold(ids, np.full(2, ground), margin=0.02)
    assert offsets.tolist() == [0, 1, 2] and complete.tolist() == [True, True]
    assert regions["kind"].tolist() == [0, 3] and np.allclose(points["depth"][4:], -0.01)
    features, offsets = world.pairs.near_features(ids[1:], np.array([ground]), 0.02)
    assert offsets.tolist() == [0, len(features)] and len(features) > 0
    assert (features["lower"] <= features["upper"]).all() and (features["lower"] <= 0.02).all()
    with pytest.raises(oncollide.Error, match="margin of -1; must be from 0"):
        world.pairs.manifold(ids[0], ground, margin=-1.0)


def test_distances_are_certified_intervals(cubes):
    world, model, ids = cubes
    found = world.pairs.distance(ids[1], ids[2])
    assert found["lower"] <= 1 <= found["upper"] and found["upper"] - found["lower"] < 1e-9
    assert np.linalg.norm(found["point_a"] - found["point_b"]) == pytest.approx(1)
    assert world.pairs.distance(ids[0], ids[1])["upper"] == 0
    far = world.pairs.distance(ids[0], ids[2], cutoff=0.5)
    assert far["lower"] > 0.5 and far["upper"] == np.inf
    assert world.pairs.distance(ids[0], ids[2], tolerance=0.2)["upper"] - world.pairs.distance(ids[0], ids[2], tolerance=0.2)["lower"] <= 0.2 + 1e-9


def test_pairs_are_decided_and_measured_as_bodies_and_as_models_at_poses(cubes):
    world, model, ids = cubes
    assert world.pairs.decide(ids[0], ids[1])["verdict"] == Verdict.COLLIDING
    assert world.pairs.decide((model, at(0)), ids[1]) == world.pairs.decide(ids[0], (model, at(0.75)))
    assert world.pairs.decide(ids[[0, 0]], ids[[1, 2]])["verdict"].tolist() == [Verdict.COLLIDING, Verdict.SEPARATE]
    assert world.pairs.distance((model, at(0)), (model, at(2)))["lower"] == pytest.approx(1)
    batch = world.pairs.distance(ids[[1, 0]], ids[[2, 1]])
    assert batch["lower"].tolist() == [world.pairs.distance(ids[1], ids[2])["lower"], 0]
    near = world.space.distances(model, at(4), cutoff=1)
    assert near["body"].tolist() == [ids[2]] and near["upper"][0] == pytest.approx(0.25)
    many, offsets = world.space.distances(model, [at(90), at(4)], 1)
    assert offsets.tolist() == [0, 0, 1] and many[0] == near[0]
    deep = world.pairs.penetration(ids[0], ids[1])
    assert deep["depth"] == world.pairs.penetration(ids[:1], ids[1:2])["depth"][0] >= 0
    assert deep["thickness"] == pytest.approx(0.25)
    assert deep["supported"] and deep["depth"] <= deep["depth_upper"]
    with pytest.raises(ValueError, match="tuple"):
        world.pairs.decide((model,), ids[1])


def test_what_is_set_can_be_read_and_a_world_describes_itself(cubes):
    world, model, ids = cubes
    world.bodies.set_filter(ids[0], layer=2, mask=6), world.bodies.set_filter(ids[0], group=9)
    assert world.bodies.filter(ids[0]) == {"layer": 2, "mask": 6, "group": 9}
    world.bodies.set_filter(ids[2], **world.bodies.filter(ids[0]))
    assert world.bodies.filter(ids[2]) == world.bodies.filter(ids[0])
    assert world.space.overlaps(model, at(2.75), **world.bodies.filter(ids[0])).size == 0, "bodies of one group"
    world.bodies.exclude(ids[0], ids[1])
    assert world.bodies.excluded(ids[1], ids[0]) and not world.bodies.excluded(ids[0], ids[2])
    world.bodies.sleep(ids)
    world.bodies.set_pose(ids[1], at(0.8))  # wakes it
    world.bodies.wake(ids[2:])
    assert world.bodies.is_asleep(ids).tolist() == [True, False, False] and world.bodies.is_asleep(ids[0]) is True
    world.bodies.set_user(ids, [3, 4, 2**64 - 1]), world.bodies.set_static(ids[1:], True)
    assert world.bodies.user(ids).tolist() == [3, 4, 2**64 - 1] and world.bodies.is_static(ids).tolist() == [False, True, True]
    world.bodies.set_user(ids[:2], 7), world.bodies.reserve(100)
    assert world.bodies.user(ids[::-1]).tolist() == [2**64 - 1, 7, 7]
    assert np.array_equal(world.bodies.pose(ids), [at(0), at(0.8), at(2.75)])
    assert world.bodies.at(1) == ids[1] and world.bodies.at(7) is None
    info = world.inspect()
    assert (info["bodies"], info["models"], info["frames"]) == (3, 1, 0) and info["bytes"] > 0


def test_ids_of_another_world_are_refused(cubes):
    world, _, ids = cubes
    other = oncollide.World()
    other.bodies.add(other.models.add(oncollide.sphere(1)))
    with pytest.raises(oncollide.Error, match="the id is of another World"):
        other.bodies.pose(ids[0])
    with pytest.raises(oncollide.Error, match="the id is null"):
        other.bodies.pose(0)


def test_settings_reach_the_world():
    inner = oncollide.box_mesh([0.1, 0.1, 0.1])
    for settings, expected in [({"mode": "solid"}, Verdict.COLLIDING), ({"mode": "surface"}, Verdict.SEPARATE)]:
        world = oncollide.World(exact="predicates", **settings)
        world.bodies.add(world.models.add(oncollide.box_mesh([1, 1, 1])))
        world.bodies.add(world.models.add(inner))
        assert world.step().pairs["verdict"].tolist() == [expected]
    kinds = oncollide.World(exact="predicates", contact_kinds=True)
    model = kinds.models.add(oncollide.box_mesh([0.5, 0.5, 0.5]))
    kinds.bodies.add(model, [at(0), at(1)])
    assert kinds.step().pairs["kind"].tolist() == [ContactKind.TOUCHING]
    near = oncollide.World(clearance=0.5, max_error=0.01)
    ids = near.bodies.add(near.models.add(oncollide.sphere(1.0)), [at(0), at(2.4), at(-2.6)])
    assert near.step().began.tolist() == [(ids[0], ids[1])]
    assert near.pairs.max_error(ids[0], ids[1]) == 0.01
    assert oncollide.World(skip=["exact"], depth=None, broad_phase="octree", threads=0).inspect()["backend"].startswith("cpu")


def test_what_is_set_can_be_read_of_a_world():
    world = oncollide.World(max_error=0.01, mode="solid", skip=["exact"], threads=2, node_budget=1000)
    read = world.settings
    assert (read["max_error"], read["mode"], read["skip"], read["threads"], read["gpu"]) == (0.01, "solid", ["exact"], 2, None)
    assert oncollide.World(**read).settings == read
    assert oncollide.World().settings["exact"] == "predicates", "what 'auto' stands for"
    world.set_sweep_options(gap_tolerance=0.01, stop="press")
    assert world.sweep_options == {"time_tolerance": 1e-4, "gap_tolerance": 0.01, "most_steps": 10000, "stop": "press"}
    world.set_sweep_options(**world.sweep_options)


def test_models_are_geometries_of_a_world(cubes):
    world, model, ids = cubes
    assert world.models.closed(model) and world.models.at(0) == model and world.models.at(1) is None
    assert np.allclose(world.models.bounds(model, at(3)), [[2.5, -0.5, -0.5], [3.5, 0.5, 0.5]])
    assert world.models.bounds(model, [at(3), at(4)]).shape == (2, 2, 3) and world.models.bounds(model).shape == (2, 3)
    ball = oncollide.sphere(2.0)
    world.models.replace(model, ball)
    assert world.models.geometry(model) is ball
    assert world.models.add(ball) in world.models and len(world.models) == 2


def test_the_numbers_of_verdicts_and_kinds_are_the_librarys():
    names = lambda e: [v.name.lower() for v in e]  # noqa: E731
    assert names(Verdict) == ["separate", "within", "colliding", "undecided"]
    assert names(ContactKind) == ["unknown", "near", "touching", "crossing", "enclosed"]
    skipped = oncollide.World(exact="off", skip=["refine"])
    skipped.bodies.add(skipped.models.add(oncollide.sphere(1.0)), [at(0), at(1)])
    assert skipped.step().pairs["verdict"].tolist() == [Verdict.UNDECIDED]


def test_two_geometries_at_two_poses_need_no_world(cubes):
    world, _, ids = cubes
    cube = oncollide.box_mesh([0.5, 0.5, 0.5])
    assert oncollide.collide(cube, at(0), cube, at(0.75)) == world.pairs.decide(ids[0], ids[1])
    assert oncollide.distance(cube, at(0.75), cube, at(2.75)) == world.pairs.distance(ids[1], ids[2])
    assert np.isinf(oncollide.distance(cube, at(0.75), cube, at(2.75), cutoff=0.5)["upper"])
    assert np.array_equal(oncollide.contacts(cube, at(0), cube, at(0.75)), world.pairs.contacts(ids[0], ids[1]))
    assert oncollide.penetration(cube, at(0), cube, at(0.75)) == world.pairs.penetration(ids[0], ids[1])
    ball = oncollide.sphere(0.5)
    assert oncollide.collide(ball, None, cube, at(0.99))["verdict"] == Verdict.COLLIDING
    assert oncollide.collide(ball, None, cube, at(1.01))["verdict"] == Verdict.SEPARATE


def test_the_triangles_of_a_mesh_that_meet_are_rows_of_an_array():
    vertices = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, -1], [1, 1, 1], [2, 1, 1], [4, 4, 0]]
    crossed = oncollide.mesh(vertices, [[0, 1, 2], [3, 4, 5], [1, 6, 2], [0, 1, 2]])
    pairs = oncollide.self_contacts(crossed)
    assert pairs.dtype == np.uint32
    assert pairs.tolist() == [[0, 1], [0, 3], [1, 3]]
    assert oncollide.self_contacts(crossed, most=1).shape == (1, 2)
    assert oncollide.self_contacts(oncollide.box_mesh([1, 1, 1])).shape == (0, 2)
    assert oncollide.self_contacts(oncollide.sphere(1.0)).shape == (0, 2)
    world = oncollide.World(threads=2)
    assert np.array_equal(world.models.self_contacts(world.models.add(crossed)), pairs)
    with pytest.raises(TypeError, match="most"):
        oncollide.self_contacts(crossed, most="one")


def test_near_features_of_a_mesh_leave_out_its_neighbours():
    # Two triangles, 0.1 apart, and a third one that joins them.
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.2, 0.1], [1.2, 0.2, 0.1], [0.2, 1.2, 0.1]]
    triangles = [[0, 1, 2], [3, 4, 5], [1, 4, 2]]
    world = oncollide.World(threads=1)
    model = world.models.add(oncollide.mesh(vertices, triangles))
    near = world.models.near_features(model, 0.11)
    assert near.dtype.names == ("a", "b", "lower", "upper", "point_a", "point_b")
    kinds = set(zip((near["a"] >> np.uint64(62)).tolist(), (near["b"] >> np.uint64(62)).tolist()))
    assert (1, 3) in kinds and (2, 2) in kinds  # a vertex over a face, edges that cross
    assert np.all(near["lower"] <= 0.11) and np.all(near["upper"] > 0.08)
    assert len(world.models.near_features(model, 0.11, rings=9)) == 0
    rest = np.array(vertices) * [1, 1, 100]
    apart = world.models.near_features(model, 0.11, rest=rest, rest_distance=5.0)
    assert len(apart) == len(near) - 1  # an edge of the third triangle stays near an edge beside it
    assert np.allclose(apart["upper"], 0.1)
    assert len(world.models.near_features(model, 0.11, rest=rest, rest_distance=20.0)) == 0
    with pytest.raises(oncollide.Error, match="rings"):
        world.models.near_features(model, 0.11, rings=0)
    with pytest.raises(oncollide.Error, match="rest"):
        world.models.near_features(model, 0.11, rest=rest[1:], rest_distance=1.0)
    with pytest.raises(oncollide.Error, match="mesh"):
        world.models.near_features(world.models.add(oncollide.sphere(1.0)), 0.1)


def test_an_import_without_numpy_says_so_in_one_line():
    program = "import sys; sys.modules['numpy'] = None\ntry: import oncollide\nexcept ImportError as error: print(error)"
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert ran.stdout == "oncollide needs NumPy: apt install python3-numpy, or pip install numpy\n", ran.stderr


def test_vertices_move_from_an_array_that_stays_where_it_is():
    world = oncollide.World()
    grid = np.array([[x, y, 0.0] for y in range(3) for x in range(3)])
    faces = [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [3, 4, 7], [3, 7, 6], [4, 5, 8], [4, 8, 7]]
    sheet = world.models.add(oncollide.mesh(grid, faces))
    world.bodies.add(sheet)
    world.bodies.add(world.models.add(oncollide.sphere(0.2)), at(1, 1, 1))
    assert Verdict.COLLIDING not in world.step().pairs["verdict"]
    grid[4, 2] = 0.9
    world.models.set_vertices(sheet, grid)
    assert Verdict.COLLIDING in world.step().pairs["verdict"]
    assert np.array_equal(world.models.geometry(sheet).vertices, grid)
    world.models.set_vertices(sheet, [[1, 1, 0]], first=4)
    assert Verdict.COLLIDING not in world.step().pairs["verdict"]
    with pytest.raises(ValueError, match=r"models.set_vertices: positions: expected shape \(N, 3\)"):
        world.models.set_vertices(sheet, [1, 2, 3])
    with pytest.raises(oncollide.Error, match="8 positions are given for 9 vertices"):
        world.models.set_vertices(sheet, grid[:8])
    with pytest.raises(oncollide.Error, match="vertex 7 is not finite"):
        world.models.set_vertices(sheet, [[np.inf, 0, 0]], first=7)
    with pytest.raises(TypeError, match="first"):
        world.models.set_vertices(sheet, grid, first="one")


def test_heights_change_from_an_array_that_stays_where_it_is():
    world = oncollide.World()
    ground = oncollide.terrain(np.zeros((20, 30)), no_data=-1000)
    terrain = world.models.add(ground)
    world.bodies.add(terrain)
    world.bodies.add(world.models.add(oncollide.sphere(0.5)), at(10, 5, 2))
    assert Verdict.COLLIDING not in world.step().pairs["verdict"]
    heap = np.full((3, 4), 1.75)
    world.models.set_heights(terrain, heap, 8, 4)  # column, row
    assert Verdict.COLLIDING in world.step().pairs["verdict"]
    assert world.models.geometry(terrain).bounds[1][2] == 1.75 and ground.bounds[1][2] == 0
    world.models.set_heights(terrain, np.full((3, 4), -1000.0), column=8, row=4)  # holes
    assert Verdict.COLLIDING not in world.step().pairs["verdict"]
    world.models.set_heights(terrain, [[np.nan, 2], [1, 0]])
    with pytest.raises(ValueError, match=r"models.set_heights: heights: expected shape \(rows, columns\)"):
        world.models.set_heights(terrain, [1, 2, 3])
    with pytest.raises(oncollide.Error, match="4 columns and 3 rows of heights from column 27, row 0 are given, but the"):
        world.models.set_heights(terrain, heap, 27)
    with pytest.raises(oncollide.Error, match="the height in column 1, row 2 is inf"):
        world.models.set_heights(terrain, [[np.inf]], 1, 2)
    with pytest.raises(TypeError, match="row"):
        world.models.set_heights(terrain, heap, 0, "one")
    with pytest.raises(oncollide.Error, match="is not a terrain"):
        world.models.set_heights(world.models.add(oncollide.sphere(1)), heap)

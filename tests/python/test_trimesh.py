"""CollisionManager: the names and return types of trimesh."""

import itertools
import math

import numpy as np
import pytest

import oncollide
from conftest import Cube, at, matrices, random_poses
from oncollide.trimesh import CollisionManager, scene_to_collision


@pytest.fixture
def manager():
    """Unit cubes a and b overlap; c is 1 m from b."""
    made = CollisionManager()
    for name, x in [("b", 0.5), ("a", 0.0), ("c", 2.5)]:
        made.add_object(name, Cube(), at(x))
    return made


def test_single_returns_what_was_requested(manager):
    assert manager.in_collision_single(Cube(), at(9)) is False
    assert manager.in_collision_single(Cube(), at(0.9)) is True
    assert manager.in_collision_single(Cube()) is True, "the identity by default"
    assert manager.in_collision_single(Cube(), at(0.9), return_names=True) == (True, {"a", "b"})
    assert manager.in_collision_single(Cube(), at(9), return_names=True, return_data=True) == (False, set(), [])
    hit, names, data = manager.in_collision_single(Cube(), at(2.5, 0.5), return_names=True, return_data=True)
    assert hit and names == {"c"}
    for contact in data:
        assert contact.names == {"c", "__external"} and contact.bound == 0 and math.isnan(contact.depth)
        assert contact.point.shape == contact.normal.shape == (3,)
        assert 0 <= contact.index("c") < 12 and 0 <= contact.index("__external") < 12
    assert manager.in_collision_single(Cube(), at(2.5, 0.5), return_data=True)[0] is True


def test_internal_returns_sorted_pairs(manager):
    assert manager.in_collision_internal() is True
    hit, names, data = manager.in_collision_internal(return_names=True, return_data=True)
    assert hit and names == {("a", "b")} and data and all(d.names == {"a", "b"} for d in data)
    manager.set_transform("a", at(-9))
    assert manager.in_collision_internal(return_names=True) == (False, set())


def test_other_returns_pairs_in_order(manager):
    other = CollisionManager()
    assert manager.in_collision_other(other) is False
    other.add_object("x", Cube(0.1), at(2.7, 0.95, 0.5))
    other.add_object("y", Cube(), at(30))
    hit, names, data = manager.in_collision_other(other, return_names=True, return_data=True)
    assert hit and names == {("c", "x")} and data and all(d.names == {"c", "x"} for d in data)
    assert manager.in_collision_other(other) is True
    assert other.in_collision_other(manager, return_names=True) == (True, {("x", "c")})
    assert len(manager._world.bodies) == 3, "nothing stays behind"


def test_distances_are_of_the_nearest_and_have_bounds(manager):
    assert manager.min_distance_internal() == 0
    manager.set_transform("a", at(-4))
    distance, names, data = manager.min_distance_internal(return_names=True, return_data=True)
    assert distance == pytest.approx(1) and names == ("b", "c") and data.names == {"b", "c"}
    assert data.bound[0] <= 1 <= data.bound[1] and data.distance == distance
    assert np.linalg.norm(data.point("b") - data.point("c")) == pytest.approx(1) and 0 <= data.index("c") < 12
    assert manager.min_distance_single(Cube(), at(-4, 3), return_name=True) == (pytest.approx(2), "a")
    distance, data = manager.min_distance_single(Cube(), at(-4, 3), return_data=True)
    assert data.names == {"a", "__external"} and data.point("a")[1] == pytest.approx(1)
    other = CollisionManager()
    assert manager.min_distance_other(other, return_names=True) == (math.inf, None)
    other.add_object("far", Cube(), at(50)), other.add_object("near", Cube(), at(4.5))
    assert manager.min_distance_other(other, return_names=True) == (pytest.approx(1), ("c", "near"))
    assert CollisionManager().min_distance_internal(return_names=True, return_data=True) == (math.inf, None, None)


def test_objects_come_go_and_are_replaced(manager):
    manager.add_object("c", Cube(), at(0.2))
    assert manager.in_collision_internal(return_names=True)[1] == {("a", "b"), ("a", "c"), ("b", "c")}
    manager.remove_object("b")
    assert manager.in_collision_internal(return_names=True)[1] == {("a", "c")}
    for call in (lambda: manager.remove_object("b"), lambda: manager.set_transform("b", at(0))):
        with pytest.raises(ValueError, match="b not in collision manager!"):
            call()
    with pytest.raises(TypeError, match="CollisionManager: mesh: expected a Geometry, or an object with vertices and faces; got int"):
        manager.add_object("d", 3)
    with pytest.raises(oncollide.Error, match="not rigid"):
        manager.add_object("a", Cube(), np.diag([2.0, 2, 2, 1]))
    assert manager.in_collision_internal(return_names=True)[1] == {("a", "c")}, "a refused object changes nothing"


def test_equal_meshes_share_a_model_and_changed_ones_do_not():
    manager = CollisionManager()
    cube = Cube()
    for i in range(5):
        manager.add_object(i, Cube() if i % 2 else cube, at(3 * i))
    assert len(manager._models) == 1
    cube.vertices = cube.vertices * 2
    assert manager.in_collision_single(cube, at(1.5), return_names=True) == (True, {1})
    for side in np.linspace(0.1, 0.9, 40):
        manager.in_collision_single(Cube(side))
    assert len(manager._models) <= 1 + CollisionManager._KEPT
    geometry = oncollide.sphere(0.5)
    manager.add_object("ball", geometry, at(0, 9)), manager.add_object("ball 2", geometry, at(0, 9.9))
    assert manager.in_collision_internal(return_names=True)[1] == {("ball", "ball 2")}
    for name in list(manager._bodies):
        manager.remove_object(name)
    assert len(manager._models) <= CollisionManager._KEPT and len(manager._world.bodies) == 0


def test_what_lies_inside_a_closed_mesh_collides():
    for inner, outer in [(Cube(0.1), Cube()), (Cube(), Cube(3))]:
        for settings, expected in [({}, True), ({"mode": "surface"}, False)]:
            manager = CollisionManager(**settings)
            manager.add_object("outer", outer, at(-0.5, -0.5, -0.5))
            hit, names, data = manager.in_collision_single(inner, at(0.01), return_names=True, return_data=True)
            assert (hit, names, data) == (expected, {"outer"} if expected else set(), [])
            assert (manager.min_distance_single(inner, at(0.01)) == 0) == expected
    open_mesh = Cube()
    open_mesh.faces = open_mesh.faces[:-1]
    manager = CollisionManager()
    manager.add_object("open", open_mesh)
    assert not manager.in_collision_single(Cube(0.1), at(0.5, 0.5, 0.5))


def test_poses_stay_in_double():
    manager = CollisionManager()
    manager.add_object("a", Cube(), at(1e6))
    touching, apart = at(1e6 - 1), at(1e6 - 1 - 1e-9)  # in float32 both equal 1e6 - 1
    assert manager.in_collision_single(Cube(), touching) and not manager.in_collision_single(Cube(), apart)
    assert manager.min_distance_single(Cube(), at(1e6 - 1.001)) == pytest.approx(0.001, rel=1e-6)


def test_an_error_may_be_allowed():
    manager = CollisionManager(exact="off", max_error=0.05)
    ball = oncollide.sphere_mesh(1.0, 2000)
    manager.add_object("a", ball)
    diagonal = np.ones(3) / np.sqrt(3)
    assert not manager.in_collision_single(ball, at(*(2.06 * diagonal)))
    hit, data = manager.in_collision_single(ball, at(0.5), return_data=True)
    assert hit and all(0 < d.bound <= 0.05 for d in data)


def test_answers_are_those_of_every_pair_alone():
    knot = oncollide.torus_knot_mesh(2, 3, 1, 0.4, 0.15, 300)
    poses = matrices(random_poses(14, 2.2, 8))
    manager = CollisionManager()
    for i, pose in enumerate(poses):
        manager.add_object(i, knot, pose)
    expected = {
        (i, j)
        for i, j in itertools.combinations(range(14), 2)
        if oncollide.collide(knot, poses[i], knot, poses[j])["verdict"] == oncollide.Verdict.COLLIDING
    }
    assert 5 < len(expected) < 60
    assert manager.in_collision_internal(return_names=True) == (True, expected)
    far = matrices(random_poses(6, 30, 9))
    other = CollisionManager()
    for i, pose in enumerate(far):
        other.add_object(i, knot, pose)
    nearest = min(oncollide.distance(knot, a, knot, b)["upper"] for a in poses for b in far)
    assert manager.min_distance_other(other) == pytest.approx(nearest, abs=1e-9)


def test_a_scene_becomes_a_manager():
    class Graph(dict):
        nodes_geometry = ["left", "right"]

    class Scene:
        graph = Graph(left=(at(0), "cube"), right=(at(0.5), "cube"))
        geometry = {"cube": Cube()}

    manager, bodies = scene_to_collision(Scene)
    assert set(bodies) == {"left", "right"} and manager.in_collision_internal(return_names=True)[1] == {("left", "right")}

"""Bad input: one exception each, which names the call, the argument and the valid values; the object is unchanged."""

import re

import numpy as np
import pytest

import oncollide
from conftest import Cube, at
from oncollide import Error, World

CUBE = Cube()
MESH = oncollide.box_mesh([1, 1, 1])


def world():
    made = World()
    made.bodies.add(made.models.add(MESH), [at(0), at(5)])
    return made


def pair():
    return world().pairs


def model():
    return world().models.at(0)


class Broken:
    def __array__(self, dtype=None):
        raise RuntimeError("no array")


NAN = np.full((4, 4), np.nan)
MIRROR = np.diag([-1.0, 1, 1, 1])
LEAN = np.eye(4) + 0.01 * np.eye(4, k=1) * [[1], [0], [0], [0]]

CASES = [
    # geometries
    (lambda: oncollide.mesh(CUBE.vertices[:, :2], CUBE.faces), ValueError, "mesh: vertices: expected shape (N, 3), got (8, 2)"),
    (lambda: oncollide.mesh(CUBE.vertices.ravel(), CUBE.faces), ValueError, "mesh: vertices: expected shape (N, 3), got (24,)"),
    (lambda: oncollide.mesh(CUBE.vertices, CUBE.faces.astype(float)), TypeError, "mesh: faces: expected an array of whole numbers, not of dtype float64"),
    (lambda: oncollide.mesh(CUBE.vertices, CUBE.faces > 3), TypeError, "mesh: faces: expected an array of whole numbers, not of dtype bool"),
    (lambda: oncollide.mesh(CUBE.vertices, CUBE.faces - 1), ValueError, "mesh: faces: face 0 uses vertex -1; indices begin at 0"),
    (lambda: oncollide.mesh(CUBE.vertices, [[0, 1, 2**40]]), ValueError, "face 0 uses vertex 1099511627776"),
    (lambda: oncollide.mesh(CUBE.vertices, np.array([[0, 1, 2**64 - 1]], np.uint64)), ValueError, "mesh: faces: face 0 uses vertex"),
    (lambda: oncollide.mesh(CUBE.vertices, CUBE.faces + 1), Error, "uses vertex 8, but the mesh has 8 vertices"),
    (lambda: oncollide.mesh(CUBE.vertices * np.nan, CUBE.faces), Error, "mesh: vertex 0"),
    (lambda: oncollide.mesh(CUBE.vertices * 1e300, CUBE.faces), Error, "mesh: vertex"),
    (lambda: oncollide.mesh(CUBE.vertices, np.empty((0, 3), int)), Error, "mesh:"),
    (lambda: oncollide.mesh([], []), ValueError, "mesh: vertices: expected shape (N, 3), got (0,)"),
    (lambda: oncollide.mesh(CUBE.vertices * 1j, CUBE.faces), TypeError, "mesh: vertices: expected an array of numbers, not of dtype complex128"),
    (lambda: oncollide.mesh([["a"] * 3], CUBE.faces), TypeError, "mesh: vertices: expected an array of numbers, not of dtype <U1"),
    (lambda: oncollide.mesh([[0, 0], [0]], CUBE.faces), TypeError, "mesh: vertices: expected an array of numbers"),
    (lambda: oncollide.mesh(Broken(), CUBE.faces), TypeError, "mesh: vertices: expected an array of numbers; got Broken"),
    (lambda: oncollide.mesh(CUBE.vertices, CUBE.faces, name=3), TypeError, "mesh: name: expected a str; got int"),
    (lambda: oncollide.mesh(CUBE.vertices, CUBE.faces, "\udc80"), ValueError, "mesh: name: holds a lone surrogate"),
    (lambda: World(**{"\udc80": 1}), ValueError, "World: the name of a setting: holds a lone surrogate"),
    (lambda: (w := World(), w.models.replace_cells(w.models.add(oncollide.occupancy_map([[0, 0, 0]], 1)), [0] * 3, [1] * 3, MESH)), ValueError, "models.replace_cells: by: expected a map"),
    (lambda: oncollide.sphere("1"), TypeError, "sphere: radius: expected a number; got str"),
    (lambda: oncollide.sphere(True), TypeError, "sphere: radius: expected a number; got bool"),
    (lambda: oncollide.sphere(np.nan), Error, "sphere: the radius is nan"),
    (lambda: oncollide.box([1, 2]), ValueError, "box: half_extents: expected shape (3,), got (2,)"),
    (lambda: oncollide.box([1, 2, 0]), Error, "box:"),
    (lambda: oncollide.capsule(1, -1), Error, "capsule:"),
    (lambda: oncollide.convex_hull(np.zeros((5, 3)), "flat"), Error, "flat:"),
    (lambda: oncollide.terrain(np.zeros(4)), ValueError, "terrain: heights: expected shape (rows, columns), got (4,)"),
    (lambda: oncollide.terrain(np.zeros((1, 4))), Error, "terrain:"),
    (lambda: oncollide.terrain(np.full((3, 3), np.nan)), Error, "terrain:"),
    (lambda: oncollide.terrain(np.zeros((3, 3)), spacing=-1), Error, "terrain:"),
    (lambda: oncollide.terrain(np.zeros((3, 3)), falling=np.zeros((3, 3), bool)), ValueError, "terrain: falling: expected shape (rows - 1, columns - 1)"),
    (lambda: oncollide.terrain(np.zeros((3, 3)), falling=np.zeros((2, 2))), TypeError, "terrain: falling: expected an array of bool"),
    (lambda: oncollide.occupancy_map([[0, 0, 32768]], 1), ValueError, "cell 0: index 32768 is out of range; must be from -32768 to 32767"),
    (lambda: oncollide.occupancy_map(np.ones((2, 2, 2), bool), 1), TypeError, "occupancy_map: cells: expected an array of whole numbers"),
    (lambda: oncollide.occupancy_map(np.empty((0, 3), int), 1), Error, "occupancy_map:"),
    (lambda: oncollide.occupancy_map([[0, 0, 0]], 0), Error, "occupancy_map:"),
    (lambda: oncollide.load_mesh(3.5), TypeError, "load_mesh: path: expected a path"),
    (lambda: oncollide.load_mesh("a\0b"), ValueError, "load_mesh: path: a path cannot hold a null character"),
    (lambda: oncollide.load_mesh(".", scale=0), Error, ""),
    (lambda: oncollide.sphere_mesh(1, -3), ValueError, "sphere_mesh: triangles: -3 is out of range"),
    (lambda: oncollide.sphere_mesh(1, 2), Error, ""),
    # settings
    (lambda: World(0.01), TypeError, ""),
    (lambda: World(max_eror=1), TypeError, "World: no setting 'max_eror'; valid: max_error, depth"),
    (lambda: World(max_error=0), Error, "max-error = 0: must be a length in metres, above 0"),
    (lambda: World(max_error=1, depth=3), Error, "give one of them"),
    (lambda: World(exact="yes"), ValueError, "World: exact: no 'yes'; valid: auto, on, off, predicates, fcl"),
    (lambda: World(threads=-1), ValueError, "World: threads: -1 is out of range"),
    (lambda: World(threads=1.0), TypeError, "World: threads: expected a whole number; got float"),
    (lambda: World(coherence=1), TypeError, "World: coherence: expected True or False; got int"),
    (lambda: World(skip="refine"), TypeError, "World: skip: expected a list of names of stages; got str"),
    (lambda: World(skip=["octs"]), ValueError, "World: skip: no 'octs'; valid: bounds"),
    # bodies and poses
    (lambda: world().models.add(CUBE), TypeError, "models.add: geometry: expected a Geometry, as oncollide.mesh()"),
    (lambda: world().bodies.add(MESH), TypeError, "bodies.add: model: expected a Model, as models.add() returns it; got Geometry"),
    (lambda: world().bodies.add(world().models.add(MESH)), Error, "the id is of another World"),
    (lambda: (w := world()).bodies.set_pose(w.bodies.at(0), np.eye(3)), ValueError, "bodies.set_pose: pose: expected shape (4, 4), or (7,) with x y z qx qy qz qw, got (3, 3)"),
    (lambda: (w := world()).bodies.set_pose(w.bodies.at(0), np.eye(4)[None]), ValueError, "bodies.set_pose: pose: expected shape (4, 4)"),
    (lambda: (w := world()).bodies.set_pose(w.bodies.at(0), NAN), Error, "body 0: the pose is not finite"),
    (lambda: (w := world()).bodies.set_pose(w.bodies.at(0), MIRROR), Error, "body 0: the pose is not rigid: it mirrors"),
    (lambda: (w := world()).bodies.set_pose(w.bodies.at(0), LEAN), Error, "body 0: the pose is not rigid: R^T R differs from the identity"),
    (lambda: (w := world()).bodies.set_pose(w.bodies.at(0), at(1).T), Error, "body 0: the pose's last row is not (0, 0, 0, 1)"),
    (lambda: (w := world()).bodies.set_pose(w.bodies.at(0), at(1e16)), Error, "beyond 1e15 m"),
    (lambda: (w := world()).bodies.set_pose(w.bodies.at(0), [0, 0, 0, 0, 0, 0, 0]), ValueError, "bodies.set_pose: pose: the quaternion (0, 0, 0, 0) has length 0; it must be near 1"),
    (lambda: (w := world()).bodies.set_pose(w.bodies.at(0), [0, 0, 0, np.nan, 0, 0, 1]), ValueError, "has length nan"),
    (lambda: (w := world()).bodies.set_pose(w.bodies.at(0), "pose"), TypeError, "bodies.set_pose: pose: expected an array of numbers"),
    (lambda: world().bodies.set_pose(-1, np.eye(4)), ValueError, "bodies.set_pose: body: -1 is out of range"),
    (lambda: world().bodies.set_pose(2**64, np.eye(4)), ValueError, "bodies.set_pose: body: 18446744073709551616 is out of range"),
    (lambda: world().bodies.set_pose(0.0, np.eye(4)), TypeError, "bodies.set_pose: body: expected a whole number; got float"),
    (lambda: world().bodies.set_pose(True, np.eye(4)), TypeError, "bodies.set_pose: body: expected a whole number; got bool"),
    (lambda: world().bodies.set_pose(9, np.eye(4)), Error, "body: the id is null; Bodies::add() returns ids"),
    (lambda: world().bodies.set_pose([0, 1], np.tile(np.eye(4), (3, 1, 1))), ValueError, "bodies.set_pose: pose: 3 entries, but an earlier argument has 2; must be as many, or one for all"),
    (lambda: world().bodies.set_pose([[0, 1]], np.eye(4)), ValueError, "bodies.set_pose: body: expected shape (N,), got (1, 2)"),
    (lambda: world().bodies.set_pose([0.0, 1.0], np.eye(4)), TypeError, "bodies.set_pose: body: expected an array of whole numbers"),
    (lambda: world().bodies.set_pose([-1], np.eye(4)), ValueError, "bodies.set_pose: body: -1 is out of range"),
    (lambda: world().bodies.add(world().models.add(MESH), np.eye(4)), Error, "of another World"),
    (lambda: (w := world()).bodies.set_filter(w.bodies.at(0), 2**32, 1), ValueError, "bodies.set_filter: layer: 4294967296 is out of range; must be from 0 to 4294967295"),
    (lambda: (w := world()).bodies.remove([w.bodies.at(0)] * 2), Error, "body 0 is listed twice"),
    (lambda: (w := world()).bodies.exclude(w.bodies.at(0), w.bodies.at(0)), Error, "cannot be excluded from itself"),
    (lambda: "x" in world().bodies, TypeError, "bodies.__contains__: body: expected a whole number; got str"),
    # queries
    (lambda: world().space.overlaps_segment([0, 0], [1, 1, 1]), ValueError, "space.overlaps_segment: start: expected shape (3,) or (N, 3), got (2,)"),
    (lambda: world().space.overlaps_segment([0, 0, 0], [1, np.inf, 1]), Error, "segment"),
    (lambda: world().space.overlaps_segment([[0, 0, 0]], [[1, 1, 1], [2, 2, 2]]), ValueError, "space.overlaps_segment: end: 2 entries, but an earlier argument has 1"),
    (lambda: world().space.cast([[0, 0, 0]], [[1, 1, 1], [2, 2, 2]]), ValueError, "space.cast: end: 2 entries, but an earlier argument has 1"),
    (lambda: world().space.cast_all([0, 0, 0], [0, 0, 0]), Error, "the segment has no length"),
    (lambda: world().space.overlaps_box([1, 1, 1], [0, 0, 0]), Error, "the box is empty"),
    (lambda: world().space.overlaps_box([np.nan] * 3, [1, 1, 1]), Error, "box"),
    (lambda: (w := world()).pairs.distance(w.bodies.at(0), w.bodies.at(1), tolerance=-1), Error, "tolerance"),
    (lambda: (w := world()).pairs.distance(w.bodies.at(0), w.bodies.at(1), cutoff=np.nan), Error, ""),
    (lambda: world().pairs.contacts([0], [0, 1]), ValueError, "pairs.contacts: b: 2 entries, but an earlier argument has 1; must be as many, or one for all"),
    (lambda: (w := world()).pairs.contacts(w.bodies.at(0), 7), Error, "body: the id is null"),
    (lambda: (w := World(), w.models.set_cells(w.models.add(MESH), [[0, 0, 0]], "free")), Error, "is not an occupancy map"),
    (lambda: (w := World(), w.models.set_cells(w.models.add(MESH), [[0, 0, 0]], "gone")), ValueError, "models.set_cells: state: no 'gone'; valid: unknown, free, occupied"),
    (lambda: pair().decide(CUBE, 1), TypeError, "pairs.decide: a: expected a whole number; got Cube"),
    (lambda: pair().decide((MESH, None), 1), TypeError, "pairs.decide: a: expected a Model, as models.add() returns it, or many; got Geometry"),
    (lambda: pair().decide(([MESH], None), 1), TypeError, "pairs.decide: a: expected a Model, as models.add() returns it; got Geometry"),
    (lambda: pair().decide(1, (np.zeros(2), None)), TypeError, "pairs.decide: b: expected a Model"),
    (lambda: pair().decide(1, (np.zeros((2, 2), np.uint64), None)), ValueError, "pairs.decide: b: expected shape (N,) of models, got (2, 2)"),
    (lambda: pair().decide(1, ("model", None)), TypeError, "pairs.decide: b: expected a Model"),
    (lambda: pair().decide(1, (1, 2, 3)), ValueError, "pairs.decide: b: expected the id of a body, or a tuple (model, pose)"),
    (lambda: pair().sweep(1, (1,)), ValueError, "pairs.sweep: b: expected the id of a body, or a tuple (model, pose) or (model, start, end)"),
    (lambda: pair().decide((model(), np.zeros((5, 4, 5))), 1), ValueError, "pairs.decide: a: expected shape (N, 4, 4), or (N, 7) with x y z qx qy qz qw, or one pose for all, got (5, 4, 5)"),
    (lambda: pair().decide((model(), np.zeros((2, 4, 4))), [1, 2, 3]), ValueError, "pairs.decide: b: 3 entries, but an earlier argument has 2; must be as many, or one for all"),
    (lambda: pair().decide(([model()] * 2, np.zeros((3, 4, 4))), 1), ValueError, "pairs.decide: a: 3 entries, but an earlier argument has 2"),
    (lambda: pair().decide((model(), None), (model(), None)), Error, "the id is of another World"),
    (lambda: (w := world()).pairs.decide((w.bodies.model(w.bodies.at(0)), MIRROR), w.bodies.at(1)), Error, "the pose is not rigid: it mirrors"),
    (lambda: (w := world()).pairs.max_error([w.bodies.at(0)], w.bodies.at(1)), ValueError, "pairs.max_error: a: expected one pair"),
    (lambda: (w := world()).space.distances(w.models.at(0), None, np.inf), Error, "the cutoff to all bodies must be finite"),
    (lambda: oncollide.distance(MESH, None, MESH, None, tolerance=-1), Error, "tolerance"),
    (lambda: oncollide.collide(MESH, NAN, MESH, None), Error, "pose a: the pose is not finite"),
    (lambda: oncollide.collide(MESH, None, CUBE, None), TypeError, "collide: b: expected a Geometry"),
]  # fmt: skip


@pytest.mark.parametrize("number", range(len(CASES)))
def test_bad_input_is_refused_by_name(number):
    call, kind, message = CASES[number]
    with pytest.raises(Exception) as caught:
        call()
    assert type(caught.value) is kind, caught.value
    assert message in str(caught.value)
    assert re.search(r"\S", str(caught.value)) and (kind is not Error or caught.value.kind in ("usage", "bad_data", "no_input"))


def test_what_was_refused_changed_nothing():
    made = world()
    before = [made.bodies.pose(made.bodies.at(i)) for i in (0, 1)]
    poses = np.stack([at(1), NAN])
    with pytest.raises(Error, match="body 1"):
        made.bodies.set_pose([made.bodies.at(0), made.bodies.at(1)], poses)
    with pytest.raises(Error):
        made.bodies.remove([made.bodies.at(0), 7])
    with pytest.raises(Error):
        made.bodies.add(made.bodies.model(made.bodies.at(0)), poses)
    assert len(made.bodies) == 2 and np.array_equal([made.bodies.pose(made.bodies.at(i)) for i in (0, 1)], before)


def test_a_body_that_is_forgotten_in_a_broken_array_leaves_no_exception_behind():
    made = world()
    for _ in range(3):
        with pytest.raises(TypeError):
            made.bodies.set_pose(made.bodies.at(0), Broken())
        made.step()

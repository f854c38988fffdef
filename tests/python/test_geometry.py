"""Geometries: from arrays, from files, from dimensions."""

import gc
import json
import os
import warnings

import numpy as np
import pytest

import oncollide
from conftest import SOURCE, Cube, at
from oncollide import Verdict


def test_a_mesh_copies_its_arrays_and_gives_them_back():
    cube = Cube()
    mesh = oncollide.mesh(cube.vertices, cube.faces, "cube")
    assert (mesh.name, mesh.kind, mesh.closed) == ("cube", "mesh", True)
    assert np.array_equal(mesh.vertices, cube.vertices) and np.array_equal(mesh.faces, cube.faces)
    assert np.array_equal(mesh.bounds, [[0, 0, 0], [1, 1, 1]])
    cube.vertices[:] = np.nan  # the mesh has its own copy
    assert np.isfinite(mesh.vertices).all()
    with pytest.raises(ValueError):
        mesh.vertices[0, 0] = 7


@pytest.mark.parametrize("dtype", [np.float64, np.float32, ">f8", np.int16, np.longdouble])
@pytest.mark.parametrize("order", ["C", "F"])
def test_arrays_of_any_number_order_and_stride_are_taken(dtype, order):
    cube = Cube()
    vertices = np.zeros((16, 3), dtype, order=order)
    vertices[::2] = cube.vertices
    mesh = oncollide.mesh(vertices[::2], cube.faces.astype(np.uint8, order=order))
    assert np.array_equal(mesh.vertices, cube.vertices)
    unaligned = np.frombuffer(b"x" + cube.vertices.tobytes(), dtype=np.float64, offset=1).reshape(-1, 3)
    assert np.array_equal(oncollide.mesh(unaligned, cube.faces.tolist()).vertices, cube.vertices)


def test_views_of_a_mesh_outlive_it():
    mesh = oncollide.sphere_mesh(1.0, 500)
    vertices, faces = mesh.vertices, mesh.faces
    expected = vertices.copy()
    del mesh
    gc.collect()
    assert np.array_equal(vertices, expected) and faces.max() < len(vertices)


SHAPES = {
    "sphere": (oncollide.sphere(2), [2, 2, 2]),
    "box": (oncollide.box([1, 2, 3]), [1, 2, 3]),
    "capsule": (oncollide.capsule(1, 2), [1, 1, 2]),
    "cylinder": (oncollide.cylinder(1, 2), [1, 1, 1]),
    "cone": (oncollide.cone(1, 2), [1, 1, 1]),
    "ellipsoid": (oncollide.ellipsoid((1, 2, 3)), [1, 2, 3]),
    "convex_hull": (oncollide.convex_hull(2 * Cube().vertices - 1), [1, 1, 1]),
}


@pytest.mark.parametrize("kind", SHAPES)
def test_shapes_have_their_sizes_and_meet_what_is_there(kind):
    shape, half = SHAPES[kind]
    assert shape.kind == kind and shape.closed
    assert np.allclose(shape.bounds, [np.negative(half), half])
    world = oncollide.World()
    model = world.models.add(shape)
    ball = world.bodies.add(world.models.add(oncollide.sphere(0.5)), at(0, 0, half[2] + 1))
    distance = world.pairs.distance(world.bodies.add(model), ball)
    assert distance["lower"] <= 0.5 <= distance["upper"] + 1e-9
    world.bodies.set_pose(ball, at(0, 0, half[2]))
    assert oncollide.slots(world.space.overlaps(model)["body"]).tolist() == [0, 1]


def test_a_half_space_is_a_floor_without_end():
    world = oncollide.World()
    floor = world.bodies.add(world.models.add(oncollide.half_space("floor")), static=True)
    ball = world.bodies.add(world.models.add(oncollide.sphere(1.0)), at(1e6, 0, 3))
    assert world.pairs.distance(floor, ball)["lower"] == pytest.approx(2)


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.int16])
def test_a_terrain_is_the_surface_over_its_heights(dtype):
    heights = np.zeros((4, 6), dtype)
    heights[2, 3] = 5
    terrain = oncollide.terrain(heights, spacing=(2.0, 3.0), origin=(10, 20, 0), name="hill")
    assert np.array_equal(terrain.bounds, [[10, 20, 0], [20, 29, 5]])
    world = oncollide.World(exact="predicates")
    land = world.bodies.add(world.models.add(terrain), static=True)
    peak = world.bodies.add(world.models.add(oncollide.sphere_mesh(0.1, 100)), at(16, 26, 5.2))
    assert world.pairs.distance(land, peak)["upper"] < 0.11
    assert oncollide.Verdict.COLLIDING not in world.step().pairs["verdict"]
    world.bodies.set_pose(peak, at(16, 26, 5))
    assert world.step().pairs["verdict"].tolist() == [oncollide.Verdict.COLLIDING]


def test_a_terrain_has_holes_and_diagonals():
    heights = np.zeros((3, 3))
    heights[0, 0] = np.nan
    holes = oncollide.terrain(heights, no_data=np.nan)
    world = oncollide.World(exact="predicates")
    land = world.bodies.add(world.models.add(holes))
    pin = world.bodies.add(world.models.add(oncollide.sphere_mesh(0.05, 100)), at(0.3, 0.3))
    assert world.pairs.distance(land, pin)["lower"] > 0.5
    falling = np.zeros((2, 2), bool)
    falling[0, 0] = True
    bowl = np.array([[0, 1, 1], [1, 0, 1], [1, 1, 1]], float)  # the diagonals of cell 0 are 1 m apart at its centre
    for name, terrain in [("rising", oncollide.terrain(bowl)), ("falling", oncollide.terrain(bowl, falling=falling))]:
        world = oncollide.World(exact="predicates")
        world.bodies.add(world.models.add(terrain))
        ball = world.models.add(oncollide.sphere(0.01))
        assert len(world.space.overlaps(ball, at(0.5, 0.5, 1))) == (name == "falling")
        assert len(world.space.overlaps(ball, at(0.5, 0.5, 0))) == (name == "rising")


def test_a_map_is_its_cells():
    grid = np.zeros((5, 5, 5), bool)
    grid[1:3, 2, 4] = True
    cells = oncollide.occupancy_map(np.argwhere(grid), 0.5, "map")
    assert cells.kind == "map"
    assert np.allclose(cells.bounds, [[0.5, 1, 2], [1.5, 1.5, 2.5]])
    world = oncollide.World()
    model = world.models.add(cells)
    world.bodies.add(model)
    ball = world.models.add(oncollide.sphere(0.1))
    assert len(world.space.overlaps(ball, at(1.25, 1.25, 2.25))) == 1
    assert len(world.space.overlaps(ball, at(2.5, 1.25, 2.25))) == 0
    world.models.set_cells(model, [[2.6, 1.1, 2.1]], "occupied")
    assert len(world.space.overlaps(ball, at(2.5, 1.25, 2.25))) == 1
    world.models.set_cells_in_box(model, [1, 0, 0], [9, 9, 9], "free")
    assert len(world.space.overlaps(ball, at(1.25, 1.25, 2.25))) == 0 and len(world.space.overlaps(ball, at(0.75, 1.25, 2.25))) == 1
    world.models.insert_scan(model, [[4.1, 1.1, -3.1]], [0.1, 1.1, -3.1])
    assert len(world.space.overlaps(ball, at(4.25, 1.25, -3.25))) == 1
    world.models.replace_cells(model, [-9, -9, -9], [9, 9, 9], oncollide.occupancy_map([[20, 20, 20], [6, 0, 0]], 0.5))
    assert len(world.space.overlaps(ball, at(3.25, 0.25, 0.25))) == 1 and len(world.space.overlaps(ball, at(4.25, 1.25, -3.25))) == 0
    assert np.allclose(cells.bounds[1], [1.5, 1.5, 2.5]), "the geometry itself never changes"


def test_files_become_geometries(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    mesh = oncollide.load_mesh(tmp_path / "a.obj", scale=2.0)
    assert np.array_equal(mesh.bounds, [[0, 0, 0], [2, 2, 0]]) and mesh.name == str(tmp_path / "a.obj")
    odd = os.fsencode(tmp_path) + b"/\xff.obj"  # not UTF-8
    os.link(tmp_path / "a.obj", odd)
    assert np.array_equal(oncollide.load_mesh(odd, centre=True).bounds[1], [0.5, 0.5, 0])
    assert os.fsencode(oncollide.load_mesh(os.fsdecode(odd)).name) == odd
    np.save(tmp_path / "h.npy", np.arange(12.0).reshape(3, 4))
    assert np.array_equal(oncollide.load_terrain(str(tmp_path / "h.npy"), spacing=2).bounds, [[0, 0, 0], [6, 4, 11]])
    for file, kind in [("a.obj", "mesh"), ("h.npy", "terrain")]:
        assert oncollide.load(tmp_path / file).kind == kind
    loads = [(oncollide.load_mesh, "b.obj"), (oncollide.load_map, "b.bt"), (oncollide.load_terrain, "b.pgm")]
    for load, name in loads + [(oncollide.load, "c" + name[1:]) for _, name in loads]:
        with pytest.raises(oncollide.Error, match=name) as caught:
            load(tmp_path / name)
        assert caught.value.kind == "no_input"
        (tmp_path / name).write_text("nonsense")
        with pytest.raises(oncollide.Error, match=name) as caught:
            load(tmp_path / name)
        assert caught.value.kind == "bad_data"


def test_cooked_files_stay_where_they_are_and_give_the_same_results(tmp_path):
    heights = np.sin(np.arange(90)[:, None] / 5) + np.cos(np.arange(70) / 7)
    land = oncollide.terrain(heights, spacing=0.5)
    columns, rows = np.meshgrid(np.arange(70) * 0.5, np.arange(90) * 0.5)
    corners = np.stack([columns, rows, heights], axis=-1).reshape(-1, 3)
    first = (np.arange(89)[:, None] * 70 + np.arange(69)).reshape(-1)
    faces = np.concatenate([np.stack([first, first + 1, first + 71], 1), np.stack([first, first + 71, first + 70], 1)])
    mesh = oncollide.mesh(corners, faces)
    city = oncollide.occupancy_map(np.argwhere(np.random.default_rng(3).random((30, 30, 3)) < 0.2), 0.5)

    def play(geometry, **settings):
        world = oncollide.World(exact="predicates", **settings)
        world.bodies.add(world.models.add(geometry), static=True)
        world.bodies.add(world.models.add(oncollide.torus_mesh(1.5, 0.4, 200)), np.stack([at(3 * i + 2, 2 * i + 2, 1) for i in range(6)]))
        pairs = world.step().pairs
        pairs["a"], pairs["b"] = oncollide.slots(pairs["a"]), oncollide.slots(pairs["b"])  # ids differ from World to World
        return [sorted(p.tolist() for p in pairs), world.hash, world.inspect()["file_faults"]]

    load = {"mesh": lambda p: oncollide.load_mesh(p, on_demand=True), "terrain": oncollide.load_terrain, "map": oncollide.load_map}
    for source in (mesh, land, city):
        file = tmp_path / f"{source.kind}.cooked"
        oncollide.cook(source, file)
        cooked = load[source.kind](file)
        assert oncollide.load(file).kind == source.kind
        assert cooked.kind == source.kind and np.array_equal(cooked.bounds, source.bounds)
        pairs = play(source)
        assert any(p[2] == Verdict.COLLIDING for p in pairs[0]), source
        assert play(cooked) == play(cooked, resident_budget=1 << 20, look_ahead=3) == pairs

    on_disk = load["mesh"](tmp_path / "mesh.cooked")
    assert "in its file" in repr(on_disk)
    for of_memory in ("vertices", "faces", "closed"):
        with pytest.raises(AttributeError, match="without on_demand"):
            getattr(on_disk, of_memory)
    assert np.array_equal(oncollide.load_mesh(tmp_path / "mesh.cooked").faces, mesh.faces)
    with pytest.raises(ValueError, match="load_mesh: on_demand"):
        oncollide.load_mesh(tmp_path / "mesh.cooked", scale=2, on_demand=True)
    with pytest.raises(ValueError, match="cook: path.*cooked"):
        oncollide.cook(mesh, tmp_path / "mesh.bin")
    for of_no_use in (oncollide.sphere(1), on_disk):
        with pytest.raises(oncollide.Error, match="cook: only"):
            oncollide.cook(of_no_use, tmp_path / "a.cooked")

    damaged = bytearray((tmp_path / "mesh.cooked").read_bytes())
    for byte in range(len(damaged) // 4, len(damaged), 1000):
        damaged[byte] ^= 1  # in every chunk
    (tmp_path / "mesh.cooked").write_bytes(damaged)
    pairs, _, faults = play(load["mesh"](tmp_path / "mesh.cooked"))
    assert Verdict.UNDECIDED in [p[2] for p in pairs]
    assert faults and all("mesh.cooked: chunk" in f and "checksum" in f for f in faults)


def test_generators_are_closed_and_of_the_size_that_was_asked_for():
    for mesh, faces in [(oncollide.box_mesh([1, 1, 1]), 12), (oncollide.sphere_mesh(1, 800), 800),
                        (oncollide.torus_mesh(2, 1, 500), 500), (oncollide.torus_knot_mesh(2, 3, 1, 0.4, 0.15, 600), 600)]:  # fmt: skip
        assert len(mesh.faces) == faces and mesh.closed
    assert np.array_equal(oncollide.hills(20, 10, 0.5, 3.0, 1).bounds[:, :2], [[0, 0], [10, 5]])
    with pytest.raises(AttributeError, match="Geometry.vertices: only a mesh has it; this is a terrain"):
        oncollide.hills(20, 10, 0.5, 3.0, 1).vertices


def test_the_version_is_the_projects():
    assert f"project(oncollide VERSION {oncollide.__version__} " in (SOURCE / "CMakeLists.txt").read_text()


def test_what_a_reader_leaves_out_is_a_warning(tmp_path):
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4")
    (tmp_path / "a.bin").write_bytes(vertices.tobytes())
    file = {"asset": {"version": "2.0"}, "nodes": [{"mesh": 0, "skin": 0}], "skins": [{"joints": [0]}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"uri": "a.bin", "byteLength": 36}]}
    (tmp_path / "a.gltf").write_text(json.dumps(file))
    with pytest.warns(UserWarning, match="a.gltf: 1 node has a skin, which is not applied"):
        assert len(oncollide.load(tmp_path / "a.gltf").faces) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(UserWarning):
            oncollide.load_mesh(tmp_path / "a.gltf")

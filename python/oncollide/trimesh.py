"""A CollisionManager with the names and return types of trimesh's, for any object with `vertices` and `faces`.

Differences: poses stay in double; equal meshes share one model; adding an object builds nothing; all closed meshes are
solids, not only convex ones; touching counts as collision, exactly; the distance of meshes that meet is 0, not
negative, and `depth` is nan, because oncollide does not estimate it. Addition: `bound`, certified, in metres.
"""

import collections
import hashlib
import math

import numpy as np

from . import Geometry, Verdict, World, mesh as _mesh

__all__ = ["CollisionManager", "ContactData", "DistanceData", "scene_to_collision"]

_EXTERNAL = "__external"  # trimesh's name for the mesh of a *_single call


class ContactData:
    """One contact: two triangles that meet.

    names: set of the two objects' names. point: (3,), on both. normal: (3,), unit, of the triangle of the object that
    comes first. depth: nan. bound: certified upper bound on the objects' distance, metres; 0 if they meet exactly.
    """

    def __init__(self, names, contact, bound):
        self.names = set(names)
        self.normal = contact["normal_a"]
        self.point = contact["ends"][0]
        self.depth = math.nan
        self.bound = bound
        self._index = {names[0]: int(contact["triangle_a"]), names[1]: int(contact["triangle_b"])}

    def index(self, name):
        """Index of the triangle in contact, of the object with that name."""
        return self._index[name]


class DistanceData:
    """The nearest two objects.

    names: set of their names. distance: metres; 0 if they meet. bound: (lower, upper), certified.
    """

    def __init__(self, names, found):
        self.names = set(names)
        self.distance = float(found["upper"])
        self.bound = (float(found["lower"]), float(found["upper"]))
        self._index = {names[0]: int(found["triangle_a"]), names[1]: int(found["triangle_b"])}
        self._point = {names[0]: found["point_a"], names[1]: found["point_b"]}

    def index(self, name):
        """Index of the nearest triangle of the object with that name."""
        return self._index[name]

    def point(self, name):
        """The nearest point, (3,), on the object with that name."""
        return self._point[name]


class CollisionManager:
    """Finds which of many meshes collide, and how far apart they are.

    settings: of oncollide.World. The defaults are exact='predicates' and mode='solid', in which a mesh that is not
    closed is a surface. With max_error=0.01 and exact='off', objects closer than 1 cm may count as in collision, and
    `bound` is an upper bound on their distance.
    """

    _KEPT = 8  # models of *_single calls that are kept for the next call

    def __init__(self, **settings):
        settings = {"exact": "predicates", "mode": "solid", **settings}
        if settings["mode"] == "solid":
            settings.setdefault("open_as_surface", True)
        self._world = World(**settings)
        self._bodies = {}  # name -> id
        self._names = {}  # id -> name
        self._keys = {}  # name -> key of its model
        self._models = {}  # key -> [model, geometry, objects that use it]
        self._idle = collections.OrderedDict()  # keys of models that no object uses, oldest first

    def add_object(self, name, mesh, transform=None):
        """Adds an object, or replaces the object of that name. Returns its body's id.

        mesh: a Geometry, or anything with `vertices` (V, 3) and `faces` (F, 3). transform: (4, 4) or (7,), metres; None:
        the identity.
        """
        key = self._model_key(mesh)
        body = self._world.bodies.add(self._models[key][0], transform)
        if name in self._bodies:
            self.remove_object(name)
        self._use(key)
        self._bodies[name], self._names[body], self._keys[name] = body, name, key
        return body

    def remove_object(self, name):
        """Removes an object. Raises ValueError if there is none with that name."""
        body = self._body(name)
        self._world.bodies.remove(body)
        del self._bodies[name], self._names[body]
        self._leave(self._keys.pop(name))

    def set_transform(self, name, transform):
        """Moves an object. Raises ValueError if there is none with that name."""
        self._world.bodies.set_pose(self._body(name), transform)

    def in_collision_single(self, mesh, transform=None, return_names=False, return_data=False):
        """Returns whether a mesh collides with any object.

        return_names adds the set of their names, return_data a list of ContactData: every pair of triangles that meet,
        so none for a mesh that is completely inside another.
        """
        model = self._models[self._model_key(mesh)][0]
        hits = self._world.space.overlaps(model, transform)
        names = [self._names[int(body)] for body in hits["body"]]
        data = []
        if return_data and names:
            data = self._contacts(hits["body"], (model, transform), [(name, _EXTERNAL) for name in names], hits["bound"])
        return _results(bool(names), set(names), data, return_names, return_data)

    def in_collision_internal(self, return_names=False, return_data=False):
        """Returns whether any two objects collide.

        return_names adds the set of pairs of names, each sorted; return_data a list of ContactData.
        """
        pairs = self._world.step().pairs
        pairs = pairs[pairs["verdict"] != Verdict.SEPARATE]
        names = [(self._names[int(a)], self._names[int(b)]) for a, b in zip(pairs["a"], pairs["b"])]
        data = []
        if return_data and names:
            data = self._contacts(pairs["a"], pairs["b"], names, pairs["bound"])
        return _results(bool(names), {tuple(sorted(pair)) for pair in names}, data, return_names, return_data)

    def in_collision_other(self, other_manager, return_names=False, return_data=False):
        """Returns whether any object collides with an object of another manager.

        With return_names also returns the set of pairs of names, this manager's first; with return_data also a
        list of ContactData.
        """
        pairs, data = set(), []
        for name, (model, pose) in self._objects_of(other_manager):
            hits = self._world.space.overlaps(model, pose)
            found = [(self._names[int(body)], name) for body in hits["body"]]
            pairs.update(found)
            if return_data and found:
                data += self._contacts(hits["body"], (model, pose), found, hits["bound"])
        return _results(bool(pairs), pairs, data, return_names, return_data)

    def min_distance_single(self, mesh, transform=None, return_name=False, return_data=False):
        """Returns the distance of a mesh from the nearest object.

        In metres; 0 if they meet, inf without objects. return_name adds the object's name, return_data a DistanceData.
        """
        nearest = _Nearest()
        placed = self._models[self._model_key(mesh)][0], transform
        for name, other in self._bodies.items():
            nearest.look(self._world, other, placed, (name, _EXTERNAL))
        name = nearest.names[0] if nearest.names else None
        return _results(nearest.distance, name, nearest.data(), return_name, return_data)

    def min_distance_internal(self, return_names=False, return_data=False):
        """Returns the distance of the nearest two objects.

        In metres; 0 if two meet, inf with fewer than two. return_names adds the two names, sorted; return_data a
        DistanceData. Cost: tests every pair of objects; distant pairs cost least.
        """
        nearest = _Nearest()
        objects = list(self._bodies.items())
        for i, (name, body) in enumerate(objects):
            for other_name, other in objects[:i]:
                nearest.look(self._world, other, body, (other_name, name))
        names = tuple(sorted(nearest.names)) if nearest.names else None
        return _results(nearest.distance, names, nearest.data(), return_names, return_data)

    def min_distance_other(self, other_manager, return_names=False, return_data=False):
        """Returns the distance of the nearest two objects, one of each manager.

        In metres; 0 if two meet, inf without objects. return_names adds the two names, this manager's first; return_data
        a DistanceData.
        """
        nearest = _Nearest()
        for name, placed in self._objects_of(other_manager):
            for mine, other in self._bodies.items():
                nearest.look(self._world, other, placed, (mine, name))
        return _results(nearest.distance, nearest.names, nearest.data(), return_names, return_data)

    # --- Models: objects with equal geometry share one.

    def _model_key(self, mesh):
        if isinstance(mesh, Geometry):
            key, make = mesh, lambda: mesh
        else:
            try:
                vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
            except AttributeError:
                raise TypeError(
                    "CollisionManager: mesh: expected a Geometry, or an object with vertices and faces; got "
                    + type(mesh).__name__
                ) from None
            digest = hashlib.blake2b(digest_size=16)
            for array in (vertices, faces):
                digest.update(f"{array.dtype.str}{array.shape}".encode())
                digest.update(np.ascontiguousarray(array))
            key, make = digest.digest(), lambda: _mesh(vertices, faces)
        if key not in self._models:
            geometry = make()
            self._models[key] = [self._world.models.add(geometry), geometry, 0]
            self._idle[key] = None
            self._drop_oldest()
        elif key in self._idle:
            self._idle.move_to_end(key)
        return key

    def _use(self, key):
        self._models[key][2] += 1
        self._idle.pop(key, None)

    def _leave(self, key):
        self._models[key][2] -= 1
        if self._models[key][2] == 0:
            self._idle[key] = None
            self._drop_oldest()

    def _drop_oldest(self):
        while len(self._idle) > self._KEPT:
            key, _ = self._idle.popitem(last=False)
            self._world.models.remove(self._models.pop(key)[0])

    # --- Objects.

    def _body(self, name):
        if name not in self._bodies:
            raise ValueError(f"{name} not in collision manager!")
        return self._bodies[name]

    def _objects_of(self, other):
        """For each object of another manager: its name, and its model here with its pose."""
        for name, body in other._bodies.items():
            key = self._model_key(other._models[other._keys[name]][1])
            yield name, (self._models[key][0], other._world.bodies.pose(body))

    def _contacts(self, a, b, names, bounds):
        contacts, offsets = self._world.pairs.contacts(a, b)
        return [
            ContactData(pair, contact, float(bound))
            for i, (pair, bound) in enumerate(zip(names, bounds))
            for contact in contacts[offsets[i] : offsets[i + 1]]
        ]


class _Nearest:
    """The nearest of the pairs tested so far; tests of more distant pairs are cheap."""

    def __init__(self):
        self.distance, self.names, self._found = math.inf, None, None

    def look(self, world, a, b, names):
        if self.distance == 0:
            return
        found = world.pairs.distance(a, b, cutoff=self.distance)
        if found["upper"] < self.distance:
            self.distance, self.names, self._found = float(found["upper"]), names, found

    def data(self):
        return DistanceData(self.names, self._found) if self.names else None


def _results(result, names, data, return_names, return_data):
    """The result alone, or a tuple with the other requested values, as in trimesh."""
    extra = ([names] if return_names else []) + ([data] if return_data else [])
    return (result, *extra) if extra else result


def scene_to_collision(scene):
    """A CollisionManager of the objects of a trimesh.Scene, and the bodies' ids by name of the scene's nodes."""
    manager, bodies = CollisionManager(), {}
    for node in scene.graph.nodes_geometry:
        transform, geometry = scene.graph[node]
        bodies[node] = manager.add_object(node, scene.geometry[geometry], transform)
    return manager, bodies

"""oncollide finds which bodies of a large environment collide, frame by frame, at a certified accuracy.

Geometries are made by mesh(), load(), sphere(), terrain() and others. A World holds bodies and finds the
pairs that collide; Queries test many pairs at many poses at once. Lengths are metres, angles radians.
"""

import enum

try:
    import numpy as _numpy
except ModuleNotFoundError as _missing:
    if _missing.name != "numpy":
        raise
    raise ImportError("oncollide needs NumPy: apt install python3-numpy, or pip install numpy") from None

from ._core import (
    Error,
    Frame,
    Geometry,
    Model,
    Queries,
    Robot,
    World,
    box,
    box_mesh,
    capsule,
    cone,
    convex_hull,
    cook,
    cylinder,
    ellipsoid,
    half_space,
    hills,
    load,
    load_map,
    load_mesh,
    load_terrain,
    mesh,
    occupancy_map,
    sphere,
    sphere_mesh,
    terrain,
    torus_knot_mesh,
    torus_mesh,
)

__version__ = "0.1.0"


def slots(ids):
    """The slots of bodies from their ids, uint32 (N,): small numbers for tables and messages; free slots are reused."""
    return (_numpy.asarray(ids, dtype=_numpy.uint64) & 0xFFFFFFFF).astype(_numpy.uint32)


MeshQueries = Queries  # the name in C++


def _sides(a, pose_a, b, pose_b):
    world = World(exact="predicates")
    return world, (world.add(a), pose_a), (world.add(b), pose_b)


def collide(a, pose_a, b, pose_b):
    """Whether two geometries at two poses collide, exactly; touching counts. Returns a result as World.decide().

    This call and distance(), contacts() and penetration() build their trees anew; a World or Queries keep them.
    """
    world, one, other = _sides(a, pose_a, b, pose_b)
    return world.decide(one, other)


def distance(a, pose_a, b, pose_b, tolerance=0.0, cutoff=None):
    """Certified bounds on the distance of two geometries at two poses, as World.distance()."""
    world, one, other = _sides(a, pose_a, b, pose_b)
    return world.distance(one, other, tolerance, cutoff)


def contacts(a, pose_a, b, pose_b):
    """All pairs of parts of two geometries at two poses that meet, as World.contacts()."""
    world, one, other = _sides(a, pose_a, b, pose_b)
    return world.contacts(one, other)


def penetration(a, pose_a, b, pose_b):
    """How deep two geometries at two poses penetrate each other, as World.penetration()."""
    world, one, other = _sides(a, pose_a, b, pose_b)
    return world.penetration(one, other)


class Verdict(enum.IntEnum):
    """The certified state of a pair of bodies; the numbers in `verdict` of arrays."""

    SEPARATE = 0  #: the distance exceeds the clearance, and is at least the bound
    WITHIN = 1  #: the distance is at most the bound; the bodies may or may not collide
    COLLIDING = 2  #: the surfaces meet, or one solid encloses the other or a part of it
    UNDECIDED = 3  #: a budget or a skipped stage stopped refinement; the distance is at most the bound


class ContactKind(enum.IntEnum):
    """How a pair collides or is near, if an exact level determined it; the numbers in `kind` of arrays."""

    UNKNOWN = 0  #: not determined, or there is no contact
    NEAR = 1  #: no contact; the distance is at most the clearance
    TOUCHING = 2  #: triangles meet, no two of them cross
    CROSSING = 3  #: at least two triangles cross
    ENCLOSED = 4  #: a part of one body is inside the other


__all__ = [name for name in dir() if not name.startswith("_") and name != "enum"]
for _item in (Error, Frame, Geometry, Model, Queries, Robot, World):
    _item.__module__ = __name__
del _item

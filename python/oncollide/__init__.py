"""oncollide finds which bodies of a large environment collide, frame by frame, at a certified accuracy.

Geometries are made by mesh(), load(), sphere(), terrain() and others. A World holds bodies and finds the
pairs that collide; Queries test many pairs at many poses at once. Lengths are metres, angles radians.
"""

import enum

from ._core import (
    Error,
    Frame,
    Geometry,
    Model,
    Queries,
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
    import numpy

    return (numpy.asarray(ids, dtype=numpy.uint64) & 0xFFFFFFFF).astype(numpy.uint32)


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
for _item in (Error, Frame, Geometry, Model, Queries, World):
    _item.__module__ = __name__
del _item

"""oncollide finds which bodies of a large environment collide, frame by frame, at a certified accuracy.

Geometries are made by mesh(), load(), sphere(), terrain() and others. A World holds models and bodies, finds the pairs that
collide, and has queries of two sides (World.pairs) and of one thing against all bodies (World.space), one or many at once. Lengths are metres, angles radians.
"""

import enum
import functools

try:
    import numpy as _numpy
except ModuleNotFoundError as _missing:
    if _missing.name != "numpy":
        raise
    raise ImportError("oncollide needs NumPy: apt install python3-numpy, or pip install numpy") from None

from . import _core
from ._core import Bodies, Error, Frame, Geometry, ManifoldTracker, Manifolds, Model, Models, Pairs, Robot, Space

__version__ = "0.1.0"


def _by_name(function):
    """Wraps a function, so that pools of processes can pickle it; they cannot pickle a function of an extension."""

    @functools.wraps(function)
    def call(*arguments, **options):
        return function(*arguments, **options)

    call.__module__, call.__qualname__ = __name__, function.__name__
    return call


for _name, _item in list(vars(_core).items()):
    if not _name.startswith("_") and not isinstance(_item, type):
        globals()[_name] = _by_name(_item)


class World(_core.World):
    __doc__ = _core.World.__doc__
    __slots__ = {  # made once, so that a call costs no object more
        "models": "Geometries that bodies share: Models.",
        "bodies": "Models at poses: Bodies.",
        "pairs": "Queries of two sides, or of many pairs: Pairs.",
        "space": "Queries of one thing against all bodies: Space.",
    }

    def __init__(self, **settings):
        super().__init__(**settings)
        self.models, self.bodies, self.pairs, self.space = Models(self), Bodies(self), Pairs(self), Space(self)


def slots(ids):
    """The slots of bodies from their ids, uint32 (N,): small numbers for tables and messages; free slots are reused."""
    return (_numpy.asarray(ids, dtype=_numpy.uint64) & 0xFFFFFFFF).astype(_numpy.uint32)


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


class Stage(enum.IntEnum):
    """The stages of a step, in order; the numbers in `stage` of Frame.pairs: the stage that decided."""

    BOUNDS = 0  #: boxes around the bodies
    DELIMITATION = 1  #: regions in which no pair can collide
    BROAD = 2  #: pairs whose boxes overlap
    REFINE = 3  #: bounding volumes
    EXACT = 4  #: predicates, or FCL


__all__ = [name for name in dir() if not name.startswith("_") and name not in ("enum", "functools")]
for _item in (Bodies, Error, Frame, Geometry, ManifoldTracker, Manifolds, Model, Models, Pairs, Robot, Space, World):
    _item.__module__ = __name__
del _item, _name

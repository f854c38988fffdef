from collections.abc import Hashable
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import Geometry

class _Mesh(Protocol):
    @property
    def vertices(self) -> Any: ...
    @property
    def faces(self) -> Any: ...

class ContactData:
    names: set[Hashable]
    point: NDArray[np.float64]
    normal: NDArray[np.float64]
    depth: float
    bound: float
    def index(self, name: Hashable) -> int: ...

class DistanceData:
    names: set[Hashable]
    distance: float
    bound: tuple[float, float]
    def index(self, name: Hashable) -> int: ...
    def point(self, name: Hashable) -> NDArray[np.float64]: ...

class CollisionManager:
    def __init__(self, **settings: Any) -> None: ...  # settings of oncollide.World
    def add_object(self, name: Hashable, mesh: Geometry | _Mesh, transform: ArrayLike | None = None) -> int: ...
    def remove_object(self, name: Hashable) -> None: ...
    def set_transform(self, name: Hashable, transform: ArrayLike) -> None: ...
    # With return_names or return_data a tuple: the result, then the names, then the data.
    def in_collision_single(
        self,
        mesh: Geometry | _Mesh,
        transform: ArrayLike | None = None,
        return_names: bool = False,
        return_data: bool = False,
    ) -> Any: ...
    def in_collision_internal(self, return_names: bool = False, return_data: bool = False) -> Any: ...
    def in_collision_other(
        self, other_manager: CollisionManager, return_names: bool = False, return_data: bool = False
    ) -> Any: ...
    def min_distance_single(
        self,
        mesh: Geometry | _Mesh,
        transform: ArrayLike | None = None,
        return_name: bool = False,
        return_data: bool = False,
    ) -> Any: ...
    def min_distance_internal(self, return_names: bool = False, return_data: bool = False) -> Any: ...
    def min_distance_other(
        self, other_manager: CollisionManager, return_names: bool = False, return_data: bool = False
    ) -> Any: ...

def scene_to_collision(scene: Any) -> tuple[CollisionManager, dict[Hashable, int]]: ...

#pragma once
#include <memory>

#include <oncollide/pipeline/settings.hpp>
#include <oncollide/scenes/geometry.hpp>

#include "arguments.hpp"

namespace oncollide::python {

/// Shared by Python and by all Worlds and Queries that use it. Immutable.
using GeometryHandle = std::shared_ptr<const Geometry>;

GeometryHandle geometry(py::handle value, const Place& place);

/// Settings from keyword arguments.
Settings settings_of(const py::kwargs& arguments, const char* call);
std::string settings_text(); ///< one line per setting, for docstrings

// Each adds its part to the module. These functions are long because they are lists: a name, its arguments and its
// docstring, without branches.
void bind_geometry(py::module_& module);
void bind_shapes(py::module_& module);
void bind_grids(py::module_& module);
void bind_world(py::module_& module);
void bind_queries(py::module_& module);
void bind_robot(py::module_& module);

/// NumPy types with the layout of the library's results.
struct ResultTypes {
    py::dtype pair;           ///< PairResult
    py::dtype bodies;         ///< PairOfBodies
    py::dtype hit;            ///< QueryHit
    py::dtype cast;           ///< CastHit
    py::dtype contact;        ///< Contact
    py::dtype distance;       ///< Distance
    py::dtype finding;        ///< Finding
    py::dtype penetration;    ///< Penetration
    py::dtype sweep;          ///< SweepResult
    py::dtype sweep_hit;      ///< SweepHit
    py::dtype pair_sweep;     ///< PairSweep
    py::dtype robot;          ///< RobotFinding
    py::dtype robot_edge;     ///< RobotEdgeFinding
    py::dtype region;         ///< ManifoldRegion
    py::dtype manifold_point; ///< ManifoldPoint
    py::dtype near_features;  ///< NearFeatures
};
/// Called at import, before threads can wait for each other: making the types runs Python code, which may hand the
/// interpreter's lock to a thread that needs them.
void make_result_types();
const ResultTypes& result_types();

/// An array that takes ownership of the vector.
template <class T>
py::array array_of(const py::dtype& type, std::vector<T> items)
{
    if (items.empty()) return py::array(type, py::ssize_t{0});
    auto* const kept = new std::vector<T>(std::move(items));
    const py::capsule owner(kept, [](void* vector) { delete static_cast<std::vector<T>*>(vector); });
    return py::array(type, {static_cast<py::ssize_t>(kept->size())}, {}, kept->data(), owner);
}

} // namespace oncollide::python

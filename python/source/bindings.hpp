#pragma once
#include <memory>

#include <oncollide/pipeline/settings.hpp>
#include <oncollide/scenes/geometry.hpp>

#include "arguments.hpp"

namespace oncollide::python {

/// Shared by Python and by all Worlds and Queries that were given it. Never changes.
using GeometryHandle = std::shared_ptr<const Geometry>;

GeometryHandle geometry(py::handle value, const Place& place);

/// The settings that keyword arguments stand for.
Settings settings_of(const py::kwargs& arguments, const char* call);

// Each adds its part to the module.
void bind_geometry(py::module_& module);
void bind_shapes(py::module_& module);
void bind_grids(py::module_& module);
void bind_world(py::module_& module);
void bind_queries(py::module_& module);

/// Structured types over the library's own results.
struct ResultTypes {
    py::dtype pair;     ///< PairResult
    py::dtype bodies;   ///< PairOfBodies
    py::dtype hit;      ///< QueryHit
    py::dtype contact;  ///< Contact
    py::dtype distance; ///< Distance
};
/// When the module is imported, so that no thread waits for another that makes them: making them runs Python, which
/// may hand the interpreter's lock to the one that waits.
void make_result_types();
const ResultTypes& result_types();

/// An array that takes the vector over.
template <class T>
py::array array_of(const py::dtype& type, std::vector<T> items)
{
    if (items.empty()) return py::array(type, py::ssize_t{0});
    auto* const kept = new std::vector<T>(std::move(items));
    const py::capsule owner(kept, [](void* vector) { delete static_cast<std::vector<T>*>(vector); });
    return py::array(type, {static_cast<py::ssize_t>(kept->size())}, {}, kept->data(), owner);
}

} // namespace oncollide::python

#pragma once
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <fmt/format.h>

#include <oncollide/pipeline/settings.hpp>
#include <oncollide/scenes/geometry.hpp>

#include "arguments.hpp"

namespace oncollide::python {

/// Shared by Python and by all Worlds that use it. Immutable.
using GeometryHandle = std::shared_ptr<const Geometry>;

GeometryHandle geometry(py::handle value, const Place& place);

/// A geometry as a tuple of bytes and numbers, for pickles, and back. A geometry in a cooked file is its path.
py::tuple state_of(const Geometry& geometry);
GeometryHandle geometry_from(const py::tuple& state);

// Columns of plain values as bytes, for pickles.
template <class T>
py::bytes bytes_of(std::span<const T> items)
{
    return {reinterpret_cast<const char*>(items.data()), items.size_bytes()};
}
/// ValueError for bytes that are not whole values.
template <class T>
std::vector<T> values_in(py::handle bytes)
{
    const auto text = py::cast<std::string_view>(bytes);
    if (text.size() % sizeof(T) != 0)
        throw py::value_error("the pickle is damaged, or of another version of oncollide");
    std::vector<T> made(text.size() / sizeof(T));
    std::copy(text.begin(), text.end(), reinterpret_cast<char*>(made.data()));
    return made;
}
/// Lets copy and pickle raise TypeError: "World: TEXT".
template <class Class>
void refuse_pickles(Class& bound, const char* name, const char* text)
{
    bound.def("__reduce_ex__", [name, text](py::handle, py::handle) {
        throw py::type_error(fmt::format("{}: cannot be pickled or copied: {}", name, text));
    });
}

/// Settings from keyword arguments, and back.
Settings settings_of(const py::kwargs& arguments, const char* call);
py::dict dict_of(const Settings& settings);
std::string settings_text(); ///< one line per setting, for docstrings

// Each adds its part to the module. These functions are long because they are lists: a name, its arguments and its
// docstring, without branches.
void bind_geometry(py::module_& module);
void bind_shapes(py::module_& module);
void bind_grids(py::module_& module);
void bind_two_geometries(py::module_& module);
void bind_world(py::module_& module);
void bind_robot(py::module_& module);

/// The signature of a function, as inspect.signature() reads it from the begin of a docstring.
template <class... Arguments>
std::string signature(const char* name, bool has_self, const Arguments&... arguments)
{
    std::string list = has_self ? "self" : "";
    [[maybe_unused]] const auto add = [&](const auto& argument) {
        list += (list.empty() ? "" : ", ") + std::string(argument.name);
        if constexpr (requires { argument.value; }) list += "=" + std::string(py::repr(argument.value));
    };
    (add(arguments), ...);
    return fmt::format("{}({})\n--\n\n", name, list);
}

/// Adds a function to a module, or a method to a class. Its docstring begins with the signature.
template <class Scope, class Function, class... Arguments>
void define(Scope& scope, const char* name, Function function, const char* text, const Arguments&... arguments)
{
    const std::string doc = signature(name, !std::is_same_v<Scope, py::module_>, arguments...) + text;
    scope.def(name, function, arguments..., doc.c_str());
}

/// A NumPy type with the layout of one of the library's results.
struct ResultType {
    py::dtype type;
    std::size_t size; ///< size of one result, bytes
    struct Gap {
        std::size_t at, size;
    };
    std::vector<Gap> gaps; ///< bytes that belong to no field

    /// Sets the gaps to 0, so that equal results have equal bytes.
    void clear_gaps(void* results, std::size_t count) const;
};

/// Called at import, before threads can wait for each other: making the types runs Python code, which may hand the
/// interpreter's lock to a thread that needs them.
void make_result_types();
/// Never freed: the interpreter may end before static objects are destroyed.
template <class Result>
inline const ResultType* kept_type = nullptr;
template <class Result>
const ResultType& result_type()
{
    return *kept_type<Result>;
}

/// An array that takes ownership of the vector.
template <class T>
py::array array_of(const py::dtype& type, std::vector<T> items)
{
    if (items.empty()) return py::array(type, py::ssize_t{0});
    auto* const kept = new std::vector<T>(std::move(items));
    const py::capsule owner(kept, [](void* vector) { delete static_cast<std::vector<T>*>(vector); });
    return py::array(type, {static_cast<py::ssize_t>(kept->size())}, {}, kept->data(), owner);
}
/// A structured array.
template <class Result>
py::array array_of(std::vector<Result> results)
{
    const ResultType& type = result_type<Result>();
    type.clear_gaps(results.data(), results.size());
    return array_of(type.type, std::move(results));
}
/// A view of a structured column of a result, `Held`; it keeps the result alive.
template <class Held, auto member>
py::array column(py::object self)
{
    const auto& items = self.cast<const Held&>().*member;
    using Item = typename std::remove_cvref_t<decltype(items)>::value_type;
    return py::array(result_type<Item>().type, {static_cast<py::ssize_t>(items.size())}, {}, items.data(), self);
}
/// A structured scalar.
template <class Result>
py::object scalar(const Result& result)
{
    const ResultType& type = result_type<Result>();
    py::array made(type.type, py::ssize_t{1});
    std::memcpy(made.mutable_data(), static_cast<const void*>(&result), sizeof result);
    type.clear_gaps(made.mutable_data(), 1);
    return made[py::int_(0)];
}
/// (items, offsets): list i is items[offsets[i]:offsets[i + 1]].
template <class Result>
py::tuple lists_of(Lists<Result> lists)
{
    return py::make_tuple(array_of(std::move(lists.items)), offsets_of(lists.offsets));
}

/// A class of the module.
template <class T>
concept InModule = std::is_same_v<T, Geometry> || requires
{
    typename T::InModule;
};

/// Passes objects of a class of the module. An object whose __init__() was not called, as from Class.__new__(Class),
/// holds nothing: TypeError, wherever it comes in.
template <class T>
struct MadeObjects : py::detail::type_caster_base<T> {
    bool load(py::handle object, bool convert) { return this->template load_impl<MadeObjects>(object, convert); }
    void load_value(py::detail::value_and_holder&& held)
    {
        if (!held.holder_constructed())
            throw py::type_error(
                fmt::format("{}: __init__() of this object was not called", this->typeinfo->type->tp_name));
        py::detail::type_caster_base<T>::load_value(std::move(held));
    }
};

} // namespace oncollide::python

namespace pybind11::detail {
template <oncollide::python::InModule T>
class type_caster<T> : public oncollide::python::MadeObjects<T> {
};
} // namespace pybind11::detail

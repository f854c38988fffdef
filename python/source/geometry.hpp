#pragma once
#include "bindings.hpp"
#include "release.hpp"

namespace oncollide::python {

inline GeometryHandle share(std::string name, GeometryData data)
{
    return std::make_shared<const Geometry>(Geometry{std::move(name), std::move(data), {}});
}

/// The name, or the name of the call if it is missing.
inline std::string name_or(const std::string& name, const char* call)
{
    return name.empty() ? call : name;
}

/// Emits the notes of readers on this thread as UserWarning. Throws if a filter makes a warning an error.
void emit_file_warnings();

template <class Make>
GeometryHandle made_without_lock(std::string name, Make make)
{
    GeometryHandle made;
    {
        const Released released;
        made = share(std::move(name), make());
    }
    emit_file_warnings();
    return made;
}

inline int count(py::handle value, const char* call, const char* argument)
{
    return static_cast<int>(whole(value, {call, argument}, 1u << 30));
}

} // namespace oncollide::python

#pragma once
#include <filesystem>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/paths.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/scenes/files/json/json_node.hpp>

namespace oncollide {

// Errors that name a place in a JSON file. Private to scenes.

/// Calls `work` and prefixes its errors with the node's place, unless they name a place in the node already. Converts
/// usage errors to bad_data.
template <class Work>
auto at(const Node& node, Work work)
{
    try {
        return work();
    } catch (const Error& error) {
        const ErrorKind kind = error.kind() == ErrorKind::usage ? ErrorKind::bad_data : error.kind();
        const std::string place = node.place(), what = error.what();
        throw Error(kind, what.starts_with(printable(place)) ? what : place + ": " + what);
    }
}

/// The path of a file that `name` names, relative to the folder of its own file. Throws naming the place.
inline std::filesystem::path file_of(const Node& name, const std::filesystem::path& folder)
{
    return at(name, [&] { return file_in(folder, name.text()); });
}

} // namespace oncollide

#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace oncollide::tools {

enum class Group { oncollide, baseline, debian };

/// Reliability of a contender's results. Conservative: no missed collisions, but false positives. Approximate: nothing
/// is promised; errors are only counted.
enum class Promise { exact, conservative, approximate };

/// A library or a method in a benchmark.
template <class Peer, class... Input>
struct Contender {
    std::string name; ///< as in --only
    std::string what; ///< library and class or structure
    Group group = Group::debian;
    Promise promise = Promise::exact;
    bool threaded = false;                            ///< can use several threads
    std::size_t least = 1, most = ~std::size_t{0};    ///< boxes, or triangles per mesh: it crashes with fewer, or would
                                                      ///< take too long with more
    bool has_all_pairs = false, has_distance = false; ///< in addition to the main query
    /// Builds the data that it keeps between queries.
    std::function<std::unique_ptr<Peer>(Input...)> make;
};

/// A library that this build lacks.
struct MissingPeer {
    std::string library, package; ///< Debian's name
};

template <class Kind>
struct ContenderList {
    std::vector<Kind> all;
    std::vector<MissingPeer> missing;

    /// Keeps only the named contenders, in that order; an empty list keeps all. Throws Error{usage} with the valid
    /// names.
    void keep(const std::string& only);
};

} // namespace oncollide::tools

#pragma once
#include <string>

namespace oncollide::gl::walk {

/// Compute shaders of the walk. Uniforms: 0: the number of pairs, 1: room of a queue (items), 2: room of the list of
/// unsure pairs, 3: room of the list of wanted nodes, 4: the round, 5: the rows after which a walk leaves the rest to
/// the next round, 6: 1 if distances decide which pairs stay open, else 0 (MeshWalks::submit).
struct WalkShaders {
    /// The relative pose of each pair, its hint, and its first item. One invocation a pair, 64 in a group.
    static std::string prepare();
    /// One round: takes all items of a queue. Any number of groups of teams x team invocations.
    static std::string walk();
};

/// Parts of both, as GLSL.
extern const char* const box_source;      ///< boxes of nodes, and their gaps
extern const char* const triangle_source; ///< the filter of triangle pairs

} // namespace oncollide::gl::walk

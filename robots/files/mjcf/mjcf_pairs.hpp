#pragma once
#include <set>
#include <string>
#include <vector>

#include <oncollide/robots/files/mjcf/mjcf_document.hpp>

namespace oncollide {

/// The bodies of a model and the links that hold their geoms, as MuJoCo's filters see them.
struct MjcfTree {
    struct Body {
        std::string name;
        std::uint32_t parent; ///< the world, body 0, is its own
        std::uint32_t weld;   ///< the highest body to which no joint leads from this one
    };
    /// The geoms of a body with the same filter.
    struct GeomLink {
        std::uint32_t body, contype, conaffinity;
        std::string geom{}; ///< of the one geom that a <pair> names
    };
    std::vector<Body> bodies;
    std::vector<std::optional<GeomLink>> links; ///< by link; null: without geoms
};

/// <contact> and the filter of parents.
class MjcfPairs {
public:
    explicit MjcfPairs(const MjcfDocument& document);
    bool is_in_pair(const std::string& geom) const { return geoms_.contains(geom); }
    /// Pairs of links that MuJoCo does not test; a < b, sorted. Throws for names that do not exist.
    std::vector<std::pair<std::uint32_t, std::uint32_t>> excluded(const MjcfTree& tree) const;

private:
    bool is_tested(const MjcfTree& tree, const MjcfTree::GeomLink& a, const MjcfTree::GeomLink& b) const;

    const MjcfDocument& document_;
    bool filters_parents_ = true;
    std::set<std::string> geoms_;
    std::set<std::pair<std::string, std::string>> pairs_, excludes_; ///< names in order; geoms, and bodies
};

} // namespace oncollide

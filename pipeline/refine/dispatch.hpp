#pragma once
#include <cstdint>

#include <oncollide/narrowphase/pairs/pair_tests.hpp>
#include <oncollide/pipeline/models/model_store.hpp>
#include <oncollide/pipeline/settings.hpp>
#include <oncollide/pipeline/settings_rules.hpp>

namespace oncollide {

/// The two levels that decide candidate pairs, one after the other.
enum class Level : std::uint8_t { refine, exact };

enum class Refiner : std::uint8_t {
    none,    ///< the level leaves the pair as it is
    no_room, ///< the same, because a budget has no room for the required trees, or a file cannot be read
    spheres, ///< sphere-trees
    obbs,    ///< OBB trees, down to the requested error
    exact,   ///< OBB trees, down to triangles, shapes and cells
    fcl,     ///< FCL on whole bodies; counts only where the exact refiner agrees
};
constexpr std::size_t refiner_count = 6;

/// The only place that selects the refiner of a pair.
///
/// | level  | settings                                          | refiner |
/// |--------|---------------------------------------------------|---------|
/// | refine | spheres                                           | spheres |
/// | refine | OBBs, or one body is a terrain                    | obbs    |
/// | refine | the same, and predicates decide                   | none    |
/// | exact  | predicates                                        | exact   |
/// | exact  | fcl                                               | fcl     |
///
/// If a budget has no room for an OBB tree, spheres refine and the exact level decides nothing. Terrains have no
/// sphere-tree.
class Dispatch {
public:
    explicit Dispatch(const Settings& settings)
        : obb_(wants_obbs(settings)), exact_(settings.exact),
          left_to_exact_(exact_ == ExactLevel::predicates && exact_runs(settings)), kinds_(wants_kinds(settings))
    {
    }

    /// Makes the trees that the refiner needs. Do not call it during traversals, unless there() returns true.
    Refiner of(Level level, ModelStore& models, Model& a, Model& b, std::uint32_t frame) const
    {
        const auto room = [&] {
            return !needs_trees(a, b) || (models.admit_obb_tree(a, frame) && models.admit_obb_tree(b, frame));
        };
        if (level == Level::refine) {
            const bool no_spheres = !a.has_sphere_tree() || !b.has_sphere_tree();
            if ((obb_ || no_spheres) && room()) return left_to_exact_ ? Refiner::none : Refiner::obbs;
            if (no_spheres || !a.unreadable().empty() || !b.unreadable().empty()) return Refiner::no_room;
            const double error = models.max_error(a, b);
            models.spheres(a, error), models.spheres(b, error);
            return Refiner::spheres;
        }
        if (!room()) return Refiner::no_room;
        return exact_ == ExactLevel::fcl ? Refiner::fcl : Refiner::exact;
    }

    /// True if the refine level leaves every pair whose trees exist to the exact level.
    bool leaves_to_exact() const { return obb_ && left_to_exact_; }

    /// True if of() would make no tree because all exist.
    bool there(Level level, const ModelStore& models, const Model& a, const Model& b) const
    {
        if (level == Level::refine && !obb_ && a.has_sphere_tree() && b.has_sphere_tree()) {
            const double error = models.max_error(a, b);
            return models.has_spheres(a, error) && models.has_spheres(b, error);
        }
        return !needs_trees(a, b) || (a.has_obb_tree() && b.has_obb_tree());
    }

private:
    bool needs_trees(const Model& a, const Model& b) const
    {
        const TreesNeeded trees = tests_for(a.kind(), b.kind()).trees;
        return trees == TreesNeeded::always || (trees == TreesNeeded::for_kinds && kinds_);
    }

    bool obb_;
    ExactLevel exact_;
    bool left_to_exact_; ///< OBB trees leave the pair to the exact level
    bool kinds_;
};

} // namespace oncollide

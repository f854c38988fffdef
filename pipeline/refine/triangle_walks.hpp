#pragma once
#include <oncollide/narrowphase/model.hpp>
#include <oncollide/narrowphase/walks/traversal.hpp>

namespace oncollide {

/// Traversals of two models' triangles, by kind: meshes, the cores of shapes, terrains. One thread's working memory.
class TriangleWalks {
public:
    /// Calls work(walk, a, b) with the trees of both, which must exist.
    template <class Work>
    auto with(ObbTree& a, ObbTree& b, Work work)
    {
        return work(meshes_, a, b);
    }
    template <class Work>
    auto with(Model& a, Model& b, Work work)
    {
        if (a.terrain() && b.terrain()) return work(terrains_, a.heights(), b.heights());
        if (a.terrain()) return work(terrain_first_, a.heights(), *b.obb_tree());
        if (b.terrain()) return work(terrain_second_, *a.obb_tree(), b.heights());
        return work(meshes_, *a.obb_tree(), *b.obb_tree());
    }

    Traversal::Counts counts() const
    {
        Traversal::Counts sum;
        each(*this, [&](const auto& walk) {
            const auto counts = walk.counts();
            sum.box_rows += counts.box_rows, sum.triangles += counts.triangles, sum.unsure += counts.unsure;
            sum.hints_held += counts.hints_held;
        });
        return sum;
    }
    void reset_counts()
    {
        each(*this, [](auto& walk) { walk.reset_counts(); });
    }

private:
    static void each(auto& walks, auto visit)
    {
        visit(walks.meshes_), visit(walks.terrain_first_), visit(walks.terrain_second_), visit(walks.terrains_);
    }

    Traversal meshes_;
    TraversalOf<TerrainTree, ObbTree> terrain_first_;
    TraversalOf<ObbTree, TerrainTree> terrain_second_;
    TraversalOf<TerrainTree, TerrainTree> terrains_;
};

} // namespace oncollide

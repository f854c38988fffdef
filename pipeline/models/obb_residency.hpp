#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include <oncollide/pipeline/models/chunk_residency.hpp>
#include <oncollide/pipeline/models/sphere_forest.hpp>

namespace oncollide {

/// The counters of OBB trees, which outlive the models.
struct ObbCounters {
    ChunkBudget chunks; ///< chunks of cooked files of any kind
    BoxTotals totals;   ///< totals of the trees that read no chunks
};

/// Which OBB trees exist, under the budgets of nodes and bytes.
class ObbResidency {
public:
    /// Keeps references to the settings, the counters and the sphere-trees, which share the budgets.
    ObbResidency(const Settings& settings, ObbCounters& counters, const SphereForest& spheres)
        : settings_(settings), counters_(counters), spheres_(spheres), prepared_(counters.chunks),
          chunks_(counters.chunks, prepared_)
    {
    }

    /// Call it for a new model before any other use of the model.
    void add(Model& model);
    /// Drops the trees of a model, which will be destroyed.
    void drop(Model& model);

    /// Ensures that a mesh or the core of a shape has its OBB tree, and a map or a terrain its own tree. False if a
    /// budget has no room for the fully grown tree, or the file of a cooked mesh cannot be read. Do not call it during
    /// a traversal of the model's tree, unless the tree exists already.
    bool admit(Model& model, std::uint32_t frame);
    /// The same regardless of budgets; not for a map or a terrain.
    ObbTree& tree(Model& model, std::uint32_t frame);

    const ChunkResidency& chunks() const { return chunks_; }
    /// As PreparedTrees::prepare.
    void look_ahead(std::vector<PrefetchPart> parts) { prepared_.prepare(std::move(parts)); }
    void begin(std::uint32_t frame) { prepared_.begin(frame); }

    /// Drops the trees that no pair has needed for `age` frames. Returns the number of nodes dropped; returns nothing,
    /// and drops nothing, if the prefetcher is busy.
    std::optional<std::uint64_t> collapse(std::uint32_t frame, std::uint32_t age);

    /// Upper bounds on the size of trees.
    struct Room {
        std::uint64_t nodes = 0;
        std::size_t bytes = 0;
    };
    const Room& reserved() const { return reserved_; } ///< the room for all trees, fully grown
    std::uint64_t nodes() const;
    std::size_t bytes() const; ///< bytes of the OBB trees, and of the trees of maps and terrains

private:
    static Room all_grown(const Model& model);
    void make(Model& model, const Room& room);
    std::uint64_t drop_tree(Model& model);

    const Settings& settings_;
    ObbCounters& counters_;
    const SphereForest& spheres_;
    std::vector<Model*> with_trees_; ///< models with an OBB tree
    Room reserved_;                  ///< the room for with_trees_
    PreparedTrees prepared_;         ///< its thread uses the models
    ChunkResidency chunks_;
};

} // namespace oncollide

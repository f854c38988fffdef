#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include <oncollide/narrowphase/gl/walk/mesh_walks.hpp>
#include <oncollide/narrowphase/model.hpp>

namespace oncollide {

/// The trees of one call's models on the GPU, by Model::number(), and the boxes that walks of the last call found
/// missing. Only models of the call are looked up, so none of them can be gone.
class GpuTrees {
public:
    static constexpr std::uint32_t none = 0xffffffffu;
    using Pair = std::array<std::uint32_t, 2>; ///< the numbers of a pair's models

    /// Forgets the trees of the last call.
    void begin() { ++call_, of_slots_.assign(of_slots_.size(), nullptr); }
    /// The number of the model's tree on the GPU, brought there if necessary; none: the CPU decides its pairs.
    /// @param number  the model's, so that the model itself is read only once a call
    std::uint32_t hold(MeshWalks& walks, std::uint32_t number, const Model* model, std::uint32_t frame)
    {
        if (number < by_number_.size() && by_number_[number].call == call_) return by_number_[number].tree;
        return hold_first(walks, number, *model, frame);
    }

    /// Notes the boxes that a batch of this call missed.
    void miss(std::span<const WantedNode> wanted);
    /// Grows the boxes that were missed in the last call, of models that take part in this one.
    void grow_missed(int threads);

private:
    std::uint32_t hold_first(MeshWalks& walks, std::uint32_t number, const Model& model, std::uint32_t frame);

    struct Held {
        std::uint64_t call = 0;
        std::uint32_t tree = none;
    };
    struct Missed {
        std::uint32_t identity; ///< ObbTree::identity()
        WantedNode box;
    };

    std::uint64_t call_ = 0;
    std::vector<Held> by_number_;
    std::vector<ObbTree*> of_slots_; ///< by number on the GPU; null: not in this call
    std::vector<Missed> missed_;
};

} // namespace oncollide

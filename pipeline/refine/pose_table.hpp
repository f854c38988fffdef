#pragma once
#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <vector>

#include <oncollide/narrowphase/gl/walk/mesh_walks.hpp>

namespace oncollide {

/// The different poses of a batch's pairs, with the tree of the model at each.
class PoseTable {
public:
    struct Row {
        std::uint32_t pose;
        std::optional<std::uint32_t> tree; ///< none: the CPU decides its pairs
    };

    /// @param sides  an upper bound of the calls of row() that follow
    void clear(std::size_t sides)
    {
        poses_.clear(), rows_.clear(), last_[0] = last_[1] = empty;
        slots_.assign(std::bit_ceil(2 * sides + 2), empty);
    }
    /// The row of a model at a pose, which stay where they are. hold() returns the model's tree the first time.
    /// @param side  0 for the first body of a pair, 1 for the second one
    template <class Hold>
    Row row(unsigned side, const void* model, const Eigen::Isometry3d& pose, Hold hold)
    {
        // Pairs come in the order of their first bodies, and columns of pairs often have one pose on one side.
        std::uint32_t& last = last_[side];
        if (last != empty && holds(last, model, pose)) return rows_[last].row;
        const std::size_t mask = slots_.size() - 1;
        std::size_t at = (reinterpret_cast<std::uintptr_t>(&pose) >> 4) * 0x9e3779b97f4a7c15ull >> 20 & mask;
        for (; slots_[at] != empty; at = (at + 1) & mask)
            if (rows_[slots_[at]].model == model && rows_[slots_[at]].at == &pose) return rows_[last = slots_[at]].row;
        slots_[at] = last = static_cast<std::uint32_t>(rows_.size());
        rows_.push_back({model, &pose, {static_cast<std::uint32_t>(poses_.size()), hold()}});
        poses_.emplace_back(pose);
        return rows_.back().row;
    }
    std::span<const MeshWalkPose> poses() const { return poses_; }

private:
    static constexpr std::uint32_t empty = 0xffffffffu;
    struct Known {
        const void* model;
        const Eigen::Isometry3d* at;
        Row row;
    };
    bool holds(std::uint32_t number, const void* model, const Eigen::Isometry3d& pose) const
    {
        const Known& known = rows_[number];
        return known.model == model &&
               (known.at == &pose || std::memcmp(known.at->data(), pose.data(), 16 * sizeof(double)) == 0);
    }

    std::vector<MeshWalkPose> poses_;
    std::vector<Known> rows_;
    std::vector<std::uint32_t> slots_; ///< a hash table of rows
    std::uint32_t last_[2];            ///< by side: the row of the last call
};

} // namespace oncollide

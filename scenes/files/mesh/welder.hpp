#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/base/memory/large_vector.hpp>
#include <oncollide/scenes/files/mesh/mesh_source.hpp>

namespace oncollide {

/// Gives points at equal positions one number, in order of first use. Takes 37 to 50 bytes per point, and 256 kB.
/// Private to scenes.
class Welder {
public:
    std::uint32_t add(const Eigen::Vector3d& point)
    {
        std::uint32_t number = 0;
        add({&point, 1}, &number);
        return number;
    }
    /// Batches wait less for memory.
    void add(std::span<const Eigen::Vector3d> points, std::uint32_t* numbers);
    std::size_t size() const { return points_.size(); }
    std::vector<Eigen::Vector3d> take() { return std::move(points_); }

private:
    struct Slot {
        std::uint32_t hash, number;
    };
    std::uint32_t find_or_add(const Eigen::Vector3d& point, std::uint32_t hash);
    void make_slots(std::size_t count);

    std::vector<Eigen::Vector3d> points_;
    LargeVector<Slot> slots_;  ///< the count is a power of two; at most five in eight are in use
    std::vector<Slot> recent_; ///< by hash, the last point found: nearly all corners are found here at the first probe
};

} // namespace oncollide

#pragma once
#include <optional>
#include <span>
#include <vector>

#include <oncollide/narrowphase/triangle_kernel.hpp>
#include <oncollide/narrowphase/triangle_test.hpp>

namespace oncollide {

/// Triangles to ask one after another whether they meet single ones. Answers equal those of triangles_meet, one by one,
/// on every instruction set: boxes and certified signs decide eight at a time, what they leave open is tested alone.
class TriangleSet {
public:
    TriangleSet() = default;
    /// Cost: about 10 ns a triangle.
    explicit TriangleSet(std::span<const TrianglePoints> triangles) { assign(triangles); }
    /// Allocates nothing once the set has held as many.
    void assign(std::span<const TrianglePoints> triangles);

    std::span<const TrianglePoints> triangles() const { return triangles_; }

    /// The lowest number of a triangle that meets `triangle`. Cost: below 1 ns a triangle whose box is apart, about 10
    /// ns each of the others, until it is found.
    std::optional<std::uint32_t> first_meeting(const TrianglePoints& triangle) const;

    /// The numbers of all that meet `triangle`, ascending, to `out`, overwritten.
    void all_meeting(const TrianglePoints& triangle, std::vector<std::uint32_t>& out) const;

private:
    TriangleQuery query_of(const TrianglePoints& triangle) const;

    std::vector<TrianglePoints> triangles_;
    std::vector<BoxBlock> blocks_;
    Eigen::Vector3d origin_ = Eigen::Vector3d::Zero(); ///< boxes are relative to it
};

} // namespace oncollide

#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include <oncollide/base/aabb.hpp>
#include <oncollide/base/cpu_features.hpp>
#include <oncollide/narrowphase/boxes/box_fit_kernel.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide {

/// The build of the kernel for this processor.
inline const BoxFitKernel& box_fit_kernel()
{
    static const BoxFitKernel kernel = ONCOLLIDE_CHOOSE_TO_AVX2(box_fit_kernel);
    return kernel;
}

/// Triangles that boxes are fitted around, in columns.
class TriangleColumns {
public:
    TriangleColumns() = default;
    explicit TriangleColumns(const TrianglePoints& triangle) { resize(1), set(0, triangle); }

    /// The triangles are to be set then, the last one last.
    void resize(std::size_t size)
    {
        size_ = size, number_ = (size + 3) / 4;
        if (fours_.size() < number_) fours_.resize(number_);
    }
    void set(std::size_t i, const TrianglePoints& triangle)
    {
        for (std::size_t lane = i % 4; lane < (i + 1 == size_ ? 4 : i % 4 + 1); ++lane) // the last one fills its four
            for (int c = 0; c < 3; ++c)
                for (int axis = 0; axis < 3; ++axis)
                    fours_[i / 4].corners[c][axis][lane] = triangle[std::size_t(c)][axis];
    }
    std::size_t size() const { return size_; }
    std::span<const FourTriangles> fours() const { return std::span(fours_).first(number_); }
    TrianglePoints first() const;

private:
    std::vector<FourTriangles> fours_; ///< the first number_ are in use
    std::size_t size_ = 0, number_ = 0;
};

/// What the triangles take along each of the columns of `axes`.
Aabb extent_along(const Eigen::Matrix3d& axes, const TriangleColumns& triangles);

/// Axes, the columns of a rotation, along the directions in which the triangles' surface spreads most and least; for
/// one triangle, along its normal and its longest side. Source: Gottschalk, Lin and Manocha, "OBBTree", SIGGRAPH 1996.
/// @param triangles  2^14 at most
/// @param bounds     a box along the axes of the frame that is nearly theirs
Eigen::Matrix3d fitted_axes(const TriangleColumns& triangles, const Aabb& bounds);

} // namespace oncollide

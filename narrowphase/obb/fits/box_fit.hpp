#pragma once
#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include <oncollide/base/aabb.hpp>
#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/narrowphase/obb/fits/box_fit_kernel.hpp>

namespace oncollide {

/// The build of the kernel for this processor.
inline const BoxFitKernel& box_fit_kernel()
{
    static const BoxFitKernel kernel = ONCOLLIDE_CHOOSE_TO_AVX2(box_fit_kernel);
    return kernel;
}

/// The input of box fitting: triangles in columns.
class TriangleColumns {
public:
    TriangleColumns() = default;
    explicit TriangleColumns(const TrianglePoints& triangle)
    {
        assign(1, [&](std::size_t) -> const TrianglePoints& { return triangle; });
    }

    /// Takes the triangles corners(0) to corners(size - 1). The last triangle fills the last group of four.
    void assign(std::size_t size, auto corners)
    {
        size_ = size, number_ = (size + 3) / 4;
        if (fours_.size() < number_) fours_.resize(number_);
        for (std::size_t n = 0; n < number_; ++n) {
            const TrianglePoints* four[4];
            for (std::size_t lane = 0; lane < 4; ++lane) four[lane] = &corners(std::min(4 * n + lane, size - 1));
            for (std::size_t c = 0; c < 3; ++c)
                for (int axis = 0; axis < 3; ++axis)
                    for (std::size_t lane = 0; lane < 4; ++lane)
                        fours_[n].corners[c][axis][lane] = (*four[lane])[c][axis];
        }
    }
    std::size_t size() const { return size_; }
    std::span<const FourTriangles> fours() const { return std::span(fours_).first(number_); }
    TrianglePoints first() const;

private:
    std::vector<FourTriangles> fours_; ///< the first number_ are in use
    std::size_t size_ = 0, number_ = 0;
};

/// The extent of the triangles along each column of `axes`.
Aabb extent_along(const Eigen::Matrix3d& axes, const TriangleColumns& triangles);

/// Axes, the columns of a rotation, along the directions of largest and smallest spread of the triangles' surface; for
/// one triangle, along its normal and its longest side or, with a right angle, a leg. Source: Gottschalk, Lin and
/// Manocha, "OBBTree", SIGGRAPH 1996.
/// @param triangles  at most 2^14
/// @param bounds     a box along the axes of the frame, nearly the bounds of the triangles
Eigen::Matrix3d fitted_axes(const TriangleColumns& triangles, const Aabb& bounds);

} // namespace oncollide

#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

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

/// The triangles of up to eight boxes that are fitted together. Working memory.
class BoxTriangles {
public:
    static constexpr std::size_t most = 1 << 14; ///< triangles of a box

    /// @param counts   triangles of each box; 0: no box
    /// @param corners  corners(k, i) returns the corners of triangle i of box k
    void assign(const std::array<std::uint32_t, 8>& counts, auto corners)
    {
        start(counts);
        for (std::uint32_t row = 0; row < number_; ++row)
            for (unsigned k = 0; k < 8; ++k)
                if (counts[k] > 1) put(k, row, corners(k, row < counts[k] ? row : 0));
        for (unsigned k = 0; k < 8; ++k)
            if (counts[k] == 1) put_alone(k, corners(k, 0u));
    }
    StoredBoxes fit(const StoredFrame& frame) const
    {
        StoredBoxes boxes;
        box_fit_kernel().fit(rows_.get(), counts_, frame, boxes);
        return boxes;
    }

private:
    void start(const std::array<std::uint32_t, 8>& counts);
    void put_alone(unsigned k, TrianglePoints triangle);
    void put(unsigned k, std::uint32_t row, const TrianglePoints& triangle)
    {
        for (std::size_t c = 0; c < 3; ++c)
            for (int axis = 0; axis < 3; ++axis) rows_[row].corners[c][axis][k] = triangle[c][axis];
    }

    std::unique_ptr<EightTriangles[]> rows_; ///< not initialised, which would take longer than to fill them
    std::uint32_t counts_[8];
    std::uint32_t number_ = 0, room_ = 0; ///< rows in use, and made
};

/// Axes of the box around one triangle, the columns of a rotation: along its longest side or, with a right angle, a
/// leg, and along its normal. They do not depend on the order of its corners.
Eigen::Matrix3d axes_of_triangle(TrianglePoints triangle);

} // namespace oncollide

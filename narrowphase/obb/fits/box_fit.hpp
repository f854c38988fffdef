#pragma once
#include <algorithm>
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

/// Fits up to eight boxes, each around triangles of its own. Working memory.
class BoxFit {
public:
    static constexpr std::uint32_t most = 1 << 14; ///< triangles of a box
    /// Boxes of more triangles are fitted one by one: they then stay in a cache, and no rows are empty because another
    /// box is smaller.
    static constexpr std::uint32_t most_together = 256;

    /// @param counts   triangles of each box; 0: no box
    /// @param corners  corners(k, i) returns the corners of triangle i of box k
    StoredBoxes fit(const std::array<std::uint32_t, 8>& counts, const StoredFrame& frame, auto corners)
    {
        std::uint32_t together[8];
        for (unsigned k = 0; k < 8; ++k) together[k] = counts[k] <= most_together ? counts[k] : 0;
        pack(together, corners);
        StoredBoxes boxes;
        box_fit_kernel().fit(rows_.get(), together, frame, boxes);
        for (unsigned k = 0; k < 8; ++k)
            if (counts[k] > most_together) {
                start((counts[k] + 7) / 8);
                for (std::uint32_t i = 0; i < 8 * number_; ++i) put(i % 8, i / 8, corners(k, i < counts[k] ? i : 0));
                fit_one(k, counts[k], frame, boxes);
            }
        return boxes;
    }

private:
    void pack(const std::uint32_t (&counts)[8], auto corners)
    {
        start(*std::ranges::max_element(counts));
        for (std::uint32_t row = 0; row < number_; ++row)
            for (unsigned k = 0; k < 8; ++k)
                if (counts[k] > 1) put(k, row, corners(k, row < counts[k] ? row : 0));
        for (unsigned k = 0; k < 8; ++k)
            if (counts[k] == 1) put_alone(k, corners(k, 0u));
    }
    void start(std::uint32_t rows);
    void fit_one(unsigned k, std::uint32_t count, const StoredFrame& frame, StoredBoxes& boxes) const;
    void put_alone(unsigned k, TrianglePoints triangle);
    void put(unsigned k, std::uint32_t row, const TrianglePoints& triangle)
    {
        for (std::size_t c = 0; c < 3; ++c)
            for (int axis = 0; axis < 3; ++axis) rows_[row].corners[c][axis][k] = triangle[c][axis];
    }

    std::unique_ptr<EightTriangles[]> rows_; ///< not initialised, which would take longer than to fill them
    std::uint32_t number_ = 0, room_ = 0;    ///< rows in use; rows allocated
};

/// Axes of the box around one triangle, the columns of a rotation: along its longest side or, with a right angle, a
/// leg, and along its normal. They do not depend on the order of its corners.
Eigen::Matrix3d axes_of_triangle(TrianglePoints triangle);

} // namespace oncollide

#pragma once
#include <array>
#include <cstdint>

#include <oncollide/base/aabb.hpp>

namespace oncollide {

// The corners of a box, by number: bit 0 is set for the larger x, bit 1 for y, bit 2 for z. Private to the library.

inline Eigen::Vector3d corner_of(const Aabb& box, unsigned corner)
{
    return {corner & 1 ? box.max.x() : box.min.x(), corner & 2 ? box.max.y() : box.min.y(),
            corner & 4 ? box.max.z() : box.min.z()};
}

/// The surface with outward orientation: two triangles per face; faces of z, y and x, the low face first.
constexpr std::array<std::array<std::uint32_t, 3>, 12> box_faces{{{0, 2, 1},
                                                                  {1, 2, 3},
                                                                  {4, 5, 6},
                                                                  {5, 7, 6},
                                                                  {0, 1, 4},
                                                                  {1, 5, 4},
                                                                  {2, 6, 3},
                                                                  {3, 6, 7},
                                                                  {0, 4, 2},
                                                                  {2, 4, 6},
                                                                  {1, 3, 5},
                                                                  {3, 7, 5}}};

} // namespace oncollide

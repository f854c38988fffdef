#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/base/random.hpp>
#include <oncollide/broadphase/broad_phase.hpp>

namespace oncollide {

/// Bodies as boxes alone.
struct Boxes {
    std::vector<Aabb> boxes;
    std::vector<std::uint8_t> is_static;
    std::vector<std::uint32_t> layers, masks, all;

    void add(const Eigen::Vector3d& min, const Eigen::Vector3d& max, bool fixed = false, std::uint32_t layer = 1,
             std::uint32_t mask = ~0u)
    {
        Aabb box;
        box.min = min, box.max = max;
        all.push_back(static_cast<std::uint32_t>(boxes.size()));
        boxes.push_back(box), is_static.push_back(fixed), layers.push_back(layer), masks.push_back(mask);
    }
    BodyFilter filter() const { return {is_static, layers, masks}; }

    std::vector<BodyPair> truth(double margin) const
    {
        std::vector<BodyPair> pairs;
        for (std::uint32_t a = 0; a < boxes.size(); ++a)
            for (std::uint32_t b = a + 1; b < boxes.size(); ++b) {
                const bool apart = ((boxes[a].min - boxes[b].max).array() > margin).any() ||
                                   ((boxes[b].min - boxes[a].max).array() > margin).any();
                if (!apart && filter().allows(a, b)) pairs.push_back({a, b});
            }
        return pairs;
    }
};

inline Boxes random_boxes(std::uint32_t count, double side, double static_share, std::uint64_t seed,
                          const Eigen::Vector3d& at)
{
    Boxes scene;
    for (std::uint32_t i = 0; i < count; ++i) {
        Eigen::Vector3d centre, half;
        for (std::uint64_t k = 0; k < 3; ++k)
            centre[static_cast<int>(k)] = side * u01(seed, i, k),
            half[static_cast<int>(k)] = 0.25 + 0.25 * u01(seed, i, 3 + k);
        if (i % 50 == 0) half *= 8;
        scene.add(at + centre - half, at + centre + half, u01(seed, i, 6) < static_share, 1u << (i % 3),
                  i % 7 == 0 ? 0b011u : ~0u);
    }
    return scene;
}

} // namespace oncollide

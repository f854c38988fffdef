#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/broadphase/broad_phase.hpp>

namespace oncollide {

/// Bodies given by AABBs only.
struct Boxes {
    std::vector<Aabb> boxes;
    std::vector<std::uint8_t> is_static;
    std::vector<std::uint32_t> layers, masks, groups, all;

    void add(const Eigen::Vector3d& min, const Eigen::Vector3d& max, bool static_body = false, std::uint32_t layer = 1,
             std::uint32_t mask = ~0u, std::uint32_t group = 0)
    {
        Aabb box;
        box.min = min, box.max = max;
        all.push_back(static_cast<std::uint32_t>(boxes.size()));
        boxes.push_back(box), this->is_static.push_back(static_body);
        layers.push_back(layer), masks.push_back(mask), groups.push_back(group);
    }
    void step(std::uint32_t body, const Eigen::Vector3d& by) { boxes[body].min += by, boxes[body].max += by; }
    BodyColumns columns() const { return {boxes, layers, masks, groups}; }
    void add_to(BroadPhase& broad) const
    {
        std::vector<std::uint32_t> resting, moving;
        for (std::uint32_t body : all) (is_static[body] ? resting : moving).push_back(body);
        broad.add(resting, true), broad.add(moving);
    }

    /// Shares no code with any broad phase.
    std::vector<BodyPair> truth(double margin = 0) const
    {
        std::vector<BodyPair> pairs;
        for (std::uint32_t a = 0; a < boxes.size(); ++a)
            for (std::uint32_t b = a + 1; b < boxes.size(); ++b) {
                const bool apart = ((boxes[a].min - boxes[b].max).array() > margin).any() ||
                                   ((boxes[b].min - boxes[a].max).array() > margin).any();
                if (apart || (is_static[a] && is_static[b]) || (groups[a] && groups[a] == groups[b])) continue;
                if ((layers[a] & masks[b]) && (layers[b] & masks[a])) pairs.push_back({a, b});
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
                  i % 7 == 0 ? 0b011u : ~0u, i % 5 == 0 ? i % 4 : 0);
    }
    return scene;
}

inline Eigen::Vector3d random_step(std::uint64_t frame, std::uint32_t body, double most)
{
    return most * (Eigen::Vector3d(u01(frame, body, 1), u01(frame, body, 2), u01(frame, body, 3)).array() - 0.5);
}

using Bodies = std::vector<std::uint32_t>;
using Pairs = std::vector<BodyPair>;

inline Pairs find(BroadPhase& broad, const Boxes& scene, bool whole = false)
{
    const auto pairs = broad.find_pairs(scene.columns(), whole);
    return {pairs.begin(), pairs.end()};
}

/// The pairs of a new broad phase with all bodies of the scene.
inline Pairs find_anew(std::unique_ptr<BroadPhase> broad, const Boxes& scene)
{
    scene.add_to(*broad);
    return find(*broad, scene);
}

} // namespace oncollide

#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include <oncollide/pipeline/world.hpp>

namespace oncollide {

using Slots = std::pair<std::uint32_t, std::uint32_t>;
/// The pairs that are not separate.
inline std::map<Slots, PairResult> found_in(const FrameView& frame)
{
    std::map<Slots, PairResult> results;
    for (const PairResult& r : frame.pairs)
        if (r.verdict != Verdict::separate) results[{r.a.slot, r.b.slot}] = r;
    return results;
}

/// True if the verdict is right for this distance.
inline void expect_true(const PairResult& r, const Distance& d, const Settings& settings, const std::string& when)
{
    const double rounding = 1e-6;
    if (r.verdict == Verdict::separate) {
        EXPECT_GT(d.upper + rounding, settings.clearance) << when;
    } else {
        EXPECT_LE(d.lower, r.bound + rounding) << when;
    }
}

/// The same contacts of two bodies, bit for bit.
inline void expect_same_contacts(const World& now, const World& expected, const PairResult& pair,
                                 const std::string& when, std::size_t& contacts)
{
    const auto found = now.pairs().contacts(pair.a, pair.b),
               same = expected.pairs().contacts(expected.bodies().at(pair.a.slot), expected.bodies().at(pair.b.slot));
    ASSERT_EQ(found.size(), same.size()) << when;
    for (std::size_t k = 0; k < found.size(); ++k) {
        ASSERT_EQ(found[k].a, same[k].a) << when;
        ASSERT_EQ(found[k].b, same[k].b) << when;
        ASSERT_EQ(found[k].ends, same[k].ends) << when;
        ASSERT_EQ(found[k].normal_a, same[k].normal_a) << when;
    }
    contacts += found.size();
}

/// The same bits where surfaces meet. Where they do not, regions come from distances: of parts that are equally near,
/// another one may be found first, with another normal.
inline void expect_same(const FrameManifolds& now, const FrameManifolds& expected, const std::string& when)
{
    ASSERT_EQ(now.offsets, expected.offsets) << when;
    ASSERT_EQ(now.complete, expected.complete) << when;
    for (std::size_t i = 0; i < now.regions.size(); ++i) {
        const ManifoldRegion &r = now.regions[i], &e = expected.regions[i];
        ASSERT_EQ(r.kind, e.kind) << when;
        const bool by_distance = r.kind == RegionKind::enclosed || r.kind == RegionKind::near;
        ASSERT_NEAR(r.depth_lower, e.depth_lower, by_distance ? 1e-11 : 0) << when;
        if (by_distance) continue;
        ASSERT_EQ(r.normal, e.normal) << when;
        ASSERT_EQ(r.depth_upper, e.depth_upper) << when;
        ASSERT_EQ(r.count, e.count) << when;
        for (std::uint32_t k = 0; k < r.count; ++k) {
            const ManifoldPoint &p = now.points[r.first + k], &q = expected.points[e.first + k];
            ASSERT_EQ(p.point_a, q.point_a) << when;
            ASSERT_EQ(p.point_b, q.point_b) << when;
            ASSERT_EQ(p.depth, q.depth) << when;
            ASSERT_EQ(p.normal, q.normal) << when;
        }
    }
}

} // namespace oncollide

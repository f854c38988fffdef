// Queries of broad phases; invalid calls are refused.
#include <array>
#include <cmath>
#include <limits>
#include <thread>

#include <oncollide/base/numbers/random.hpp>

#include "every_broad_phase.hpp"

namespace oncollide::broad_phase_test {
namespace {

TEST_P(EveryBroadPhase, AnswersQueriesFromManyThreadsAtOnce)
{
    Boxes scene = random_boxes(4000, 25, 0.5, 31, {1e6, 0, -1e6});
    const auto broad = make();
    scene.add_to(*broad);
    broad->remove(Bodies{17});
    std::vector<Aabb> boxes;
    for (std::uint64_t k = 0; k < 200; ++k) {
        const Eigen::Vector3d at(1e6 + 30 * u01(9, k, 0), 30 * u01(9, k, 1), -1e6 + 30 * u01(9, k, 2));
        boxes.emplace_back();
        boxes.back().add(at), boxes.back().add(Eigen::Vector3d(at.array() + u01(9, k, 3) * 3));
    }
    std::vector<AabbHit> expected;
    for (std::uint32_t k = 0; k < boxes.size(); ++k)
        for (std::uint32_t body : scene.all) {
            Aabb grown = boxes[k];
            grown.min.array() -= margin_, grown.max.array() += margin_;
            if (body != 17 && grown.overlaps(scene.boxes[body])) expected.push_back({k, body});
        }
    EXPECT_GT(expected.size(), 500u);
    broad->take_in(scene.columns());
    constexpr std::size_t threads = 4;
    std::array<std::vector<AabbHit>, threads> hits;
    std::vector<std::thread> running;
    for (std::vector<AabbHit>& mine : hits)
        running.emplace_back([&] {
            for (int round = 0; round < 20; ++round) broad->query(scene.columns(), boxes, mine);
        });
    for (std::thread& thread : running) thread.join();
    for (const std::vector<AabbHit>& mine : hits) EXPECT_EQ(mine, expected);
    Pairs pairs = truth(scene);
    std::erase_if(pairs, [](BodyPair p) { return p.a == 17 || p.b == 17; });
    EXPECT_EQ(find(*broad, scene), pairs) << "a query forgets no pair";
    broad->query(scene.columns(), {}, hits[0]);
    EXPECT_TRUE(hits[0].empty());
}

/// The fractions at which a segment enters and leaves a box overlap, with an allowance for rounding.
bool crosses(const Segment& s, const Aabb& box, double allowance)
{
    double begin = 0, end = 1;
    for (int k = 0; k < 3; ++k) {
        const long double from = s.from[k], along = static_cast<long double>(s.to[k]) - from;
        const long double low = box.min[k] - allowance - from, high = box.max[k] + allowance - from;
        if (along == 0) {
            if (low > 0 || high < 0) return false;
            continue;
        }
        begin = std::max(begin, static_cast<double>(std::min(low / along, high / along)));
        end = std::min(end, static_cast<double>(std::max(low / along, high / along)));
    }
    return begin <= end;
}

TEST_P(EveryBroadPhase, FindsAllBoxesThatASegmentMeets)
{
    for (const double far : {0.0, 1e6, 1e25}) {
        Boxes scene = random_boxes(1500, 18, 0.5, 31, {far, 0, -far});
        if (far > 1e9) // smaller boxes would be points
            for (Aabb& box : scene.boxes) box.max += 0.01 * far * Eigen::Vector3d(1, 2, 3);
        const auto broad = make();
        scene.add_to(*broad);
        broad->remove(Bodies{17});
        find(*broad, scene);
        Bodies moved;
        for (std::uint32_t body = 0; body < 300; ++body) moved.push_back(20 + body), scene.step(20 + body, {3, -2, 1});
        broad->move(moved);
        std::vector<Segment> segments;
        const auto at = [&](std::uint64_t k, std::uint64_t c, double reach) {
            return Eigen::Vector3d(far + reach * u01(k, c, 0), reach * u01(k, c, 1), -far + reach * u01(k, c, 2));
        };
        for (std::uint64_t k = 0; k < 80; ++k) {
            const Eigen::Vector3d from = at(k, 5, 30), corner = scene.boxes[k].max;
            segments.push_back({from, at(k, 6, 30)});
            segments.push_back({from, from});
            segments.push_back({corner, corner + Eigen::Vector3d(k % 2 ? 40 : -40, 0, 0)});
            segments.push_back({corner + Eigen::Vector3d(1, -1, 0), corner + Eigen::Vector3d(-1, 1, 0)});
            segments.push_back({from - 1e7 * (from - at(k, 7, 30)), from});
        }
        std::vector<AabbHit> hits;
        broad->take_in(scene.columns());
        broad->query_segments(scene.columns(), segments, hits);
        EXPECT_TRUE(std::ranges::is_sorted(hits));
        std::size_t found = 0, needed = 0;
        for (std::uint32_t k = 0; k < segments.size(); ++k) {
            const double largest = std::max(segments[k].from.cwiseAbs().maxCoeff(), 2 * far);
            for (std::uint32_t body : scene.all) {
                Aabb grown = scene.boxes[body];
                grown.min.array() -= margin_, grown.max.array() += margin_;
                const bool there = found < hits.size() && hits[found] == AabbHit{k, body};
                found += there;
                if (body == 17) {
                    EXPECT_FALSE(there);
                } else if (crosses(segments[k], grown, 0)) {
                    EXPECT_TRUE(there) << far << " " << k << " " << body;
                    ++needed;
                } else if (there) {
                    EXPECT_TRUE(crosses(segments[k], grown, 0x1p-40 * largest)) << far << " " << k << " " << body;
                }
            }
        }
        EXPECT_EQ(found, hits.size());
        EXPECT_GT(needed, 500u);
    }
}

/// One thread: the share of each of several threads, and so its memory, is not deterministic.
TEST_P(EveryBroadPhase, RefusesWhatMakesNoSense)
{
    Boxes scene = random_boxes(300, 10, 0.5, 3, {0, 0, 0});
    const auto broad = make();
    scene.add_to(*broad);
    const Pairs pairs = find(*broad, scene);
    const auto names = [&](const char* what, auto&& work) {
        const std::string text = message_of(work);
        EXPECT_NE(text.find(what), std::string::npos) << text;
    };
    names("body 7", [&] { broad->add(Bodies{7}); });
    names("body 300", [&] { broad->move(Bodies{3, 300}); });
    names("body 4000000000", [&] { broad->remove(Bodies{4000000000u}); });
    names("body 301", [&] { broad->make_static(Bodies{301}); });
    names("body 302", [&] { broad->make_dynamic(Bodies{302}); });
    names("margin", [&] { GetParam().make({.margin = -1}); });
    names("margin", [&] { GetParam().make({.margin = std::nan("")}); });
    names("threads", [&] { GetParam().make({.threads = 0}); });
    names("columns", [&] { broad->find_pairs({std::span(scene.boxes).first(299)}); });
    names("columns", [&] { broad->find_pairs({scene.boxes, scene.layers, {}}); });
    names("columns", [&] { broad->find_pairs({.boxes = scene.boxes, .groups = std::span(scene.groups).first(9)}); });
    std::vector<AabbHit> hits;
    const Aabb empty;
    names("query 0", [&] { broad->query(scene.columns(), std::span(&empty, 1), hits); });
    const Segment bad{{0, 0, 0}, {0, std::nan(""), 0}};
    names("query 0", [&] { broad->query_segments(scene.columns(), std::span(&bad, 1), hits); });
    broad->move(Bodies{3});
    names("take_in", [&] { broad->query(scene.columns(), std::span(scene.boxes).first(1), hits); });
    EXPECT_EQ(find(*broad, scene), pairs) << "nothing was lost";
}

TEST_P(EveryBroadPhase, RefusesBoxesThatAreNotFiniteNamesTheBodyAndLosesNothing)
{
    const double infinity = std::numeric_limits<double>::infinity();
    for (const std::uint32_t first : {0u, 100u, 250u}) // all bodies new, some, few
        for (const double bad : {infinity, -infinity, std::nan(""), 1e31}) {
            Boxes scene = random_boxes(300, 12, 0, 1, {0, 0, 0});
            const auto broad = make();
            broad->add(std::span(scene.all).first(first));
            broad->take_in(scene.columns());
            broad->add(std::span(scene.all).subspan(first));
            if (first > 50) broad->move(Bodies{50});
            for (const std::uint32_t body : {50u, 280u}) {
                const double good = scene.boxes[body].max.y();
                scene.boxes[body].max.y() = bad;
                for (int round = 0; round < 2; ++round) {
                    const std::string text = message_of([&] { find(*broad, scene); });
                    EXPECT_NE(text.find("body " + std::to_string(body)), std::string::npos) << text;
                }
                scene.boxes[body].max.y() = good;
            }
            EXPECT_EQ(find(*broad, scene), truth(scene));
            scene.boxes[123].max.y() = 1e29;
            broad->move(Bodies{123});
            EXPECT_EQ(find(*broad, scene), truth(scene));
        }
}

} // namespace
} // namespace oncollide::broad_phase_test

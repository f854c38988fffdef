#include <gtest/gtest.h>

#include <limits>

#include <oncollide/broadphase/cpu_features.hpp>
#include <oncollide/narrowphase/triangle_set.hpp>

#include "triangle_families.hpp"

namespace oncollide {
namespace {

struct Kernel {
    std::string name;
    FindPairs* find;
};

std::vector<Kernel> kernels()
{
    std::vector<Kernel> all{{"baseline", baseline::find_pairs()}};
    if (instruction_set() >= InstructionSet::avx2) all.push_back({"avx2", avx2::find_pairs()});
    if (instruction_set() >= InstructionSet::avx512) all.push_back({"avx512", avx512::find_pairs()});
    return all;
}

using Triangles = std::vector<TrianglePoints>;

/// What the kernel finds among all pairs, its boxes switched off.
std::vector<FoundPair> found_by(FindPairs* find, const Triangles& a, const Triangles& b)
{
    constexpr float infinity = std::numeric_limits<float>::infinity();
    FloatBox everywhere;
    BoxBlock block, last;
    for (int axis = 0; axis < 3; ++axis) {
        everywhere.lo[axis] = -infinity, everywhere.hi[axis] = infinity;
        for (std::size_t lane = 0; lane < 8; ++lane) {
            block.lo[axis][lane] = -infinity, block.hi[axis][lane] = infinity;
            last.lo[axis][lane] = lane <= (b.size() - 1) % 8 ? -infinity : std::numeric_limits<float>::quiet_NaN();
            last.hi[axis][lane] = infinity;
        }
    }
    const std::vector<FloatBox> boxes(a.size(), everywhere);
    std::vector<BoxBlock> blocks((b.size() + 7) / 8, block);
    blocks.back() = last;
    const TrianglesToPair lists{boxes.data(),  a.front()[0].data(), static_cast<std::uint32_t>(a.size()),
                              blocks.data(), b.front()[0].data(), static_cast<std::uint32_t>(blocks.size())};
    std::vector<FoundPair> all;
    FoundPair part[20];
    for (PairCursor cursor; cursor.a < lists.count_a;) {
        const std::uint32_t count = find(lists, cursor, false, part, 20);
        EXPECT_LE(count, 20u);
        all.insert(all.end(), part, part + count);
    }
    return all;
}

std::vector<TriangleMeeting> truth_of(const Triangles& a, const Triangles& b)
{
    std::vector<TriangleMeeting> all;
    for (std::uint32_t i = 0; i < a.size(); ++i)
        for (std::uint32_t j = 0; j < b.size(); ++j)
            if (triangles_meet(a[i], b[j])) all.push_back({i, j});
    return all;
}

/// `count` pairs, mapped, a[i] against b[i].
std::pair<Triangles, Triangles> lists_of(const TriangleFamily& family, std::size_t count, const Eigen::Matrix3d& map)
{
    GridPoints random(11);
    std::pair<Triangles, Triangles> lists;
    for (std::size_t i = 0; i < count; ++i) {
        const auto [a, b] = moved(family.make(random), map, Eigen::Vector3d::Zero());
        lists.first.push_back(a), lists.second.push_back(b);
    }
    return lists;
}

/// Rotations, scales, and axes so different that some products of coordinates underflow or overflow and others do not.
std::vector<Eigen::Matrix3d> maps()
{
    std::vector<Eigen::Matrix3d> all;
    for (const double scale : {1.0, 1e-9, 1e9, 0x1p-900, 0x1p-1060, 0x1p500, 0x1p970}) {
        all.push_back(scale * Eigen::Matrix3d::Identity());
        all.push_back(scale * GridPoints(12).rotation());
    }
    for (const auto& [one, two] : {std::pair(290, -550), std::pair(-340, 600)})
        for (int axis = 0; axis < 3; ++axis) {
            Eigen::Vector3d scale = Eigen::Vector3d::Constant(std::ldexp(1, two));
            scale[axis] = std::ldexp(1, one);
            all.emplace_back(scale.asDiagonal());
        }
    return all;
}

/// Is it of a scale that the filter is made for?
bool ordinary(const Eigen::Matrix3d& map)
{
    return map.norm() < 1e20 && map.norm() > 1e-20;
}

class EverySet : public testing::TestWithParam<TriangleFamily> {};

TEST_P(EverySet, FindsWhatTheScalarTestFindsOnEveryInstructionSet)
{
    for (const Eigen::Matrix3d& map : maps())
        for (const std::size_t count :
             ordinary(map) ? std::vector<std::size_t>{21, 45} : std::vector<std::size_t>{13}) {
            const auto [a, b] = lists_of(GetParam(), count, map);
            const std::vector<TriangleMeeting> truth = truth_of(a, b);
            for (const Kernel& kernel : kernels()) {
                std::vector<TriangleMeeting> meeting;
                std::size_t open = 0;
                for (const FoundPair& pair : found_by(kernel.find, a, b)) {
                    open += !pair.certain;
                    const bool meet = triangles_meet(a[pair.a], b[pair.b]);
                    EXPECT_TRUE(meet || !pair.certain) << kernel.name;
                    if (meet) meeting.push_back({pair.a, pair.b});
                }
                EXPECT_EQ(meeting, truth) << kernel.name << " map\n" << map;
                if (GetParam().name == "random large" && ordinary(map)) {
                    EXPECT_LE(open, count / 20) << kernel.name;
                }
            }
            const TriangleSet set(b);
            std::vector<TriangleMeeting> meeting;
            set.all_meeting(a, meeting);
            EXPECT_EQ(meeting, truth) << " map\n" << map;
            const auto first = set.first_meeting(a);
            ASSERT_EQ(first.has_value(), !truth.empty());
            if (first) {
                EXPECT_EQ(*first, truth.front());
            }
        }
}

INSTANTIATE_TEST_SUITE_P(TriangleSet, EverySet, testing::ValuesIn(triangle_families()),
                         [](const auto& family) { return test_name(family.param); });

TEST(TriangleSet, FindsPairsOnATinyGridFarFromTheOrigin)
{
    GridPoints random(12);
    const Eigen::Vector3d far(0x1p40, -0x1p40, 0x1p41);
    Triangles a, b;
    for (int i = 0; i < 150; ++i)
        for (Triangles* list : {&a, &b}) {
            list->push_back(random.triangle(1));
            const Eigen::Vector3d place = far + 4 * random.point(1);
            for (Eigen::Vector3d& p : list->back()) p += place;
        }
    const TriangleSet set(b);
    std::vector<TriangleMeeting> meeting;
    set.all_meeting(a, meeting);
    EXPECT_EQ(meeting, truth_of(a, b));
    EXPECT_GT(meeting.size(), 300u);
}

TEST(TriangleSet, FindsTheFirstPairThatMeets)
{
    const TrianglePoints t{Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0)};
    for (int at = 0; at < 300; at += 7) {
        Triangles many(300, t);
        for (int i = 0; i < 300; ++i)
            for (Eigen::Vector3d& p : many[static_cast<std::size_t>(i)]) p.z() = i < at ? 1e-12 : i == at ? 0 : -0.0;
        const auto first = TriangleSet(many).first_meeting({&t, 1});
        ASSERT_TRUE(first);
        EXPECT_EQ(*first, (TriangleMeeting{0, static_cast<std::uint32_t>(at)}));
        const TriangleSet one(std::span(&t, 1));
        EXPECT_EQ(*one.first_meeting(many), (TriangleMeeting{static_cast<std::uint32_t>(at), 0}));
    }
}

TEST(TriangleSet, MayBeEmpty)
{
    const TrianglePoints t{Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0)};
    TriangleSet set;
    EXPECT_FALSE(set.first_meeting({&t, 1}));
    set.assign({&t, 1});
    EXPECT_TRUE(set.first_meeting({&t, 1}));
    EXPECT_FALSE(set.first_meeting({}));
    set.assign({});
    EXPECT_FALSE(set.first_meeting({&t, 1}));
}

} // namespace
} // namespace oncollide

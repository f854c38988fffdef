// The scenes of `oncollide-lab bench broad`, and its judge: an exact grid.
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>

#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>

#include "bench/broad/aabbs_file.hpp"
#include "bench/broad/box_scenes.hpp"
#include "peers/peers.hpp"
#include "tools/run_command.hpp"

namespace oncollide::test {
namespace {

using namespace oncollide::tools;

PairSet pairs_of(const BoxScene& scene, std::unique_ptr<BroadPeer> peer)
{
    std::vector<BodyPair> pairs;
    peer->start({scene.boxes, scene.moved, scene.is_static});
    peer->step({scene.boxes, scene.moved, scene.is_static}, pairs);
    return summarise(pairs);
}

BoxScene played(std::string_view name, std::size_t count, std::uint64_t frames)
{
    BoxScene scene = make_box_scene(name, count, 12345);
    while (scene.frame < frames) advance(scene);
    return scene;
}

TEST(BoxScenes, BrownAndLargeGiveThePublishedPairs)
{
    const BoxScene brown = played("brown", 1'000, 60), large = played("large", 10'000, 40);
    EXPECT_EQ(pairs_of(brown, make_brute_peer()), published_result("brown", 1'000, 60));
    EXPECT_EQ(pairs_of(large, make_brute_peer()), published_result("large", 10'000, 40));
    EXPECT_EQ(pairs_of(brown, make_grid_peer()), published_result("brown", 1'000, 60));
    EXPECT_EQ(pairs_of(large, make_grid_peer()), published_result("large", 10'000, 40));
    EXPECT_FALSE(published_result("brown", 1'000, 59));
}

TEST(BoxScenes, TheGridFindsWhatBruteForceFinds)
{
    for (std::string_view name : box_scene_names())
        for (std::size_t count : {1, 2, 3, 50, 1'500}) {
            const BoxScene scene = played(name, count, 7);
            const PairSet right = pairs_of(scene, make_brute_peer());
            EXPECT_EQ(pairs_of(scene, make_grid_peer()), right) << name << " " << count;
            EXPECT_TRUE(count < 1'500 || right.count > 50) << name << " " << right.count;
        }
}

TEST(BoxScenes, OnlyBoxesInMovedMoveAndNoStaticOneIsAmongThem)
{
    for (std::string_view name : box_scene_names()) {
        BoxScene scene = make_box_scene(name, 800, 1);
        for (int frame = 0; frame < 5; ++frame) {
            const std::vector<Aabb> before = scene.boxes;
            advance(scene);
            std::vector<bool> moved(scene.boxes.size());
            for (std::uint32_t i : scene.moved) {
                moved[i] = true;
                EXPECT_FALSE(scene.is_static[i]) << name;
            }
            for (std::size_t i = 0; i < before.size(); ++i)
                EXPECT_TRUE(moved[i] || before[i].min == scene.boxes[i].min) << name << " box " << i;
        }
        EXPECT_GT(scene.moved.size(), 0u) << name;
    }
}

TEST(BoxScenes, CornersAreExactInSinglePrecisionAndNeverTouch)
{
    for (std::string_view name : box_scene_names())
        for (const Aabb& box : played(name, 700, 20).boxes)
            for (int axis : {0, 1, 2}) {
                EXPECT_EQ(std::fmod(box.min[axis], 0x1p-12), 0) << name;
                EXPECT_EQ(std::fmod(std::abs(box.max[axis]), 0x1p-12), 0x1p-13) << name;
                EXPECT_LT(box.min[axis], box.max[axis]) << name;
                EXPECT_EQ(double(float(box.min[axis])), box.min[axis]) << name;
                EXPECT_EQ(double(float(box.max[axis])), box.max[axis]) << name;
            }
}

TEST(BoxScenes, MixedEdgesReachFromATenthToTenAndMostAreSmall)
{
    std::size_t small = 0;
    double longest = 0;
    const BoxScene scene = make_box_scene("mixed", 5'000, 12345);
    for (const Aabb& box : scene.boxes) {
        const double edge = (box.max - box.min).maxCoeff();
        EXPECT_GE((box.max - box.min).minCoeff(), 0.099);
        longest = std::max(longest, edge), small += edge < 0.5;
    }
    EXPECT_GT(longest, 9);
    EXPECT_LT(longest, 10.001);
    EXPECT_GT(small, scene.boxes.size() / 2);
}

TEST(BoxScenes, UnknownNamesAndCountsOutOfRangeAreRefused)
{
    EXPECT_THROW(make_box_scene("bron", 10, 1), Error);
    EXPECT_THROW(make_box_scene("brown", 0, 1), Error);
    EXPECT_THROW(make_box_scene("brown", most_boxes + 1, 1), Error);
}

/// A recording of `count` boxes, box i of frame f at x = i + f.
std::string recording(std::int32_t count, std::int32_t frames)
{
    std::string bytes(256, '\0');
    std::memcpy(bytes.data(), "FreeFall", 8), std::memcpy(bytes.data() + 128, "Cubes", 5);
    const auto add = [&](auto... values) { (bytes.append(reinterpret_cast<const char*>(&values), 4), ...); };
    add(count, frames, 0, 0);
    add(0.f, 0.f, 0.f, 0.f, 9.f, 9.f, 9.f, 0.f);
    for (std::int32_t f = 0; f <= frames; ++f)
        for (std::int32_t i = 0; i < count; ++i) {
            const float x = float(i + f);
            add(x, 0.f, 0.f, 0.f, x + 1.5f, 1.f, 1.f, 0.f);
        }
    return bytes;
}

class Recordings : public ::testing::Test {
protected:
    std::filesystem::path written(const std::string& bytes)
    {
        const std::filesystem::path path = folder_.path() / "a.aabbs";
        std::ofstream(path, std::ios::binary) << bytes;
        return path;
    }

    void expect_refused(const std::string& bytes, const std::string& words)
    {
        try {
            open_aabbs(written(bytes));
            FAIL() << "accepted; expected: " << words;
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::bad_data);
            EXPECT_NE(std::string(error.what()).find("a.aabbs: "), std::string::npos) << error.what();
            EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
        }
    }

    TemporaryFolder folder_;
};

TEST_F(Recordings, AreReadFrameByFrame)
{
    BoxScene scene = open_aabbs(written(recording(3, 2)));
    EXPECT_EQ(scene.name, "FreeFall Cubes");
    EXPECT_EQ(scene.last_frame, 2u);
    ASSERT_EQ(scene.boxes.size(), 3u);
    EXPECT_EQ(scene.boxes[2].min.x(), 2);
    EXPECT_EQ(pairs_of(scene, make_grid_peer()).count, 2u);
    advance(scene), advance(scene);
    EXPECT_EQ(scene.boxes[2].max.x(), 5.5);
    EXPECT_EQ(scene.moved.size(), 3u);
}

TEST_F(Recordings, ThatAreDamagedAreRefusedWithThePlace)
{
    const std::string good = recording(3, 2);
    expect_refused(good.substr(0, 100), "100 bytes are too few");
    expect_refused(good.substr(0, good.size() - 1), "3 boxes in 2 frames");
    expect_refused(good + "x", "3 boxes in 2 frames");
    expect_refused(recording(0, 2), "0 boxes");
    expect_refused(recording(3, 0), "0 frames");
    std::string bad = good;
    bad[264] = 1;
    expect_refused(bad, "264");
    bad = good, std::fill_n(bad.begin(), 128, 'x');
    expect_refused(bad, "128 bytes");
    bad = good;
    const float nan = std::nanf("");
    std::memcpy(bad.data() + 304 + 32 * (3 + 1) + 4, &nan, 4);
    expect_refused(bad, "frame 1, box 1: [nan, 1] along y");
    bad = good;
    const float low = -7;
    std::memcpy(bad.data() + 304 + 32 * 8 + 16, &low, 4);
    expect_refused(bad, "frame 2, box 2: [4, -7] along x");
    EXPECT_THROW(open_aabbs(folder_.path() / "none.aabbs"), Error);
}

} // namespace
} // namespace oncollide::test

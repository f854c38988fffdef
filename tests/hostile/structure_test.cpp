// Scenes and maps mutated by structure, not by bytes: each must be accepted and stepped, or refused with one line.
#include <cstring>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "hostile/structure.hpp"
#include "load_with_samples.hpp"
#include "scenes/test_files.hpp"
#include <oncollide/base/error.hpp>
#include <oncollide/runs/pipeline.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/model/occupancy_map.hpp>

namespace oncollide {
namespace {

using nlohmann::json;

constexpr const char* valid_scene = R"({
  "name": "yard", "frames": 3,
  "geometries": {
    "gear": {"mesh": {"generate": {"kind": "gear", "teeth": 6, "root_radius": 0.8, "tip_radius": 1, "thickness": 0.4,
                                   "bore_radius": 0.3}, "fit_diagonal": 2, "centre": true}},
    "ramp": {"mesh": {"vertices": [[0, 0, 0], [4, 0, 0], [0, 2, 0], [4, 2, 1]], "triangles": [[0, 1, 2], [1, 3, 2]],
                      "scale": 0.5}},
    "ball": {"shape": {"kind": "sphere", "radius": 0.5}},
    "tin": {"shape": {"kind": "cylinder", "radius": 0.3, "length": 1.2}},
    "rock": {"shape": {"kind": "convex_hull", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}},
    "house": {"octomap": {"building": {"rooms": 1, "resolution": 0.5, "seed": 7}}}
  },
  "bodies": [
    {"name": "house", "geometry": "house", "static": true},
    {"name": "ramp", "geometry": "ramp", "position": [2, 2, 0], "rotation": [0, 0, 0.6, 0.8], "layer": 2, "mask": 3},
    {"geometry": "ball", "position": [1, 1, 1], "group": 1,
     "motion": {"drift": {"velocity": [0.1, 0.02, 0], "spin": [0, 0, 0.05], "walls": [[0, 0, 0], [9, 9, 3]]}}},
    {"geometry": "rock", "motion": {"jitter": {"step": 0.1, "seed": 42, "index": 1, "walls": [[0, 0, 0], [9, 9, 3]]}}},
    {"name": "gear", "geometry": "gear", "motion": {"keys": [[0, 5, 0, 1, 0, 0, 0, 1], [2, 5, 4, 1, 0, 0, 1, 0]]}},
    {"geometry": "tin", "position": [1, 0.5, 1]}
  ],
  "exclude": [["gear", "ramp"], [0, 5]]
})";

TEST(HostileStructure, MutatedScenesAreSteppedOrRefused)
{
    std::vector<json> drawn = {0,       1,   -1,       2,         7,       1.5, 1e-300, 1e300,         "",
                               "gear",  "0", "sphere", true,      nullptr, 1e9, "..",   json::array(), json::object(),
                               "house", 255, -0.0,     4294967296};
    const test::StructureMutator mutated(json::parse(valid_scene), drawn);
    const test::TemporaryFolder folder;
    int accepted = 0;
    constexpr int rounds = 3000;
    for (int round = 0; round < rounds; ++round) {
        const auto path = folder.write("a.json", mutated(std::uint64_t(round)).dump());
        try {
            Scene scene = test::load_with_samples(path);
            ++accepted;
            Pipeline pipeline(scene, {.depth = 2, .exact = ExactLevel::predicates});
            Mover mover;
            for (int frame = 0; frame < 2; ++frame) mover.move(scene, frame), pipeline.step(scene);
        } catch (const Error& error) {
            EXPECT_TRUE(error.kind() == ErrorKind::bad_data || error.kind() == ErrorKind::no_input) << error.what();
            EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
        }
    }
    EXPECT_GT(accepted, rounds / 20);
    EXPECT_LT(accepted, rounds / 2);
}

/// Random nodes of a `.bt` file, depth first: two bits per child.
class DrawnMap {
public:
    explicit DrawnMap(std::uint64_t seed) : seed_(seed) { node(0); }

    std::string file(std::int64_t wrong_by) const
    {
        return fmt::format("# Octomap OcTree binary file\nid OcTree\nsize {}\nres 0.25\ndata\n", count_ + wrong_by) +
               bytes_;
    }
    bool valid() const { return valid_; }
    bool occupied() const { return occupied_; }

private:
    double draw() { return u01(seed_, 1, draws_++); }
    void node(int depth)
    {
        const std::size_t at = bytes_.size();
        bytes_.append(2, '\0');
        std::uint16_t bits = 0;
        int inner = 0;
        // Long thin trees, some of which are too deep.
        for (int child = 0; child < 8; ++child) {
            const double chance = draw();
            const unsigned kind = chance < 0.16 && count_ < 400 ? 3u : chance < 0.4 ? 1u + (draw() < 0.5) : 0u;
            bits = static_cast<std::uint16_t>(bits | kind << (2 * child));
            inner += kind == 3, count_ += kind != 0;
            occupied_ |= kind == 2;
        }
        if (bits == 0 && depth > 0) valid_ = false; // an inner node without children
        occupied_ |= bits == 0 && depth == 0;       // the encoding of a completely occupied map
        std::memcpy(bytes_.data() + at, &bits, 2);
        for (; inner > 0; --inner) {
            if (depth + 1 >= 16) valid_ = false;
            if (depth < 20) node(depth + 1);
        }
    }

    std::uint64_t seed_, draws_ = 0;
    std::string bytes_;
    std::int64_t count_ = 1;
    bool valid_ = true, occupied_ = false;
};

TEST(HostileStructure, DrawnMapsAreReadOrRefused)
{
    const test::TemporaryFolder folder;
    int accepted = 0;
    constexpr int rounds = 2000;
    for (int round = 0; round < rounds; ++round) {
        const DrawnMap map{std::uint64_t(round)};
        const std::int64_t wrong_by = round % 7 == 0 ? round % 3 - 1 : 0;
        const auto path = folder.write("a.bt", map.file(wrong_by));
        try {
            const OccupancyMap loaded = load_octomap(path);
            EXPECT_GT(loaded.count(), 0u);
            EXPECT_TRUE(map.valid()) << round;
            EXPECT_TRUE(map.occupied()) << round;
            ++accepted;
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::bad_data) << error.what();
            EXPECT_TRUE(!map.valid() || !map.occupied() || wrong_by != 0) << error.what();
        }
    }
    EXPECT_GT(accepted, rounds / 20);
    EXPECT_LT(accepted, rounds);
}

} // namespace
} // namespace oncollide

#pragma once
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <oncollide/scenes/model/occupancy_map.hpp>

#include "scenes/test_files.hpp"

namespace oncollide::map_test {

using Eigen::Vector3d;
using test::expect_error;

inline std::string bytes_of(const std::filesystem::path& path)
{
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

inline std::vector<Aabb> cells_of(const OccupancyMap& map)
{
    std::vector<Aabb> cells;
    map.each_box([&](const Aabb& cell) { cells.push_back(cell); });
    return cells;
}

inline void expect_equal(const OccupancyMap& a, const OccupancyMap& b)
{
    EXPECT_EQ(a.resolution(), b.resolution());
    EXPECT_EQ(a.bounds().min, b.bounds().min);
    EXPECT_EQ(a.bounds().max, b.bounds().max);
    const auto of_a = cells_of(a), of_b = cells_of(b);
    ASSERT_EQ(of_a.size(), of_b.size());
    for (std::size_t i = 0; i < of_a.size(); ++i) {
        ASSERT_EQ(of_a[i].min, of_b[i].min);
        ASSERT_EQ(of_a[i].max, of_b[i].max);
    }
}

/// A `.ot` file: one path from the root to `depth` by first children, the last node with that log-odds.
inline std::string chain_ot(int depth, float log_odds, int size)
{
    std::string bytes = "# Octomap OcTree file\nid OcTree\nsize " + std::to_string(size) + "\nres 0.5\ndata\n";
    for (int level = 0; level <= depth; ++level) {
        bytes.append(reinterpret_cast<const char*>(&log_odds), 4);
        bytes += level < depth ? '\1' : '\0';
    }
    return bytes;
}

} // namespace oncollide::map_test

// Meshes as files of every format.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

#include "scenes/files/mesh_writers.hpp"
#include "scenes/test_files.hpp"

namespace oncollide::mesh_file_test {

using Eigen::Vector3d;
using test::expect_error;

struct Sample {
    std::string name, bytes;
    bool exact;  ///< keeps doubles
    bool shared; ///< keeps the order of vertices
};

/// `mesh` in every format; `name` is the file's.
inline std::vector<Sample> samples(const Mesh& mesh)
{
    return {{"a.obj", test::as_obj(mesh), true, true},
            {"a.off", test::as_off(mesh), true, true},
            {"text.ply", test::as_text_ply(mesh), true, true},
            {"little.ply", test::as_binary_ply(mesh, false), true, true},
            {"big.PLY", test::as_binary_ply(mesh, true), true, true},
            {"text.stl", test::as_text_stl(mesh), true, false},
            {"binary.stl", test::as_binary_stl(mesh), false, false},
            {"a.glb", test::as_glb(mesh), false, false}};
}

inline void expect_bad(const std::string& name, const std::string& bytes, std::string_view part)
{
    SCOPED_TRACE(bytes.substr(0, 60));
    const test::TemporaryFolder folder;
    const auto path = folder.write(name, bytes);
    expect_error(
        ErrorKind::bad_data, [&] { load_mesh(path); }, path.string() + ": ", part);
}

inline std::string replaced(std::string text, const std::string& from, const std::string& to)
{
    const std::size_t at = text.find(from);
    EXPECT_NE(at, text.npos) << from;
    return at == text.npos ? text : text.replace(at, from.size(), to);
}

/// A binary STL with corners on a grid of `points` points along each axis, with zeros of both signs.
inline std::string corners_on_grid(std::uint32_t facets, std::uint64_t points)
{
    std::string bytes(80, ' ');
    test::append(bytes, facets);
    for (std::uint32_t f = 0; f < facets; ++f) {
        bytes.append(12, '\0');
        for (std::uint32_t k = 0; k < 9; ++k) {
            const float x = float(splitmix(9 * std::uint64_t{f} + k) % points) * 0.1f;
            test::append(bytes, x == 0 && f % 2 ? -x : x);
        }
        bytes.append(2, '\0');
    }
    return bytes;
}

} // namespace oncollide::mesh_file_test

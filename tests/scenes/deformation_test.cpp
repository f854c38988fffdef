#include <oncollide/scenes/deformation.hpp>

#include <cmath>
#include <cstring>
#include <functional>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/flutter.hpp>

#include "load_with_samples.hpp"
#include "same_scene.hpp"
#include "test_files.hpp"

namespace oncollide {
namespace deformation_test {
namespace {

using Eigen::Vector3d;
using test::expect_error;

using Positions = std::vector<Vector3d>;

const Mesh& mesh_of(const Scene& scene, std::size_t geometry)
{
    return std::get<Mesh>(scene.geometries[geometry].data);
}

Flutter wind()
{
    Flutter flutter;
    flutter.edge = {-1, 0, 0}, flutter.growth = 0.3;
    flutter.waves = {{0.7, 1.1, 20, 0.1, 0}, {0.3, 0.4, 7, -0.2, 0.6}};
    return flutter;
}

TEST(Flutter, KeepsTheLengthsAwayFromTheFixedEdgeWhichStays)
{
    const Mesh rest = make_sheet_mesh({2, 1}, {80, 10});
    Flutter flutter = wind();
    double largest = 0;
    for (const double time : {0.0, 0.5, 3.0, 1000.0}) {
        Positions now(rest.vertices.size());
        flutter.move(rest, time, now);
        const auto at = [&](std::size_t column, std::size_t row) { return now[81 * row + column]; };
        for (std::size_t row = 0; row <= 10; ++row) {
            double length = 0;
            for (std::size_t column = 0; column < 80; ++column)
                length += (at(column + 1, row) - at(column, row)).norm();
            EXPECT_NEAR(length, 2, 0.005) << row << " at " << time;
            EXPECT_TRUE(at(0, row).isApprox(rest.vertices[81 * row], 1e-14));
            largest = std::max(largest, std::abs(at(80, row).z()));
            for (const Vector3d& p : now) EXPECT_LE(p.x(), 1);
        }
    }
    EXPECT_GT(largest, 0.1) << "the free end waves";
}

TEST(Flutter, LeavesWhatIsBehindTheEdgeAndTurnsThicknessWithTheCloth)
{
    Flutter flutter = wind();
    const Mesh rest = make_box_mesh({2, 0.5, 0.01}, 40);
    Positions now(rest.vertices.size());
    flutter.move(rest, 4, now);
    std::size_t behind = 0;
    for (std::size_t i = 0; i < now.size(); ++i)
        if (rest.vertices[i].x() <= -1) {
            EXPECT_EQ(now[i], rest.vertices[i]);
            ++behind;
        }
    EXPECT_GT(behind, 400u);
    for (std::size_t i = 0; i < now.size(); ++i) { // the vertex on the other side
        Vector3d other = rest.vertices[i];
        other.z() = -other.z();
        for (std::size_t j = 0; j < now.size(); ++j)
            if (rest.vertices[j] == other) {
                EXPECT_NEAR((now[i] - now[j]).norm(), 2 * std::abs(other.z()), 1e-12);
            }
    }
}

TEST(Flutter, RefusesNumbersThatMakeNoCloth)
{
    const auto refuse = [](auto change, std::string_view words) {
        Flutter flutter = wind();
        EXPECT_NO_THROW(flutter.check());
        change(flutter);
        expect_error(
            ErrorKind::bad_data, [&] { flutter.check(); }, words);
    };
    refuse([](Flutter& f) { f.edge.x() = NAN; }, "edge: ");
    refuse([](Flutter& f) { f.along = {1, 1, 0}; }, "length 1");
    refuse([](Flutter& f) { f.normal = {1, 0, 0}; }, "perpendicular");
    refuse([](Flutter& f) { f.growth = 0; }, "growth must be");
    refuse([](Flutter& f) { f.waves[0].angle = INFINITY; }, "the angle");
    refuse([](Flutter& f) { f.waves[1].length = 0; }, "the length and period");
    refuse([](Flutter& f) { f.waves[1].period = -1; }, "the length and period");
}

/// A scene of one sheet, of 2 x 1 cells and 6 vertices.
Scene one_sheet()
{
    Scene scene;
    scene.add("ball", Sphere{1});
    scene.add_body({.name = "cloth", .geometry = scene.add("sheet", make_sheet_mesh({2, 1}, {2, 1}))});
    return scene;
}
constexpr GeometryId sheet{1};

TEST(Deformation, GivesTheMeshTheVerticesOfTheFrameHoweverItIsReached)
{
    Scene scene = one_sheet();
    const auto rest = scene.geometries.share(1);
    scene.deform(sheet, std::make_shared<Flutter>(wind()));
    EXPECT_EQ(&scene.geometries.at_rest(1), rest.get());
    EXPECT_TRUE(scene.geometries.deforms(1));
    EXPECT_FALSE(scene.geometries.deforms(0));
    const auto expected = [&](double time) {
        Positions positions(6);
        wind().move(std::get<Mesh>(rest->data), time, positions);
        return positions;
    };
    EXPECT_EQ(mesh_of(scene, 1).vertices, expected(0)) << "from the beginning";
    Mover mover;
    scene.pace = 0.5;
    for (const int frame : {0, 1, 2, 30, 7, 0}) {
        mover.move(scene, frame);
        EXPECT_EQ(mesh_of(scene, 1).vertices, expected(0.5 * frame)) << frame;
        EXPECT_EQ(mesh_of(scene, 1).triangles, std::get<Mesh>(rest->data).triangles);
        EXPECT_TRUE(test::same_box(mesh_of(scene, 1).bounds,
                                   make_mesh("", mesh_of(scene, 1).vertices, mesh_of(scene, 1).triangles).bounds));
    }
    const auto before = scene.geometries.share(1);
    Scene copy = scene;
    mover.move(scene, 5);
    EXPECT_EQ(copy.geometries.share(1), before) << "a copy has its own frame";
    mover.move(scene, 0);
    const auto now = scene.geometries.share(1);
    mover.move(scene, 0);
    EXPECT_EQ(scene.geometries.share(1), now) << "nothing has moved";
}

TEST(Deformation, IsForAMeshOfTheSceneAndGivenOnce)
{
    Scene scene = one_sheet();
    const auto deform = [&](GeometryId geometry) { scene.deform(geometry, std::make_shared<Flutter>(wind())); };
    expect_error(
        ErrorKind::bad_data, [&] { deform(GeometryId{0}); }, "geometry 'ball': only a mesh");
    expect_error(
        ErrorKind::bad_data, [&] { deform(GeometryId{2}); }, "there is no geometry 2");
    deform(sheet);
    expect_error(
        ErrorKind::bad_data, [&] { deform(sheet); }, "geometry 'sheet': has a deformation already");
}

/// Throws in frame 3.
class Broken final : public Deformation {
public:
    void move(const Mesh& rest, double time, std::span<Vector3d> positions) override
    {
        if (time == 3) refuse("broken", "frame 3");
        for (std::size_t i = 0; i < positions.size(); ++i) positions[i] = (1 + time) * rest.vertices[i];
    }
};

TEST(Deformation, ThatThrowsChangesNoMesh)
{
    Scene scene = one_sheet();
    const GeometryId other = scene.add("other", make_sheet_mesh({1, 1}, {1, 1}));
    scene.deform(other, std::make_shared<Broken>());
    scene.deform(sheet, std::make_shared<Flutter>(wind()));
    Mover mover;
    mover.move(scene, 2);
    const auto first = scene.geometries.share(1), second = scene.geometries.share(2);
    EXPECT_EQ(std::get<Mesh>(second->data).bounds.max, Vector3d(1.5, 1.5, 0));
    expect_error(
        ErrorKind::bad_data, [&] { mover.move(scene, 3); }, "broken: frame 3");
    EXPECT_EQ(scene.geometries.share(1), first);
    EXPECT_EQ(scene.geometries.share(2), second);
    mover.move(scene, 4);
    EXPECT_EQ(mesh_of(scene, 2).bounds.max, Vector3d(2.5, 2.5, 0));
    expect_error(
        ErrorKind::cannot_write, [&] { save_scene(scene, test::TemporaryFolder().path() / "s.json"); },
        "geometry 'sheet': deforms by code");
}

// --- In scene files.

class DeformationFile : public ::testing::Test {
protected:
    Scene load(const std::string& deformation, const std::string& rest = "")
    {
        return test::load_with_samples(
            folder_.write("s.json", fmt::format(R"({{"geometries": {{"sheet": {{"mesh": {{"generate": {{"kind": "sheet",
                "size": [2, 1], "cells": [2, 1]}}}}, "deformation": {}}}}},
                "bodies": [{{"geometry": "sheet"}}]{}}})",
                                                deformation, rest)));
    }
    /// Vertex v of frame f is at (f, v, 0.1).
    static Positions positions(int frame)
    {
        Positions all;
        for (int v = 0; v < 6; ++v) all.push_back({double(frame), double(v), 0.1});
        return all;
    }
    void write_npy(int frames, int vertices, const std::function<double(int, double)>& change = {})
    {
        std::string header =
            fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}, {}, 3), }}", frames, vertices);
        header.resize(117, ' '), header += '\n';
        std::string bytes = std::string("\x93NUMPY\x01\0", 8) + char(header.size()) + '\0' + header;
        for (int f = 0, k = 0; f < frames; ++f)
            for (int v = 0; v < vertices; ++v)
                for (double x : {double(f), double(v), 0.1}) {
                    if (change) x = change(k, x);
                    char raw[sizeof x];
                    std::memcpy(raw, &x, sizeof x);
                    bytes.append(raw, sizeof x), ++k;
                }
        folder_.write("v.npy", bytes);
    }
    void expect_played(Scene scene)
    {
        EXPECT_EQ(scene.frames, 4);
        EXPECT_EQ(mesh_of(scene, 0).vertices, positions(0));
        Mover mover;
        for (const int frame : {0, 1, 3, 9, 2, 0}) {
            mover.move(scene, frame);
            EXPECT_EQ(mesh_of(scene, 0).vertices, positions(std::min(frame, 3))) << frame;
        }
        scene.pace = 0.4;
        mover.move(scene, 4);
        EXPECT_EQ(mesh_of(scene, 0).vertices, positions(1)) << "of the last whole frame";
    }

    const test::TemporaryFolder folder_;
};

TEST_F(DeformationFile, PlaysRecordedVerticesAndIsWrittenWithTheScene)
{
    write_npy(4, 6);
    Scene scene = load(R"({"file": "v.npy"})");
    expect_played(scene);
    std::filesystem::create_directory(folder_.path() / "other");
    save_scene(scene, folder_.path() / "other" / "s.json");
    Scene again = test::load_with_samples(folder_.path() / "other" / "s.json");
    test::expect_same_scene(scene, again);
    expect_played(test::load_with_samples(folder_.path() / "other" / "s.json"));
    EXPECT_EQ(load(R"({"file": "v.npy"})", R"(, "frames": 9)").frames, 9);
}

TEST_F(DeformationFile, AVertexThatIsNoneNamesItsFrameAndItsNumberWhenItIsPlayed)
{
    for (const double value : {std::nan(""), 1e16, -1e300}) {
        write_npy(4, 6, [&](int k, double x) { return k == (2 * 6 + 5) * 3 + 1 ? value : x; });
        Scene scene = load(R"({"file": "v.npy"})");
        Mover mover;
        mover.move(scene, 1);
        expect_error(
            ErrorKind::bad_data, [&] { mover.move(scene, 2); }, "v.npy: frame 2: vertex 5: (2, ");
        EXPECT_EQ(mesh_of(scene, 0).vertices, positions(1));
    }
}

TEST_F(DeformationFile, RefusesWhatDoesNotFitTheMesh)
{
    const auto refuse = [&](const std::string& entry, std::string_view part, ErrorKind kind = ErrorKind::bad_data) {
        SCOPED_TRACE(part);
        expect_error(
            kind, [&] { load(entry); }, "s.json: geometries.sheet.deformation", part);
    };
    write_npy(4, 5);
    refuse(R"({"file": "v.npy"})", "v.npy: has 5 vertices, and the mesh has 6");
    write_npy(0, 6);
    refuse(R"({"file": "v.npy"})", "v.npy: 0 frames of 6 vertices; there must be one at least");
    refuse(R"({"file": "none.npy"})", "none.npy: no such file", ErrorKind::no_input);
    refuse(R"({"file": "v.abc"})", "unknown kind of recording '.abc'; known are .npy, .h5, .hdf5");
    refuse(R"({"file": "v.npy", "path": "x"})", "is for HDF5 files");
    refuse(R"({"file": "v.npy", "frist": 1})", "frist: unknown key");
    refuse(R"({"flap": {}})", "flap: unknown key");
    refuse("7", "object");
    const auto flutter = [](const char* change) {
        auto entry = nlohmann::json::parse(R"({"edge": [-1, 0, 0], "along": [1, 0, 0], "normal": [0, 0, 1],
            "growth": 0.3, "waves": [[0.5, 1, 20, 0, 0]]})");
        entry.update(nlohmann::json::parse(change));
        return nlohmann::json{{"flutter", entry}}.dump();
    };
    EXPECT_NO_THROW(load(flutter("{}")));
    refuse(flutter(R"({"along": [2, 0, 0]})"), "along and normal must have length 1");
    refuse(flutter(R"({"waves": [[0.5, 1, 20, 0]]})"), "waves[0]");
    refuse(flutter(R"({"waves": [[0.5, 0, 20, 0, 0]]})"), "the length and period of a wave");
    refuse(flutter(R"({"wave": 1})"), "wave: unknown key; did you mean 'waves'?");
    const auto whole = [&](const std::string& geometry, std::string_view part) {
        expect_error(
            ErrorKind::bad_data,
            [&] {
                test::load_with_samples(folder_.write("g.json", R"({"geometries": {"g": )" + geometry +
                                                                    R"(}, "bodies": [{"geometry": "g"}]})"));
            },
            "g.json: geometries.g", part);
    };
    whole(R"({"shape": {"kind": "sphere", "radius": 1}, "deformation": {"file": "v.npy"}})",
          "deformation: is for meshes; this geometry is of the kind 'shape'");
    whole(R"({"deformation": {"file": "v.npy"}})", "mesh");
    whole(R"({"mesh": {"generate": {"kind": "sheet", "size": [1, 1], "cells": [1, 0]}}})", "cells[1]");
}

#ifdef ONCOLLIDE_HDF5

TEST_F(DeformationFile, IsWrittenFrameByFrameInHdf5)
{
    const auto path = folder_.path() / "v.h5";
    {
        VertexFile file(path);
        for (int f = 0; f < 4; ++f) {
            file.add(positions(f));
            EXPECT_FALSE(std::filesystem::exists(path)) << "complete or not at all";
        }
        expect_error(
            ErrorKind::usage, [&] { file.add(Positions(5)); }, "v.h5: frame 4 has 5 vertices; the first has 6");
        file.close();
        expect_error(
            ErrorKind::usage, [&] { file.add(positions(4)); }, "v.h5: is closed");
    }
    Scene scene = load(R"({"file": "v.h5"})");
    expect_played(scene);
    save_scene(scene, folder_.path() / "again.json");
    Scene again = test::load_with_samples(folder_.path() / "again.json");
    again.name = scene.name;
    test::expect_same_scene(scene, again);
    expect_error(
        ErrorKind::bad_data, [&] { load(R"({"file": "v.h5", "path": "poses"})"); }, "v.h5: poses: cannot be opened");
    Scene coded = one_sheet();
    coded.deform(sheet, open_vertices(path));
    EXPECT_EQ(mesh_of(coded, 1).vertices, positions(0));

    const std::size_t before = std::size_t(std::distance(std::filesystem::directory_iterator(folder_.path()), {}));
    {
        VertexFile(folder_.path() / "w.h5").add(positions(0));
    }
    expect_error(
        ErrorKind::cannot_write, [&] { VertexFile(folder_.path() / "w.h5").close(); }, "w.h5: has no frame");
    EXPECT_EQ(std::size_t(std::distance(std::filesystem::directory_iterator(folder_.path()), {})), before)
        << "nothing is left of files that were not closed";
    expect_error(
        ErrorKind::cannot_write, [&] { VertexFile file(folder_.path() / "no" / "v.h5"); }, "v.h5");
}

#endif

} // namespace
} // namespace deformation_test
} // namespace oncollide

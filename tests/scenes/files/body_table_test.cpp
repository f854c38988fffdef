#include <oncollide/scenes/files/scene_file.hpp>

#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "scenes/same_scene.hpp"
#include "scenes/test_files.hpp"
#ifdef ONCOLLIDE_HDF5
#include <hdf5.h>
#endif

namespace oncollide {
namespace {

using Eigen::Vector3d;
using test::expect_error;

constexpr const char* geometries = R"("geometries": {"ball": {"shape": {"kind": "sphere", "radius": 1}},
                                       "a, b": {"shape": {"kind": "box", "half": [1, 1, 1]}}})";

class BodyTable : public ::testing::Test {
protected:
    Scene load(const std::string& table, const std::string& before = "")
    {
        return load_scene(
            folder_.write("s.json", fmt::format("{{{}, {}\"tables\": [{}]}}", geometries, before, table)));
    }
    Scene load_csv(const std::string& text)
    {
        folder_.write("t.csv", text);
        return load(R"({"file": "t.csv"})");
    }
    void refuse_csv(const std::string& text, std::string_view part)
    {
        SCOPED_TRACE(text.substr(0, 100));
        expect_error(
            ErrorKind::bad_data, [&] { load_csv(text); }, "s.json: tables[0]: ", "t.csv: ", part);
    }

    const test::TemporaryFolder folder_;
};

TEST_F(BodyTable, GivesTheSceneThatItsBodiesWouldGive)
{
    folder_.write("t.csv", "\xef\xbb\xbfname,geometry,x,y,z,qx,qy,qz,qw,vx,vy,vz,layer,mask,group,static\r\n"
                           "one,ball,0.1,-2,3e2,0,0,0.6,0.8,0.5,0,0,2,3,4,0\r\n"
                           "\"two, \"\"2\"\"\",\"a, b\",1,2,3,0,0,0,1,0,0,0,1,4294967295,0,1\r\n"
                           ",ball,1,2,3,0,0,0,2,0,0,0,1,4294967295,0,0");
    Scene table = load(R"({"file": "t.csv"})", R"("bodies": [{"geometry": "ball", "name": "first"}],
        "exclude": [["first", "one"], [0, 3]], )");
    Scene bodies = load_scene(folder_.write("b.json", fmt::format(R"({{{}, "name": "s", "bodies": [
        {{"geometry": "ball", "name": "first"}},
        {{"name": "one", "geometry": "ball", "position": [0.1, -2, 300], "rotation": [0, 0, 0.6, 0.8], "layer": 2, "mask": 3,
          "group": 4, "motion": {{"drift": {{"velocity": [0.5, 0, 0]}}}}}},
        {{"name": "two, \"2\"", "geometry": "a, b", "position": [1, 2, 3], "static": true}},
        {{"geometry": "ball", "position": [1, 2, 3]}}], "exclude": [["first", "one"], [0, 3]]}})",
                                                                  geometries)));
    test::expect_same_scene(table, bodies);
    ASSERT_EQ(table.warnings.size(), 1u);
    EXPECT_NE(table.warnings[0].find("t.csv: line 4: quaternion of length 2"), std::string::npos) << table.warnings[0];
}

TEST_F(BodyTable, OneGeometryServesAllRowsAndTablesFollowEachOther)
{
    folder_.write("t.csv", "x,y,z\n1,2,3\n4,5,6\n");
    const Scene scene = load(R"({"file": "t.csv", "geometry": "a, b"}, {"file": "t.csv", "geometry": "ball"})");
    ASSERT_EQ(scene.size(), 4u);
    EXPECT_EQ(index(scene.geometry[1]), 1u);
    EXPECT_EQ(index(scene.geometry[2]), 0u);
    EXPECT_EQ(scene.poses[3].translation(), Vector3d(4, 5, 6));
    EXPECT_EQ(load_csv("geometry,x,y,z\n").size(), 0u) << "a header alone is a table without rows";
}

TEST_F(BodyTable, RefusesTablesThatMakeNoSense)
{
    refuse_csv("x,y,z\n1,2,3\n", "line 1: the column 'geometry' is missing");
    refuse_csv("geometry,x,y\nball,1,2\n", "line 1: the column 'z' is missing");
    refuse_csv("geometry,x,y,z,w\n", "line 1: unknown column 'w'; did you mean 'qw'? valid: geometry, x");
    refuse_csv("geometry,x,y,z,x\n", "line 1: column 'x' is there twice");
    refuse_csv("geometry,x,y,z,qx\n", "line 1: the column 'qy' is missing");
    refuse_csv("geometry,x,y,z,vz\n", "line 1: the column 'vx' is missing");
    const std::string head = "geometry,x,y,z,layer,static,qx,qy,qz,qw\n", row = "ball,1,2,3,1,0,0,0,0,1\n";
    refuse_csv(head + row + "bal,1,2,3,1,0,0,0,0,1\n", "line 3: no geometry named 'bal'");
    refuse_csv(head + row + "ball,1,2,nan,1,0,0,0,0,1\n", "line 3: column 'z' is 'nan'; it must be a finite number");
    refuse_csv(head + row + "ball,1,,3,1,0,0,0,0,1\n", "line 3: column 'y' is ''");
    refuse_csv(head + row + "ball,1,2,3,-1,0,0,0,0,1\n", "line 3: column 'layer' is '-1'");
    refuse_csv(head + row + "ball,1,2,3,4294967296,0,0,0,0,1\n", "line 3: column 'layer' is '4294967296'");
    refuse_csv(head + row + "ball,1,2,3,1,2,0,0,0,1\n", "line 3: column 'static' is '2'");
    refuse_csv(head + row + "ball,1,2,3,1,0,0,0,0,0\n", "line 3: the quaternion (0, 0, 0, 0) has length 0");
    refuse_csv(head + row + "ball,1,2,3,1,0,0,0,0\n", "line 3: has 9 fields; the header has 10");
    refuse_csv(head + row + "ball,1,2,3,1,0,0,0,0,1,2\n", "line 3: has more fields");
    refuse_csv(head + row + "\n", "line 3: no geometry named ''");
    refuse_csv(head + row + "\"ball,1,2,3,1,0,0,0,0,1\n", "line 3: a quoted field has no closing quote");
    refuse_csv(head + row + "\"ball\"x,1,2,3,1,0,0,0,0,1\n", "line 3: a comma or the end of the line");
    refuse_csv("geometry,x,y,z,static,vx,vy,vz\nball,1,2,3,1,1,0,0\n", "line 2: body 0: is static");
    refuse_csv("name,geometry,x,y,z\nq,ball,1,2,3\nq,ball,1,2,3\n",
               "line 3: body 'q': the scene has another body of this name");
    folder_.write("t.csv", "geometry,x,y,z\nball,1,2,3\n");
    const auto refuse = [&](const std::string& entry, std::string_view part) {
        expect_error(
            ErrorKind::bad_data, [&] { load(entry); }, "s.json: tables[0]", part);
    };
    refuse(R"({"file": "t.csv", "geometry": "ball"})", "the scene file gives a geometry for all rows");
    refuse(R"({"file": "t.csv", "geometry": "bal"})", "geometry: no geometry named 'bal'");
    refuse(R"({"file": "t.csv", "path": "bodies"})", "path: is for HDF5 files");
    refuse(R"({"file": "t.xls"})", "file: unknown kind of table '.xls'; known are .csv, .h5, .hdf5");
    refuse(R"({"files": "t.csv"})", "files: unknown key; did you mean 'file'? valid: file, path, geometry");
    expect_error(
        ErrorKind::no_input, [&] { load(R"({"file": "no.csv"})"); }, "no.csv: no such file");
}

#ifdef ONCOLLIDE_HDF5

/// Writes datasets into a new file's group "bodies".
class Hdf5Writer {
public:
    explicit Hdf5Writer(const std::filesystem::path& path)
        : file_(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT)),
          group_(H5Gcreate2(file_, "bodies", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT))
    {
    }
    ~Hdf5Writer() { H5Gclose(group_), H5Fclose(file_); }

    /// @param width 0: one dimension
    template <class T>
    void add(const char* name, hid_t type, std::vector<T> values, hsize_t width, hsize_t chunk = 0)
    {
        const hsize_t extent[2] = {width ? values.size() / width : values.size(), width};
        const hid_t space = H5Screate_simple(width ? 2 : 1, extent, nullptr), plan = H5Pcreate(H5P_DATASET_CREATE);
        const hsize_t chunks[2] = {chunk, width};
        if (chunk) H5Pset_chunk(plan, width ? 2 : 1, chunks), H5Pset_deflate(plan, 6);
        const hid_t data = H5Dcreate2(group_, name, type, space, H5P_DEFAULT, plan, H5P_DEFAULT);
        const hid_t memory = std::is_same_v<T, double> ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64;
        EXPECT_GE(H5Dwrite(data, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0);
        H5Dclose(data), H5Sclose(space), H5Pclose(plan);
    }

private:
    hid_t file_, group_;
};

class Hdf5Table : public BodyTable {
protected:
    Scene load() { return BodyTable::load(R"({"file": "t.h5"})"); }
    template <class Write>
    void refuse(Write write, std::string_view part)
    {
        SCOPED_TRACE(part);
        {
            Hdf5Writer file(path_);
            write(file);
        }
        expect_error(
            ErrorKind::bad_data, [&] { load(); }, "s.json: tables[0]: ", "t.h5: ", part);
    }

    const std::filesystem::path path_ = folder_.path() / "t.h5";
    const std::vector<double> points_ = {0.1, 2, 3, 4, 5, 6};
    const std::vector<std::int64_t> zeros_ = {0, 0};
};

TEST_F(Hdf5Table, GivesTheSameSceneAsCsvFromAnyTypesAndLayouts)
{
    folder_.write("t.csv",
                  "geometry,x,y,z,qx,qy,qz,qw,vx,vy,vz,layer,mask,group,static\n"
                  "ball,0.5,2,3,0,0,0.6,0.8,0.25,0,0,2,3,4,0\n\"a, b\",4,5,6,0,0,0,1,0,0,0,1,4294967295,0,1\n");
    for (const bool compressed : {false, true})
        for (const bool narrow : {false, true}) {
            {
                Hdf5Writer file(path_);
                const hid_t real = narrow ? H5T_IEEE_F32BE : H5T_IEEE_F64LE,
                            whole = narrow ? H5T_STD_U32BE : H5T_STD_I64LE;
                const hsize_t chunk = compressed ? 1 : 0;
                file.add<double>("position", real, {0.5, 2, 3, 4, 5, 6}, 3, chunk);
                file.add<double>("rotation", H5T_IEEE_F64LE, {0, 0, 0.6, 0.8, 0, 0, 0, 1}, 4, chunk);
                file.add<double>("velocity", real, {0.25, 0, 0, 0, 0, 0}, 3, chunk);
                file.add<std::int64_t>("geometry", narrow ? H5T_STD_U8LE : whole, {0, 1}, 0, chunk);
                file.add<std::int64_t>("layer", whole, {2, 1}, 0, chunk);
                file.add<std::int64_t>("mask", whole, {3, 4294967295}, 0, chunk);
                file.add<std::int64_t>("group", whole, {4, 0}, 0, chunk);
                file.add<std::int64_t>("static", H5T_STD_I8LE, {0, 1}, 0, chunk);
            }
            Scene csv = BodyTable::load(R"({"file": "t.csv"})"), scene = load();
            test::expect_same_scene(scene, csv);
        }
}

TEST_F(Hdf5Table, ManyRowsComeBlockByBlock)
{
    constexpr std::size_t rows = 150'000;
    std::vector<double> points(3 * rows);
    for (std::size_t i = 0; i < points.size(); ++i) points[i] = 0.1 * double(i);
    {
        Hdf5Writer file(path_);
        file.add("position", H5T_IEEE_F64LE, points, 3, 1000);
    }
    const Scene scene = BodyTable::load(R"({"file": "t.h5", "geometry": "ball", "path": "/bodies"})");
    ASSERT_EQ(scene.size(), rows);
    for (std::size_t i = 0; i < rows; ++i)
        ASSERT_EQ(scene.poses[i].translation(), Vector3d(points[3 * i], points[3 * i + 1], points[3 * i + 2])) << i;

    struct EveryThirdRun final : BodySink {
        bool wants(std::uint32_t body) const override { return body / 700 % 3 == 1; }
        void take(std::uint32_t body, BodyInit init) override { taken.emplace_back(body, init.pose.translation()); }
        std::vector<std::pair<std::uint32_t, Vector3d>> taken;
    } some;
    EXPECT_EQ(load_scene(folder_.path() / "s.json", some).size(), rows);
    std::size_t next = 0;
    for (std::uint32_t i = 0; i < rows; ++i) {
        if (!some.wants(i)) continue;
        ASSERT_EQ(some.taken.at(next++), std::pair(i, Vector3d(scene.poses.position(i)))) << i;
    }
    EXPECT_EQ(next, some.taken.size());
}

TEST_F(Hdf5Table, RefusesOtherShapesTypesAndLengths)
{
    const auto f64 = H5T_IEEE_F64LE;
    const auto i32 = H5T_STD_I32LE;
    refuse([&](auto& f) { f.add("position", f64, points_, 3); }, "bodies: the column 'geometry' is missing");
    refuse([&](auto& f) { f.add("geometry", i32, zeros_, 0); }, "bodies: the column 'position' is missing");
    const auto with = [&](auto add) { return [&, add](Hdf5Writer& f) { f.add("geometry", i32, zeros_, 0), add(f); }; };
    refuse(with([&](auto& f) { f.add("position", f64, points_, 2); }),
           "bodies/position: has the shape 3 x 2; it must be a dataset of real numbers, rows x 3");
    refuse(with([&](auto& f) { f.add("position", f64, points_, 0); }), "bodies/position: has the shape 6; it must");
    refuse(with([&](auto& f) { f.add("position", H5T_NATIVE_LDOUBLE, points_, 3); }), "values of another type");
    refuse(with([&](auto& f) { f.add("position", f64, points_, 3), f.add("rotaton", f64, points_, 3); }),
           "bodies/rotaton: unknown column; valid: position, rotation");
    refuse(with([&](auto& f) {
               f.add("position", f64, points_, 3), f.add("rotation", f64, std::vector<double>{0, 0, 0, 1}, 4);
           }),
           "bodies/rotation: has 1 rows; position has 2");
    refuse(with([&](auto& f) {
               f.add("position", f64, points_, 3), f.add("layer", f64, std::vector<double>{1, 2}, 0);
           }),
           "bodies/layer: holds values of another type; it must be a dataset of whole numbers, rows");
    refuse(with([&](auto& f) {
               f.add("position", f64, std::vector<double>{0, 0, 0, 1, NAN, 0}, 3);
           }),
           "bodies: row 1: body 1: the pose is not finite");
    refuse(with([&](auto& f) {
               f.add("position", f64, points_, 3), f.add("group", i32, std::vector<std::int64_t>{1, -1}, 0);
           }),
           "bodies: row 1: group is -1; it must be from 0 to 4294967295");
    refuse(
        [&](auto& f) {
            f.add("position", f64, points_, 3), f.add("geometry", i32, std::vector<std::int64_t>{0, 2}, 0);
        },
        "bodies: row 1: geometry is 2; it must be from 0 to 1");
    expect_error(
        ErrorKind::bad_data, [&] { BodyTable::load(R"({"file": "t.h5", "path": "/none"})"); }, "has no group '/none'");
}

TEST_F(Hdf5Table, RefusesDamagedFilesAndThoseThatAnnounceTooMuch)
{
    {
        Hdf5Writer file(path_);
        file.add("position", H5T_IEEE_F64LE, std::vector<double>(30'000, 1), 3);
        file.add("geometry", H5T_STD_I32LE, std::vector<std::int64_t>(10'000, 0), 0);
    }
    std::ifstream in(path_, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    for (const std::size_t size : {std::size_t{1}, std::size_t{100}, bytes.size() / 2, bytes.size() - 1}) {
        folder_.write("t.h5", bytes.substr(0, size));
        expect_error(
            ErrorKind::bad_data, [&] { load(); }, "t.h5: is not a complete HDF5 file");
    }
    folder_.write("t.h5", "x,y,z\n1,2,3\n");
    expect_error(
        ErrorKind::bad_data, [&] { load(); }, "t.h5: is not a complete HDF5 file");
    const hid_t file = H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t group = H5Gcreate2(file, "bodies", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    const hsize_t extent[2] = {9'000'000, 3};
    const hid_t space = H5Screate_simple(2, extent, nullptr);
    H5Dclose(H5Dcreate2(group, "position", H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    H5Sclose(space), H5Gclose(group), H5Fclose(file);
    expect_error(
        ErrorKind::bad_data, [&] { BodyTable::load(R"({"file": "t.h5", "geometry": "ball"})"); },
        "9000000 rows are announced; the file is too short for them");
}

#else

TEST_F(BodyTable, WithoutHdf5SaysWhatWouldReadIt)
{
    folder_.write("t.h5", "x");
    expect_error(
        ErrorKind::bad_data, [&] { load(R"({"file": "t.h5"})"); }, "t.h5: this build cannot read HDF5", "libhdf5-dev");
}

#endif

} // namespace
} // namespace oncollide

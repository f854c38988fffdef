#include <oncollide/scenes/files/scene_file.hpp>

#include <cmath>
#include <cstring>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <oncollide/scenes/recording.hpp>

#include "same_scene.hpp"
#include "test_files.hpp"
#ifdef ONCOLLIDE_HDF5
#include <hdf5.h>
#endif

namespace oncollide {
namespace {

using Eigen::Vector3d;
using test::expect_error;

constexpr int frames = 4, bodies = 2;

/// Body b of frame f is at (f, b, 0.1), and rotates about z.
std::vector<double> numbers()
{
    std::vector<double> all;
    for (int f = 0; f < frames; ++f)
        for (int b = 0; b < bodies; ++b)
            all.insert(all.end(), {double(f), double(b), 0.1, 0, 0, std::sin(0.1 * f), std::cos(0.1 * f)});
    return all;
}

template <class T>
std::string as_npy(const std::vector<double>& values, const std::string& shape, const std::string& type,
                   const char* fortran = "False")
{
    std::string header = fmt::format("{{'descr': '{}', 'fortran_order': {}, 'shape': {}, }}", type, fortran, shape);
    header.resize(117, ' '), header += '\n';
    std::string bytes = std::string("\x93NUMPY\x01\0", 8) + char(header.size()) + '\0' + header;
    for (const double value : values) {
        const T number = static_cast<T>(value);
        char raw[sizeof number];
        std::memcpy(raw, &number, sizeof number);
        bytes.append(raw, sizeof number);
    }
    return bytes;
}

class RecordedMotion : public ::testing::Test {
protected:
    Scene load(const std::string& recording, const std::string& last = R"({"geometry": "ball"})")
    {
        return load_scene(
            folder_.write("s.json", fmt::format(R"({{"geometries": {{"ball": {{"shape": {{"kind": "sphere",
            "radius": 1}}}}}}, "bodies": [{{"geometry": "ball", "position": [7, 7, 7]}}, {{"geometry": "ball", "name": "a"}},
            {}], "recording": {}}})",
                                                last, recording)));
    }
    Scene load_npy(const std::string& bytes, const std::string& last = R"({"geometry": "ball"})")
    {
        folder_.write("r.npy", bytes);
        return load(R"({"file": "r.npy", "first": 1})", last);
    }
    static std::string shape() { return fmt::format("({}, {}, 7)", frames, bodies); }

    const test::TemporaryFolder folder_;
};

TEST_F(RecordedMotion, GivesEveryBodyItsPoseOfEveryFrame)
{
    const std::vector<double> n = numbers();
    Scene scene = load_npy(as_npy<double>(n, shape(), "<f8"));
    EXPECT_EQ(scene.frames, frames);
    Mover mover;
    for (const int frame : {0, 1, 2, 3, 9, 1, 0}) {
        mover.move(scene, frame);
        const int f = std::min(frame, frames - 1);
        EXPECT_EQ(scene.poses[0].translation(), Vector3d(7, 7, 7)) << "is not recorded";
        for (int b = 0; b < bodies; ++b) {
            const double* at = &n[std::size_t(7 * (f * bodies + b))];
            EXPECT_EQ(scene.poses[std::size_t(b + 1)].translation(), Vector3d(at[0], at[1], at[2]));
            EXPECT_TRUE(scene.poses[std::size_t(b + 1)].linear().isApprox(
                Eigen::AngleAxisd(0.2 * f, Vector3d::UnitZ()).toRotationMatrix(), 1e-14));
        }
    }
    scene.pace = 0.5; // the pose of the last whole frame
    mover.move(scene, 3);
    EXPECT_EQ(scene.poses[1].translation().x(), 1);
    EXPECT_EQ(scene.start_pose(2).translation(), Vector3d(0, 1, 0.1));
    const Scene narrow = load_npy(as_npy<float>(n, shape(), "<f4"));
    EXPECT_EQ(narrow.poses[1].translation().z(), double(0.1f));
}

TEST_F(RecordedMotion, IsWrittenWithTheScene)
{
    Scene scene = load_npy(as_npy<double>(numbers(), shape(), "<f8"));
    std::filesystem::create_directory(folder_.path() / "other");
    save_scene(scene, folder_.path() / "other" / "s.json");
    Scene again = load_scene(folder_.path() / "other" / "s.json");
    test::expect_same_scene(scene, again);
    ASSERT_TRUE(again.recording);
    EXPECT_EQ(again.recording->first, 1u);
}

TEST_F(RecordedMotion, APoseThatIsNoneNamesItsFrameAndItsBodyWhenItIsPlayed)
{
    for (const auto& [at, value] : {std::pair{7 * 5 + 1, std::nan("")}, {7 * 5 + 6, 0.5}, {7 * 5, 1e16}}) {
        std::vector<double> n = numbers();
        n[std::size_t(at)] = value; // of frame 2, body 1
        Scene scene = load_npy(as_npy<double>(n, shape(), "<f8"));
        Mover mover;
        mover.move(scene, 1);
        expect_error(
            ErrorKind::bad_data, [&] { mover.move(scene, 2); }, "r.npy: frame 2: body 2: (",
            "not a position and unit quaternion");
        Scene named = load_npy(as_npy<double>(n, shape(), "<f8"), R"({"geometry": "ball", "name": "b"})");
        expect_error(
            ErrorKind::bad_data, [&] { mover.move(named, 2); }, "r.npy: frame 2: body 'b': (");
    }
}

TEST_F(RecordedMotion, RefusesOtherShapesTypesAndLengths)
{
    const std::vector<double> n = numbers();
    const auto refuse = [&](const std::string& bytes, std::string_view part,
                            const std::string& last = R"({"geometry": "ball"})") {
        SCOPED_TRACE(part);
        expect_error(
            ErrorKind::bad_data, [&] { load_npy(bytes, last); }, "s.json: recording: ", part);
    };
    const std::string whole = as_npy<double>(n, shape(), "<f8");
    refuse(as_npy<double>(n, "(8, 7)", "<f8"), "the shape is (8, 7); it must be (frames, bodies, 7)");
    refuse(as_npy<double>(n, "(4, 7, 2)", "<f8"), "the shape is (4, 7, 2); it must be");
    refuse(as_npy<double>(n, shape(), "<f8", "True"), "in the order of Fortran");
    refuse(as_npy<std::int32_t>(n, shape(), "<i4"), "holds whole numbers");
    refuse(as_npy<double>(n, "(5, 2, 7)", "<f8"),
           "(5, 2, 7) numbers of 8 bytes are announced, and 448 bytes are there");
    refuse(as_npy<double>(n, "(4, 2305843009213693952, 7)", "<f8"), "are announced, and 448 bytes are there");
    refuse(as_npy<double>({}, "(0, 2, 7)", "<f8"), "0 frames of 2 bodies; there must be one at least");
    refuse(as_npy<double>(n, "(2, 4, 7)", "<f8"), "holds poses of 4 bodies, from body 1 on; the scene has 3 bodies");
    refuse(whole, "moves body 2, which is static", R"({"geometry": "ball", "static": true})");
    refuse(whole, "moves body 2, which has a motion of its own",
           R"({"geometry": "ball", "motion": {"drift": {"velocity": [1, 0, 0]}}})");
    for (std::size_t size : {std::size_t{1}, std::size_t{9}, std::size_t{60}, whole.size() - 1})
        refuse(whole.substr(0, size), "r.npy: ");
    const auto refuse_entry = [&](const std::string& entry, std::string_view part) {
        expect_error(
            ErrorKind::bad_data, [&] { load(entry); }, "s.json: recording", part);
    };
    refuse_entry(R"({"file": "r.mp4"})", "unknown kind of recording '.mp4'; known are .npy, .h5, .hdf5");
    refuse_entry(R"({"file": "r.npy", "path": "poses"})", "path: is for HDF5 files");
    refuse_entry(R"({"file": "r.npy", "frist": 1})",
                 "frist: unknown key; did you mean 'first'? valid: file, path, first");
    // Cut off while it is played.
    Scene scene = load_npy(whole);
    std::filesystem::resize_file(folder_.path() / "r.npy", whole.size() - 200);
    expect_error(
        ErrorKind::bad_data, [&] { Mover().move(scene, 3); }, "r.npy: frame 3: cannot be read");
}

#ifdef ONCOLLIDE_HDF5

TEST_F(RecordedMotion, InHdf5IsTheSame)
{
    const std::vector<double> n = numbers();
    Scene npy = load_npy(as_npy<float>(n, shape(), "<f4"));
    const auto write = [&](std::vector<hsize_t> extent, const hsize_t* chunk) {
        const hid_t file = H5Fcreate((folder_.path() / "r.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
        const hid_t plan = H5Pcreate(H5P_DATASET_CREATE),
                    space = H5Screate_simple(int(extent.size()), extent.data(), nullptr);
        if (chunk) H5Pset_chunk(plan, int(extent.size()), chunk), H5Pset_deflate(plan, 6);
        const hid_t data = H5Dcreate2(file, "poses", H5T_IEEE_F32LE, space, H5P_DEFAULT, plan, H5P_DEFAULT);
        H5Dwrite(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, n.data());
        H5Dclose(data), H5Sclose(space), H5Pclose(plan), H5Fclose(file);
    };
    const hsize_t chunk[] = {1, 2, 7};
    for (const hsize_t* chunks : {static_cast<const hsize_t*>(nullptr), &chunk[0]}) {
        write({frames, bodies, 7}, chunks);
        Scene scene = load(R"({"file": "r.h5", "first": 1})");
        npy = load_npy(as_npy<float>(n, shape(), "<f4"));
        scene.name = npy.name;
        test::expect_same_scene(scene, npy);
    }
    write({frames * bodies, 7}, nullptr);
    expect_error(
        ErrorKind::bad_data, [&] { load(R"({"file": "r.h5"})"); },
        "r.h5: poses: has the shape 8 x 7; it must be a dataset of real numbers, rows x any x 7");
    expect_error(
        ErrorKind::bad_data, [&] { load(R"({"file": "r.h5", "path": "none"})"); }, "r.h5: none: cannot be opened");
}

#endif

} // namespace
} // namespace oncollide

// HDF5 files that name other files, which the reader must not open.
#ifdef ONCOLLIDE_HDF5
#include <oncollide/scenes/files/scene_file.hpp>
#include <oncollide/scenes/files/tables/results_file.hpp>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <sys/stat.h>

#include "scenes/test_files.hpp"

namespace oncollide::hdf5_links_test {
namespace {

using test::expect_error;

constexpr const char* refused = "is a link to another file, or has its data there";

void write_numbers(hid_t place, const char* name, std::vector<hsize_t> extent, hid_t plan = H5P_DEFAULT)
{
    hsize_t count = 1;
    for (const hsize_t edge : extent) count *= edge;
    std::vector<double> numbers(count, 0);
    for (std::size_t i = 6; i < count; i += 7) numbers[i] = 1; // unit quaternions in recordings
    const hid_t space = H5Screate_simple(int(extent.size()), extent.data(), nullptr);
    const hid_t data = H5Dcreate2(place, name, H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, plan, H5P_DEFAULT);
    if (plan == H5P_DEFAULT) H5Dwrite(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data());
    H5Dclose(data), H5Sclose(space);
}

/// A second file with the objects that the links name, and a pipe, which blocks readers.
class Hdf5Links : public ::testing::Test {
protected:
    Hdf5Links()
    {
        const hid_t file = H5Fcreate((folder_ / "other.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
        H5Gclose(H5Gcreate2(file, "bodies", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
        write_numbers(file, "bodies/position", {2, 3}), write_numbers(file, "poses", {1, 1, 7});
        write_numbers(file, "pairs", {2, 3}), H5Fclose(file);
        EXPECT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
    }
    /// Writes t.h5 by write(file).
    template <class Write>
    void with(Write write) const
    {
        const hid_t file = H5Fcreate((folder_ / "t.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
        write(file);
        H5Fclose(file);
    }
    template <class Write>
    void with_group(Write write) const
    {
        with([&](hid_t file) {
            const hid_t group = H5Gcreate2(file, "bodies", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
            write(group);
            H5Gclose(group);
        });
    }
    Scene load_table() const
    {
        return load_scene(folder_.write("s.json", R"({"geometries": {"b": {"shape": {"kind": "sphere", "radius": 1}}},
                                                      "tables": [{"file": "t.h5", "geometry": "b"}]})"));
    }
    Scene load_recording() const
    {
        return load_scene(folder_.write("s.json", R"({"geometries": {"b": {"shape": {"kind": "sphere", "radius": 1}}},
                                                      "bodies": [{"geometry": "b"}], "recording": {"file": "t.h5"}})"));
    }
    void refuse_table(const std::string& place) const
    {
        expect_error(
            ErrorKind::bad_data, [&] { load_table(); }, "t.h5: " + place + ": " + refused);
    }
    void refuse_recording() const
    {
        expect_error(
            ErrorKind::bad_data, [&] { load_recording(); }, std::string("t.h5: poses: ") + refused);
    }

    const test::TemporaryFolder folder_;
    const std::string others_[2] = {(folder_ / "other.h5").string(), (folder_ / "pipe").string()};
};

TEST_F(Hdf5Links, ExternalLinksAreRefused)
{
    for (const std::string& other : others_) {
        SCOPED_TRACE(other);
        with_group([&](hid_t group) {
            H5Lcreate_external(other.c_str(), "/bodies/position", group, "position", H5P_DEFAULT, H5P_DEFAULT);
        });
        refuse_table("bodies/position");
        with([&](hid_t file) {
            H5Lcreate_external(other.c_str(), "/bodies", file, "bodies", H5P_DEFAULT, H5P_DEFAULT);
        });
        refuse_table("bodies");
        with_group([&](hid_t group) { // a soft link to it
            H5Lcreate_external(other.c_str(), "/poses", group, "far", H5P_DEFAULT, H5P_DEFAULT);
            H5Lcreate_soft("/bodies/far", group, "/poses", H5P_DEFAULT, H5P_DEFAULT);
        });
        refuse_recording();
    }
}

TEST_F(Hdf5Links, ExternalStorageAndVirtualDatasetsAreRefused)
{
    for (const std::string& other : others_) {
        SCOPED_TRACE(other);
        const hid_t elsewhere = H5Pcreate(H5P_DATASET_CREATE), parts = H5Pcreate(H5P_DATASET_CREATE);
        H5Pset_external(elsewhere, other.c_str(), 0, H5F_UNLIMITED);
        const hsize_t extent[] = {2, 3};
        const hid_t space = H5Screate_simple(2, extent, nullptr);
        H5Pset_virtual(parts, space, other.c_str(), "/bodies/position", space);
        for (const hid_t plan : {elsewhere, parts}) {
            with_group([&](hid_t group) { write_numbers(group, "position", {2, 3}, plan); });
            refuse_table("bodies/position");
        }
        with([&](hid_t file) { write_numbers(file, "poses", {1, 1, 7}, elsewhere); });
        refuse_recording();
        H5Sclose(space), H5Pclose(elsewhere), H5Pclose(parts);
    }
}

TEST_F(Hdf5Links, SoftLinksWithinTheFileAreRead)
{
    with([&](hid_t file) {
        write_numbers(file, "numbers", {2, 3});
        H5Gclose(H5Gcreate2(file, "group", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
        H5Lcreate_soft("/numbers", file, "/group/position", H5P_DEFAULT, H5P_DEFAULT);
        H5Lcreate_soft("/group", file, "bodies", H5P_DEFAULT, H5P_DEFAULT);
    });
    EXPECT_EQ(load_table().size(), 2u);
}

TEST_F(Hdf5Links, ResultsThatAreElsewhereAreRefused)
{
    ResultsHeader header;
    header.version = "1", header.scene = "s", header.settings = header.source = "{}";
    header.verdicts = {"separate"}, header.stages = {"broad"}, header.kinds = {"near"};
    const std::filesystem::path path = folder_ / "r.h5";
    for (const std::string& other : others_) {
        ResultsFile(path, header, NameColumn()).close();
        const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
        H5Ldelete(file, "pairs", H5P_DEFAULT);
        H5Lcreate_external(other.c_str(), "/pairs", file, "pairs", H5P_DEFAULT, H5P_DEFAULT);
        H5Fclose(file);
        expect_error(
            ErrorKind::bad_data, [&] { StoredResults(path, header); }, std::string("r.h5: pairs: ") + refused);
    }
    expect_error(
        ErrorKind::no_input, [&] { StoredResults(folder_ / "pipe", header); }, "pipe: is not a readable file");
}

} // namespace
} // namespace oncollide::hdf5_links_test
#endif

// The reader of HDF5, compared with HDF5's library on all layouts of files.
#ifdef ONCOLLIDE_HDF5
#include <cmath>
#include <cstring>
#include <numeric>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <oncollide/scenes/files/hdf5/hdf5_attribute.hpp>
#include <oncollide/scenes/files/hdf5/hdf5_dataset.hpp>
#include <oncollide/scenes/files/hdf5/hdf5_links.hpp>
#include <oncollide/scenes/files/tables/hdf5_file.hpp>
#include <oncollide/scenes/files/tables/results_file.hpp>

#include "hdf5_writers.hpp"
#include "scenes/test_files.hpp"

namespace oncollide::hdf5_reader_test {
namespace {

using test::expect_error, test::Hdf5Plan, test::write_hdf5, test::create_hdf5;
using Sizes = std::vector<std::uint64_t>;

/// Throws Error for any fault.
Hdf5Dataset open(const std::filesystem::path& path, const std::string& name)
try {
    const auto file = std::make_shared<const Hdf5Bytes>(path, Hdf5Bytes::Access::alone);
    const auto object = find_hdf5_object(*file, name);
    if (!object) throw Hdf5Fault{"is missing"};
    return {file, *object};
} catch (const Hdf5Fault& fault) {
    throw Error(ErrorKind::bad_data, name + ": " + fault.what);
}

template <class Number>
std::vector<Number> by_library(hid_t data, const Sizes& start, const Sizes& count)
{
    const std::vector<hsize_t> first(start.begin(), start.end()), size(count.begin(), count.end());
    const hid_t space = H5Dget_space(data), memory = H5Screate_simple(int(size.size()), size.data(), nullptr);
    H5Sselect_hyperslab(space, H5S_SELECT_SET, first.data(), nullptr, size.data(), nullptr);
    std::vector<Number> numbers(std::accumulate(count.begin(), count.end(), std::size_t{1}, std::multiplies<>()));
    const hid_t type = std::is_same_v<Number, double> ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64;
    EXPECT_GE(H5Dread(data, type, memory, space, H5P_DEFAULT, numbers.data()), 0);
    H5Sclose(space), H5Sclose(memory);
    return numbers;
}

bool same(double a, double b)
{
    return std::isnan(a) ? std::isnan(b) : std::memcmp(&a, &b, sizeof a) == 0;
}
bool same(std::int64_t a, std::int64_t b)
{
    return a == b;
}

/// Compares all numbers, and parts.
template <class Number>
void expect_same(const std::filesystem::path& path, const std::string& name, int parts)
{
    SCOPED_TRACE(name);
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT),
                data = H5Dopen2(file, name.c_str(), H5P_DEFAULT);
    const Hdf5Dataset ours = open(path, name);
    std::mt19937_64 random(11);
    for (int part = 0; part < parts; ++part) {
        Sizes start(ours.extent().size(), 0), count = ours.extent();
        for (std::size_t d = 0; part > 0 && d < start.size() && count[d] > 0; ++d)
            start[d] = random() % count[d], count[d] = 1 + random() % (count[d] - start[d]);
        const std::vector<Number> wanted = by_library<Number>(data, start, count);
        std::vector<Number> found(wanted.size(), 77);
        read_hdf5_numbers(ours, start, count, found.data());
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            ASSERT_TRUE(same(found[i], wanted[i])) << i << ": " << found[i] << ", wanted " << wanted[i];
        }
    }
    H5Dclose(data), H5Fclose(file);
}

class Hdf5Reader : public ::testing::Test {
protected:
    const test::TemporaryFolder folder_;
    const std::filesystem::path path_ = folder_ / "t.h5";
};

TEST_F(Hdf5Reader, ReadsTheNumbersThatHdf5ReadsInAllLayouts)
{
    const hid_t types[] = {H5T_IEEE_F64LE, H5T_IEEE_F32BE, H5T_STD_I32LE, H5T_STD_U8LE};
    for (const H5F_libver_t version : {H5F_LIBVER_EARLIEST, H5F_LIBVER_V18, H5F_LIBVER_LATEST}) {
        SCOPED_TRACE(int(version));
        const hid_t file = create_hdf5(path_, version, version == H5F_LIBVER_LATEST ? 0 : 512);
        std::uint64_t seed = 0;
        for (const Hdf5Plan& plan : test::hdf5_plans())
            for (int t = 0; t < 4; ++t)
                write_hdf5(file, fmt::format("{} {}", plan.name, t).c_str(), plan, types[t], ++seed);
        H5Fclose(file);
        for (const Hdf5Plan& plan : test::hdf5_plans())
            for (int t = 0; t < 4; ++t) expect_same<double>(path_, fmt::format("{} {}", plan.name, t), 20);
    }
}

TEST_F(Hdf5Reader, ReadsTheNumbersThatHdf5ReadsOfAllTypes)
{
    const std::vector<hid_t> whole{H5T_STD_I8LE,  H5T_STD_I16LE, H5T_STD_I32LE, H5T_STD_I64LE, H5T_STD_U8BE,
                                   H5T_STD_U16LE, H5T_STD_U32LE, H5T_STD_U64LE, H5T_STD_I16BE, H5T_STD_I32BE,
                                   H5T_STD_I64BE, H5T_STD_U16BE, H5T_STD_U32BE, H5T_STD_U64BE};
    std::vector<hid_t> real{H5T_IEEE_F32LE, H5T_IEEE_F64LE, H5T_IEEE_F32BE, H5T_IEEE_F64BE, test::hdf5_half()};
    const Hdf5Plan plan{.name = "", .extent = {400, 5}, .chunk = {64, 5}, .shuffle = true, .deflate = true};
    const hid_t file = create_hdf5(path_, test::hdf5_oldest);
    for (std::size_t i = 0; i < whole.size(); ++i)
        write_hdf5(file, fmt::format("whole {}", i).c_str(), plan, whole[i], i);
    for (std::size_t i = 0; i < real.size(); ++i) write_hdf5(file, fmt::format("real {}", i).c_str(), plan, real[i], i);
    H5Tcommit2(file, "type", real.back(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    write_hdf5(file, "of a named type", plan, real.back(), 3);
    H5Tclose(real.back()), H5Fclose(file);
    for (std::size_t i = 0; i < whole.size(); ++i) {
        expect_same<double>(path_, fmt::format("whole {}", i), 2);
        if (whole[i] != H5T_STD_U64BE) // HDF5 takes some of them for negative numbers
            expect_same<std::int64_t>(path_, fmt::format("whole {}", i), 2);
    }
    for (std::size_t i = 0; i < real.size(); ++i) expect_same<double>(path_, fmt::format("real {}", i), 2);
    expect_same<double>(path_, "of a named type", 2);
}

/// Indices with several levels, pages, and groups of blocks.
TEST_F(Hdf5Reader, FindsManyChunks)
{
    constexpr hsize_t any = H5S_UNLIMITED;
    const Hdf5Plan plans[] = {
        {"growing", {3000}, {1}, {any}},
        {.name = "growing far", .extent = {140'000}, .chunk = {1}, .most = {any}, .written = Hdf5Plan::some},
        {"fixed", {5000}, {1}},
        {.name = "fixed, one", .extent = {5000}, .chunk = {1}, .written = Hdf5Plan::some},
        {.name = "packed", .extent = {3000}, .chunk = {2}, .most = {any}, .deflate = true},
        {"tree", {100, 100}, {1, 1}, {any, any}},
        {.name = "packed tree", .extent = {50, 50}, .chunk = {2, 1}, .most = {any, any}, .deflate = true}};
    for (const bool newest : {false, true}) {
        const hid_t file = create_hdf5(path_, newest ? test::hdf5_newest : test::hdf5_oldest);
        for (const Hdf5Plan& plan : plans) write_hdf5(file, plan.name, plan, H5T_STD_U8LE, 5);
        H5Fclose(file);
        for (const Hdf5Plan& plan : plans) expect_same<std::int64_t>(path_, plan.name, 1);
    }
}

TEST_F(Hdf5Reader, ReadsDatasetsThatWereCutAndGrew)
{
    const hid_t file = create_hdf5(path_, test::hdf5_newest);
    const std::vector<hsize_t> smaller{9, 2}, larger{30, 3};
    for (const Hdf5Plan& plan : test::hdf5_plans()) {
        if (plan.most.empty() || plan.most[0] < 30 || plan.extent.size() != 2) continue;
        write_hdf5(file, plan.name, plan, H5T_STD_I16LE, 3);
        const hid_t data = H5Dopen2(file, plan.name, H5P_DEFAULT);
        H5Dset_extent(data, smaller.data()), H5Dset_extent(data, larger.data()), H5Dclose(data);
    }
    H5Fclose(file);
    expect_same<double>(path_, "growing both ways", 20), expect_same<double>(path_, "growing packed", 20);
    expect_same<double>(path_, "implicit", 20), expect_same<double>(path_, "fixed", 20);
}

TEST_F(Hdf5Reader, FindsNamesInGroupsOfAllSizes)
{
    for (const bool newest : {false, true})
        for (const int count : {0, 3, 8, 9, 200, 6000}) {
            SCOPED_TRACE(fmt::format("{} names, {}", count, newest ? "newest" : "oldest"));
            const hid_t file = create_hdf5(path_, newest ? test::hdf5_newest : test::hdf5_oldest, 2048),
                        group = H5Gcreate2(file, "a", 0, 0, 0);
            write_hdf5(file, "data", {"", {2}}, H5T_STD_I32LE, 4);
            std::vector<std::string> names;
            for (int i = 0; i < count; ++i) {
                names.push_back(fmt::format("{:0{}}", i, 4 + i % 40));
                if (i % 3 == 2)
                    H5Lcreate_soft("/data", group, names.back().c_str(), 0, 0);
                else
                    H5Lcreate_hard(file, "data", group, names.back().c_str(), 0, 0);
            }
            H5Gclose(group), H5Fclose(file);
            std::ranges::sort(names);
            EXPECT_EQ(Hdf5File(path_).names_in("/a/"), names);
            if (count > 0)
                for (const std::string& name : {names.front(), names[names.size() / 2], names.back()})
                    expect_same<double>(path_, "a/" + name, 1);
            EXPECT_THROW(open(path_, "a/none"), Error);
        }
}

TEST_F(Hdf5Reader, FollowsSoftLinksButNotInCircles)
{
    const hid_t file = create_hdf5(path_, test::hdf5_oldest), group = H5Gcreate2(file, "a", 0, 0, 0);
    write_hdf5(group, "data", {"", {2}}, H5T_STD_I32LE, 4);
    H5Lcreate_soft("data", group, "near", 0, 0), H5Lcreate_soft("./a//near", file, "far", 0, 0);
    H5Lcreate_soft("/a/circle", group, "circle", 0, 0), H5Lcreate_hard(file, "/", group, "root", 0, 0);
    H5Gclose(group), H5Fclose(file);
    expect_same<double>(path_, "far", 1), expect_same<double>(path_, "/a/root/a/root/a/near", 1);
    for (const char* none : {"a/circle", "a/data/b", "b"}) EXPECT_THROW(open(path_, none), Error) << none;
    expect_error(
        ErrorKind::bad_data, [&] { Hdf5File(path_).column("a/circle", Hdf5File::Numbers::real, {}); },
        "t.h5: a/circle: cannot be opened; it must be a dataset");
}

TEST_F(Hdf5Reader, RefusesWhatItDoesNotReadWithTheCure)
{
    const auto refuse = [&](auto set, const char* what) {
        const hid_t file = create_hdf5(path_, test::hdf5_newest), create = H5Pcreate(H5P_DATASET_CREATE);
        const hsize_t extent = 20;
        const hid_t space = H5Screate_simple(1, &extent, nullptr);
        H5Pset_chunk(create, 1, &extent), set(create);
        H5Dclose(H5Dcreate2(file, "a", H5T_STD_I32LE, space, H5P_DEFAULT, create, H5P_DEFAULT));
        H5Pclose(create), H5Sclose(space), H5Fclose(file);
        expect_error(
            ErrorKind::bad_data, [&] { Hdf5File(path_).column("a", Hdf5File::Numbers::real, {}); }, "t.h5: a: ", what,
            "rewrite the file: h5repack -f GZIP=4 OLD NEW");
    };
    refuse([](hid_t create) { H5Pset_nbit(create); }, "the compression or filter 'n-bit'");
    refuse([](hid_t create) { H5Pset_scaleoffset(create, H5Z_SO_INT, 2); }, "the compression or filter 'scale-offset'");
    const hid_t file = create_hdf5(path_, test::hdf5_oldest);
    write_hdf5(file, "large", {.name = "", .extent = {1 << 29}, .chunk = {1 << 29}, .written = Hdf5Plan::nothing},
               H5T_STD_I8LE, 2);
    write_hdf5(file, "long", {"", {2}}, H5T_NATIVE_LDOUBLE, 2);
    H5Fclose(file);
    const auto column = [&](const char* name) { Hdf5File(path_).column(name, Hdf5File::Numbers::real, {}); };
    expect_error(
        ErrorKind::bad_data, [&] { column("large"); }, "t.h5: large: its chunks are larger than 268435456 bytes");
    expect_error(
        ErrorKind::bad_data, [&] { column("long"); }, "t.h5: long: holds values of another type; it must be");
}

/// Otherwise a small file could take any memory and time.
TEST_F(Hdf5Reader, ChunksThatOverlapAreRefused)
{
    const hid_t file = create_hdf5(path_, test::hdf5_oldest);
    write_hdf5(file, "a", {.name = "", .extent = {300}, .chunk = {100}, .deflate = true}, H5T_STD_U8LE, 2);
    H5Fclose(file);
    std::string bytes = folder_.read("t.h5");
    const std::size_t tree = bytes.find(std::string("TREE\1\0\3\0", 8)), first_key = 24, key_and_child = 32;
    ASSERT_NE(tree, bytes.npos);
    const auto size = static_cast<std::uint32_t>(2 * bytes.size() / 5);
    for (std::size_t chunk = 0; chunk < 3; ++chunk)
        std::memcpy(&bytes[tree + first_key + chunk * key_and_child], &size, sizeof size);
    folder_.write("t.h5", bytes);
    expect_error(
        ErrorKind::bad_data, [&] { Hdf5File(path_).column("a", Hdf5File::Numbers::real, {}); },
        "t.h5: a: the file is damaged or cut off (byte ", "chunks overlap");
}

TEST_F(Hdf5Reader, WhatIsBeingWrittenIsRefused)
{
    const hid_t file = create_hdf5(path_, test::hdf5_newest);
    EXPECT_THROW(Hdf5Bytes(path_, Hdf5Bytes::Access::alone), Hdf5Fault);
    H5Fclose(file);
    EXPECT_NO_THROW(Hdf5Bytes(path_, Hdf5Bytes::Access::alone));
}

/// Results, as files of other programs may hold them.
class StoredInHdf5 : public Hdf5Reader {
protected:
    StoredInHdf5()
    {
        header_.version = "1", header_.scene = "scene", header_.settings = header_.source = "{}",
        header_.bodies = 40'000;
        header_.verdicts = {"separate", "within", "colliding"}, header_.stages = {"bounds", "broad"};
        header_.kinds = {"none", "near"};
        const GeometryId ball = scene_.add("ball", Sphere{.radius = 1});
        for (int i = 0; i < 40'000; ++i) scene_.add_body({.name = fmt::format("body {}", i), .geometry = ball});
        ResultsFile file(path_, header_, names_);
        for (std::uint64_t frame = 0; frame < 300; ++frame) {
            std::vector<PairRow> pairs;
            for (std::uint32_t i = 0; i < 500; ++i)
                pairs.push_back(
                    {i, i + 1, std::uint8_t(i % 3), std::uint8_t(i % 2), std::uint8_t(frame % 2), 0.1 * i, 1});
            file.add(pairs, {.frame = frame,
                             .first = 0,
                             .pairs = 0,
                             .hash = frame * frame,
                             .chain = 3 * frame,
                             .ms = 0.5,
                             .stages = {}});
        }
        file.close();
    }
    void expect_results(const std::filesystem::path& path)
    {
        const StoredResults stored(path, header_);
        EXPECT_EQ(stored.header().scene, "scene");
        EXPECT_EQ(stored.header().bodies, 40'000u);
        EXPECT_EQ(stored.unlike(names_), "");
        ASSERT_EQ(stored.frames().size(), 300u);
        std::vector<PairRow> pairs;
        for (const FrameRow& row : stored.frames()) {
            EXPECT_EQ(row.chain, 3 * row.frame);
            stored.read(row, pairs);
            ASSERT_EQ(pairs.size(), 500u);
            for (std::uint32_t i = 0; i < 500; ++i) {
                const PairRow& pair = pairs[i];
                ASSERT_TRUE(pair.a == i && pair.b == i + 1 && pair.verdict == i % 3 && pair.stage == i % 2 &&
                            pair.kind == row.frame % 2 && pair.bound == 0.1 * i && pair.max_error == 1);
            }
        }
    }

    ResultsHeader header_;
    Scene scene_;
    const NameColumn& names_ = scene_.names;
};

TEST_F(StoredInHdf5, AreReadFromOldAndNewFilesWithManyAttributes)
{
    expect_results(path_);
    for (const bool newest : {false, true}) {
        const std::filesystem::path copy = folder_ / "copy.h5";
        const hid_t from = H5Fopen(path_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT),
                    to = create_hdf5(copy, newest ? test::hdf5_newest : test::hdf5_oldest);
        for (const char* name : {"pairs", "frames", "names"}) H5Ocopy(from, name, to, name, H5P_DEFAULT, H5P_DEFAULT);
        const hid_t one = H5Screate(H5S_SCALAR);
        for (int i = 0; i < 30; ++i)
            H5Aclose(H5Acreate2(to, fmt::format("more {}", i).c_str(), H5T_STD_I32BE, one, H5P_DEFAULT, H5P_DEFAULT));
        for (const char* name : {"version", "scene", "settings", "source", "bodies"}) {
            const hid_t old = H5Aopen(from, name, H5P_DEFAULT), type = H5Aget_type(old);
            const hid_t made = H5Acreate2(to, name, type, one, H5P_DEFAULT, H5P_DEFAULT);
            std::uint64_t value = 0; // or the address of a text
            H5Aread(old, type, &value), H5Awrite(made, type, &value);
            if (H5Tget_class(type) == H5T_STRING) H5free_memory(reinterpret_cast<void*>(value));
            H5Aclose(old), H5Aclose(made), H5Tclose(type);
        }
        H5Sclose(one), H5Fclose(from), H5Fclose(to);
        expect_results(copy);
    }
}

TEST_F(StoredInHdf5, HaveTheirWordsInAnyOrder)
{
    ResultsHeader other = header_;
    other.verdicts = {"colliding", "separate", "within"};
    const StoredResults stored(path_, other);
    std::vector<PairRow> pairs;
    stored.read(stored.frames()[0], pairs);
    for (std::uint32_t i = 0; i < 500; ++i) EXPECT_EQ(pairs[i].verdict, (i + 1) % 3);
    other.verdicts = {"separate", "within"};
    StoredResults(path_, other).read(stored.frames()[0], pairs);
    EXPECT_EQ(pairs[2].verdict, 0xff) << "an unknown word";
    EXPECT_EQ(stored.unlike(NameColumn()), "body 0");
}

TEST_F(StoredInHdf5, AreReadWhileTheyAreWrittenAndAfterTheWriterWasKilled)
{
    ResultsFile file(folder_ / "run.h5", header_, names_);
    for (std::uint64_t frame = 0; frame < 200; ++frame) {
        const std::vector<PairRow> pairs(100, {1, 2, 0, 1, 0, 0.5, double(frame)});
        file.add(pairs, {.frame = frame, .first = 0, .pairs = 0, .hash = 0, .chain = frame, .ms = 0, .stages = {}});
        if (frame % 40 != 3) continue;
        for (const char* name : {"run.h5", "killed.h5"}) {
            if (name[0] == 'k') folder_.write(name, folder_.read("run.h5"));
            const StoredResults stored(folder_ / name, header_);
            ASSERT_EQ(stored.frames().size(), frame + 1) << name;
            std::vector<PairRow> read;
            stored.read(stored.frames().back(), read);
            ASSERT_EQ(read.size(), 100u);
            EXPECT_EQ(read.back().max_error, double(frame));
            EXPECT_THROW(Hdf5Bytes(folder_ / name, Hdf5Bytes::Access::alone), Hdf5Fault);
        }
    }
}

} // namespace
} // namespace oncollide::hdf5_reader_test
#endif

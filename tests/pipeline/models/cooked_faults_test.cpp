// Cooked files that are damaged, cut off, changed or forged.
#include "pipeline/models/cooked_scenes.hpp"

namespace oncollide::cooked_scenes {
namespace {

TEST(Cooked, ADamagedChunkCostsThePairsThatNeedIt)
{
    const TemporaryFolder folder;
    const Mesh& terrain = samples().back().mesh;
    const fs::path file = cooked(folder, terrain);
    const std::string bytes = read(file);
    const auto header = test::value_at<CookedHeader>(bytes, 0);
    const Settings settings{.exact = ExactLevel::predicates};
    std::size_t undecided = 0, decided = 0;
    for (std::uint32_t c = 0; c < header.chunks; c += 3) {
        std::string damaged = bytes;
        const auto entry =
            test::value_at<CookedChunkEntry>(bytes, test::table_of(bytes) + c * sizeof(CookedChunkEntry));
        damaged[entry.offset + entry.bytes / 2] ^= 1;
        Scene scene = one_body_on(opened(folder.write("damaged.cooked", damaged)));
        scene.add_body(
            {.name = "other", .geometry = GeometryId{1}, .pose = Eigen::Isometry3d(Eigen::Translation3d(6, 6, 0))});
        const Played played = play(scene, settings, 2);
        ASSERT_EQ(played.frames[0].size(), 2u);
        for (const PairResult& pair : played.frames[1]) ++(pair.verdict == Verdict::undecided ? undecided : decided);
        EXPECT_LE(played.faults.size(), 1u);
        for (const std::string& fault : played.faults)
            EXPECT_NE(fault.find(fmt::format("chunk {} of", c)), std::string::npos) << fault;
        EXPECT_EQ(played.faults.size(), std::size_t(played.frames[0][0].verdict == Verdict::undecided ||
                                                    played.frames[0][1].verdict == Verdict::undecided));
    }
    EXPECT_GT(undecided, 0u);
    EXPECT_GT(decided, undecided);
}

TEST(Cooked, AFileThatIsCutOffWhileItIsOpenIsNoCrash)
{
    const TemporaryFolder folder;
    const fs::path file = cooked(folder, samples().back().mesh);
    const auto mesh = opened(file);
    fs::resize_file(file, fs::file_size(file) / 50);
    const Played played = play(one_body_on(mesh), {.exact = ExactLevel::predicates}, 2);
    EXPECT_EQ(played.frames[1].at(0).verdict, Verdict::undecided);
    ASSERT_FALSE(played.faults.empty());
    EXPECT_NE(played.faults[0].find("the file ends before it; cook the file again (2 results undecided)"),
              std::string::npos)
        << played.faults[0];
}

TEST(Cooked, ChunksBeforeACutAreThereAndThoseBehindItAreNot)
{
    const TemporaryFolder folder;
    const std::string bytes = read(cooked(folder, samples()[4].mesh));
    const auto header = test::value_at<CookedHeader>(bytes, 0);
    ASSERT_GT(header.chunks, 4u);
    CookedMesh::Chunk chunk;
    for (std::uint32_t c = 0; c < header.chunks; ++c) {
        const auto entry =
            test::value_at<CookedChunkEntry>(bytes, test::table_of(bytes) + c * sizeof(CookedChunkEntry));
        for (const std::uint64_t size : {entry.offset, entry.offset + 1, entry.offset + entry.bytes - 1}) {
            const fs::path file = folder.write("cut.cooked", bytes);
            const auto mesh = opened(file);
            fs::resize_file(file, size);
            for (std::uint32_t k = 0; k < header.chunks; ++k) {
                if (k < c)
                    EXPECT_NO_THROW(mesh->read(k, chunk)) << k;
                else
                    EXPECT_THROW(mesh->read(k, chunk), ChunkFault) << k;
            }
            EXPECT_EQ(mesh->faults().size(), header.chunks - c);
            EXPECT_THROW(CookedMesh{file}, Error);
        }
    }
}

TEST(Cooked, AFileThatIsChangedUnderneathIsSeenAndOneThatIsRemovedStays)
{
    const TemporaryFolder folder;
    const fs::path file = cooked(folder, samples()[4].mesh);
    const auto mesh = opened(file);
    fs::remove(file);
    EXPECT_EQ(mesh->whole().triangles, samples()[4].mesh.triangles);
    // Windows keeps the name of a removed file until it is closed.
    const fs::path changed = cooked(folder, samples()[4].mesh, "changed");
    const auto other = opened(changed);
    const fs::path moved = cooked(folder, transformed("moved", samples()[4].mesh, 1, {0, 0, 1}), "moved");
    ASSERT_EQ(fs::file_size(moved), fs::file_size(changed));
    { // in place, as a careless program would
        std::ofstream(changed, std::ios::binary | std::ios::in | std::ios::out) << read(moved);
    }
    EXPECT_THROW(other->whole(), ChunkFault);
}

TEST(Cooked, OneThatNeedsAllOfADamagedMeshIsRefusedAtOnce)
{
    const TemporaryFolder folder;
    std::string bytes = read(cooked(folder, samples()[4].mesh));
    bytes.back() ^= 1, bytes[bytes.size() - 20] ^= 1;
    const auto mesh = opened(folder.write("damaged.cooked", bytes));
    World world({.mode = Mode::solid});
    const ModelId model = world.models().add(mesh);
    test::expect_error(
        ErrorKind::bad_data, [&] { world.bodies().add({.model = model}); }, "damaged.cooked", "checksum");
}

/// Whether the file opens, and all of its contents are unchanged.
bool is_whole(const TemporaryFolder& folder, const std::string& bytes)
{
    const fs::path file = folder.write("changed.cooked", bytes);
    try {
        opened(file)->whole();
        return true;
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::bad_data);
        EXPECT_NE(std::string(error.what()).find("changed.cooked"), std::string::npos) << error.what();
        return false;
    }
}

TEST(Cooked, EveryByteThatChangesAndEveryCutIsSeen)
{
    const TemporaryFolder folder;
    const std::string bytes = read(cooked(folder, odd_mesh(12)));
    for (std::size_t at = 0; at < bytes.size(); ++at) {
        std::string changed = bytes;
        changed[at] = static_cast<char>(changed[at] ^ 1 << at % 8);
        ASSERT_FALSE(is_whole(folder, changed)) << at;
    }
    for (std::size_t size = 1; size < bytes.size(); size += size < 200 ? 1 : 17)
        ASSERT_FALSE(is_whole(folder, bytes.substr(0, size))) << size;
    EXPECT_FALSE(is_whole(folder, bytes + '\0'));
    EXPECT_TRUE(is_whole(folder, bytes));
}

TEST(Cooked, OtherVersionsAndByteOrdersAreNamed)
{
    const TemporaryFolder folder;
    const std::string bytes = read(cooked(folder, make_box_mesh({1, 1, 1})));
    const auto expect = [&](std::size_t at, std::uint32_t value, const char* what) {
        std::string changed = bytes;
        test::set_value(changed, at, value);
        const fs::path file = folder.write("other.cooked", test::resealed(changed));
        test::expect_error(
            ErrorKind::bad_data, [&] { opened(file); }, "other.cooked", what);
    };
    expect(offsetof(CookedHeader, version), 2, "version 2");
    expect(offsetof(CookedHeader, byte_order), 0x04030201, "byte order");
    expect(offsetof(CookedHeader, magic), 7, "not a cooked file");
    expect(offsetof(CookedHeader, kind), 9, "unknown kind");
    test::expect_error(
        ErrorKind::no_input, [&] { opened(folder.path() / "none.cooked"); }, "none.cooked");
}

/// Checksums do not detect forged data; checks of the data must.
TEST(Cooked, BoxesThatTheirTrianglesContradictAreNotTrusted)
{
    const TemporaryFolder folder;
    const Mesh& terrain = samples().back().mesh;
    const std::string bytes = read(cooked(folder, terrain));
    const auto header = test::value_at<CookedHeader>(bytes, 0);
    ASSERT_GT(header.nodes, 2u);
    // Shrinks each node's boxes along z, in turn: a chunk below it needs only its top.
    for (std::uint32_t node = 0; node < header.nodes; ++node) {
        std::string forged = bytes;
        const std::size_t at =
            sizeof(CookedHeader) + node * cooked_node_bytes(CookedKind::mesh) + 8 * 9 * 2; // half-extents along z
        for (std::size_t k = 0; k < 8; ++k) {
            const auto half = test::value_at<std::uint16_t>(forged, at + 2 * k);
            test::set_value(forged, at + 2 * k, std::uint16_t(half - std::min<std::uint16_t>(half, 3)));
        }
        const fs::path file = folder.write("forged.cooked", test::resealed(forged));
        EXPECT_THROW(check_cooked(file), ChunkFault) << node;
    }
    // A chunk is checked before its triangles are used as its whole contents.
    std::string forged = bytes;
    const auto entry = test::value_at<CookedChunkEntry>(bytes, test::table_of(bytes));
    for (std::size_t v = 0; v < entry.vertices; ++v)
        test::set_value(forged, entry.offset + 12 * v + 8,
                        test::value_at<float>(forged, entry.offset + 12 * v + 8) + 1);
    const auto mesh = opened(folder.write("moved.cooked", test::resealed(forged)));
    CookedMesh::Chunk chunk;
    mesh->read(0, chunk);
    Scene scene = one_body_on(mesh, chunk.vertices[0]);
    const Played played = play(scene, {.exact = ExactLevel::predicates}, 1);
    EXPECT_EQ(played.frames[0].at(0).verdict, Verdict::undecided);
    ASSERT_EQ(played.faults.size(), 1u);
    EXPECT_NE(played.faults[0].find("outside"), std::string::npos) << played.faults[0];
}

} // namespace
} // namespace oncollide::cooked_scenes

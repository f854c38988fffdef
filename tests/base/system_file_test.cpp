#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/files/paths.hpp>
#include <oncollide/base/files/random_access_file.hpp>
#include <oncollide/base/files/spool.hpp>
#include <oncollide/base/files/system_file.hpp>

#include "refusal.hpp"
#include "temporary_folder.hpp"

#ifdef _WIN32
#include <windows.h>
#endif

namespace oncollide::system_file_test {
namespace {

namespace fs = std::filesystem;

const std::string name = "größe 漢 🙂.stl";

void save(const fs::path& path, std::string_view text)
{
    OutputFile file(path);
    file.write(text);
    file.commit();
}

std::string read_all(const RandomAccessFile& file, std::size_t size, std::uint64_t offset = 0)
{
    std::string bytes(size, '\0');
    const char* const why = file.read(offset, std::as_writable_bytes(std::span(bytes)));
    return why ? why : bytes;
}

TEST(PathOf, IsUtf8OnEverySystem)
{
    const std::u8string expected = u8"größe 漢 🙂.stl";
    EXPECT_TRUE(path_of(name).u8string() == expected);
    EXPECT_EQ(path_of(name).string(), name);
    EXPECT_EQ(file_in("a", "file://" + name), fs::path("a") / fs::path(expected));
    EXPECT_EQ(portable_name(fs::path("a") / "b" / path_of(name)), "a/b/" + name);
}

TEST(PathOf, IsWhatTheStandardLibraryMakesOfANameInAProgram)
{
    EXPECT_EQ(fs::path(name), path_of(name));
    EXPECT_EQ(fs::path(""), path_of(""));
}

#ifdef _WIN32
TEST(PathOf, RefusesNamesThatWindowsCannotHave)
{
    for (const std::string bad : {"\xff.stl",
                                  "gr\xf6\xdf"
                                  "e.stl",
                                  "\xe6\xbc"})
        says(refusal([&] { file_in("a", bad); }), "must be UTF-8");
}
#endif

TEST(OutputFile, HasANameInUtf8)
{
    const test::TemporaryFolder folder;
    const fs::path path = folder.path() / path_of(name);
    save(path, "one"), save(path, "two");
    ASSERT_EQ(folder.list(), std::vector<std::string>{name});
    EXPECT_EQ(read_file(path, 1000), "two");
    EXPECT_EQ(read_all(RandomAccessFile(path), 3), "two");
    const std::string longest = std::string(230, 'x') + ".stl";
    save(folder.path() / longest, "three");
    EXPECT_EQ(folder.read(longest), "three");
}

TEST(OutputFile, WritesLineEndsAsGiven)
{
    const test::TemporaryFolder folder;
    const std::string text = "one\ntwo\r\n\x1a three\n";
    save(folder / "a", text);
    EXPECT_EQ(fs::file_size(folder / "a"), text.size());
    EXPECT_EQ(read_file(folder / "a", 1000), text);
}

TEST(OutputFile, IsGoneOnceUnfinishedFilesAreRemoved)
{
    const test::TemporaryFolder folder;
    {
        OutputFile file(folder / "a");
        file.write("text");
        ASSERT_EQ(folder.list().size(), 1u);
        remove_unfinished_files();
        says(refusal([&] { file.commit(); }), "cannot write");
    }
    EXPECT_TRUE(folder.list().empty());
}

#ifdef _WIN32
TEST(OutputFile, DoesNotReplaceAFileThatAnotherProgramHolds)
{
    const test::TemporaryFolder folder;
    save(folder / "a", "old");
    const HANDLE held = CreateFileW((folder / "a").c_str(), GENERIC_READ, FILE_SHARE_READ | FILE_SHARE_WRITE, nullptr,
                                    OPEN_EXISTING, 0, nullptr);
    ASSERT_NE(held, INVALID_HANDLE_VALUE);
    says(refusal([&] { save(folder / "a", "new"); }), "a: cannot write");
    EXPECT_EQ(folder.list(), std::vector<std::string>{"a"});
    EXPECT_EQ(folder.read("a"), "old");
    CloseHandle(held);
    save(folder / "a", "new");
    EXPECT_EQ(folder.read("a"), "new");
}

TEST(OutputFile, RefusesAReadOnlyFileBeforeTheWork)
{
    const test::TemporaryFolder folder;
    save(folder / "a", "old");
    SetFileAttributesW((folder / "a").c_str(), FILE_ATTRIBUTE_READONLY);
    says(refusal([&] { check_writable(folder / "a"); }), "a: cannot write");
    SetFileAttributesW((folder / "a").c_str(), FILE_ATTRIBUTE_NORMAL);
    check_writable(folder / "a");
}
#endif

TEST(OutputFile, WritesToTheNullDevice)
{
    save(null_device, "text");
    EXPECT_FALSE(fs::is_regular_file(null_device));
}

TEST(RandomAccessFile, StaysReadableWhenTheFileIsRemoved)
{
    const test::TemporaryFolder folder;
    save(folder / "a", "0123456789");
    RandomAccessFile file(folder / "a");
    ASSERT_TRUE(file.is_open());
    EXPECT_EQ(file.size(), 10);
    fs::remove(folder / "a");
    EXPECT_EQ(read_all(file, 4, 5), "5678");
    EXPECT_EQ(read_all(file, 1, 10), "the file ends before it");
    EXPECT_EQ(read_all(file, 6, 5), "the file ends before it");
    file.close();
    EXPECT_EQ(file.size(), -1);
    EXPECT_TRUE(folder.list().empty());
    EXPECT_FALSE(RandomAccessFile(folder / "a").is_open());
}

TEST(Spool, LeavesNoFile)
{
    const test::TemporaryFolder folder;
    std::string text;
    for (int i = 0; i < 100'000; ++i) text += "line\n\r\x1a";
    {
        Spool spool(folder.path());
        spool.write(text);
        std::string read;
        spool.read([&](std::string_view piece) { read += piece; });
        EXPECT_TRUE(read == text);
    }
    EXPECT_TRUE(folder.list().empty());
}

} // namespace
} // namespace oncollide::system_file_test

// Every file of Debian's assimp-testmodels, including broken ones: each must be processed, or refused in one line.
#include "tools/command_fixture.hpp"

#include <filesystem>

namespace oncollide::test {
namespace {

namespace fs = std::filesystem;

TEST(TestModels, EachIsAnsweredOrRefusedInOneLine)
{
    const fs::path models = "/usr/share/assimp/models";
    if (!fs::is_directory(models)) GTEST_SKIP() << "skipped: no assimp-testmodels";
    const TemporaryFolder folder;
    int answered = 0, refused = 0;
    for (const auto& entry : fs::recursive_directory_iterator(models)) {
        if (!entry.is_regular_file()) continue;
        const std::string file = entry.path();
        SCOPED_TRACE(file);
        // 'timeout' exits with 124 if it had to end the command.
        const Outcome outcome =
            run_program("/usr/bin/timeout", {"60", ONCOLLIDE_COMMAND, "check", file, file, "--depth", "4", "--quiet"},
                        {.folder = folder.path()});
        EXPECT_EQ(outcome.out, "");
        if (outcome.code == 2) { // both at the same pose
            EXPECT_EQ(outcome.err, "");
            ++answered;
            continue;
        }
        const std::string ending = entry.path().extension();
        const bool heights = (ending == ".raw" || ending == ".bin") && entry.file_size() > 0;
        const bool converted = ending == ".ifc" && outcome.code == 66; // its converter is not installed
        // Raw arrays of heights need more options.
        EXPECT_TRUE(converted || outcome.code == (heights ? 64 : 65)) << outcome.code << ": " << outcome.err;
        EXPECT_TRUE(outcome.err.starts_with("oncollide: " + file + ": ")) << outcome.err;
        EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
        ++refused;
    }
    EXPECT_GE(answered, 50);
    EXPECT_GE(refused, 300);
}

} // namespace
} // namespace oncollide::test

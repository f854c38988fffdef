// oncollide-lab is a program of its own, with the rules of oncollide.
#include <fmt/ranges.h>

#include "tools/command_fixture.hpp"

namespace oncollide::test {
namespace {

using Words = std::vector<std::string>;

class Laboratory : public CommandLine {
protected:
    void SetUp() override { write_two_cubes(); }
};

TEST_F(Laboratory, IsAnotherProgramThanTheCommand)
{
    const Outcome refused =
        run_program(ONCOLLIDE_COMMAND, {"bench", "narrow", "--frames", "3"}, {.folder = folder_.path()});
    EXPECT_EQ(refused.code, 64);
    EXPECT_EQ(refused.err, "oncollide: benchmarks are commands of another program: oncollide-lab bench\n");
    const Outcome help = run_program(ONCOLLIDE_COMMAND, {"bench", "--help"}, {.folder = folder_.path()});
    EXPECT_EQ(help.code, 64) << help.out;
    EXPECT_EQ(run({"--help"}).out.find("bench"), std::string::npos);
    EXPECT_EQ(run_program(ONCOLLIDE_LAB, {"run", "s.json"}, {.folder = folder_.path()}).code, 64);
}

TEST_F(Laboratory, ListsTheLibrariesItComparesWith)
{
    const Outcome outcome = run_program(ONCOLLIDE_LAB, {"doctor"}, {.folder = folder_.path()});
    for (const char* word : {"\npeers ", "FCL", "Embree", "Bullet", "ODE", "CGAL", "\nself-test "})
        EXPECT_NE(outcome.out.find(word), std::string::npos) << word << "\n" << outcome.out;
    EXPECT_EQ(run({"doctor"}).out.find("\npeers "), std::string::npos);
}

TEST_F(Laboratory, HasTheExitCodesOfTheCommand)
{
    for (Words words : {Words{"bench", "scene", "IN.json"},
                        {"bench", "narrow", "IN.off", "a.off"},
                        {"bench", "planner", "IN.off", "a.off"},
                        {"bench", "read", "IN.off"},
                        {"study", "IN.json"}}) {
        std::string& input = *std::ranges::find_if(words, [](const std::string& w) { return w.starts_with("IN."); });
        const std::string extension = input.substr(2);
        folder_.write("x" + extension, "{ nothing of the kind");
        for (const auto& [code, name] : {std::pair(66, "missing"), std::pair(65, "x")}) {
            input = name + extension;
            const Outcome outcome = run(words);
            EXPECT_EQ(outcome.code, code) << fmt::format("{}: {}", fmt::join(words, " "), outcome.err);
            EXPECT_NE(outcome.err.find(input), std::string::npos) << outcome.err;
        }
    }
    for (Words words : {Words{"hard", "--csv"},
                        {"study", "s.json", "--html"},
                        {"bench", "scene", "s.json", "--csv"},
                        {"bench", "shapes", "--csv"}}) {
        words.push_back("no/out.json");
        expect_error(73, words, {"no/out.json"});
    }
    expect_error(64, {"bench", "manny"}, {"bench: unknown command 'manny'", "did you mean 'many'?", "planner"});
}

TEST_F(Laboratory, SaysThatItsTextIsLost)
{
    for (const Words& words : {Words{"fuzz", "--scenes", "1"},
                               {"hard", "--count", "2", "--family", "vertex on face"},
                               {"manifolds", "--pairs", "2"},
                               {"bench", "shapes", "--pairs", "2"},
                               {"bench", "read", "--triangles", "100", "--styles", "stl", "--repeats", "1"}}) {
        const Outcome full = run(words, {.folder = {}, .out = "/dev/full"});
        EXPECT_EQ(full.code, 73) << fmt::format("{}: {}", fmt::join(words, " "), full.err);
        EXPECT_TRUE(full.err.ends_with("oncollide-lab: standard output: cannot write: No space left on device\n"))
            << full.err;
    }
}

TEST_F(Laboratory, JudgesManifoldsOfTwoKindsOfShapes)
{
    const Outcome one = run({"manifolds", "--shapes", "--pairs", "40", "--kinds", "sphere,sphere"}),
                  two = run({"manifolds", "--shapes", "--pairs", "40", "--kinds", "sphere,sphere", "--threads", "2"});
    EXPECT_EQ(one.code, 0) << one.out;
    EXPECT_EQ(one.out, two.out);
    EXPECT_TRUE(one.out.starts_with("sphere sphere: 40 pairs, ")) << one.out;
    EXPECT_TRUE(one.out.ends_with("0 faulty pairs\n")) << one.out;
    expect_error(64, {"manifolds", "--shapes", "--kinds", "sphere,ball"}, {"no kind 'ball'", "half-space", "terrain"});
    expect_error(64, {"manifolds", "--shapes", "--kinds", "half-space,half-space"}, {"this pair is not judged"});
    expect_error(64, {"manifolds", "--kinds", "sphere,box"}, {"--shapes"});
}

TEST_F(Laboratory, ReadsLengthsWithUnits)
{
    EXPECT_EQ(run({"bench", "shapes", "--pairs", "5", "--least-gap", "1mm"}).code, 0);
}

/// docs/stability.md lists all formats.
TEST_F(Laboratory, ItsJsonSaysItsSchema)
{
    std::ifstream file(ONCOLLIDE_SOURCE_DIR "/docs/stability.md");
    const std::string page{std::istreambuf_iterator<char>(file), {}};
    ASSERT_EQ(run({"hard", "--count", "2", "--family", "vertex on face", "--json", "o.json"}).code, 0);
    const nlohmann::json j = read_json("o.json");
    EXPECT_EQ(j.value("schema", ""), "oncollide.accuracy_hard");
    EXPECT_NE(page.find(fmt::format("| `{}` | {} |", j.value("schema", ""), j.value("schema_version", 0))),
              std::string::npos);
}

} // namespace
} // namespace oncollide::test

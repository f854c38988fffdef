// A standard output that is closed or full is an error of every command that prints to it.
#include <fmt/ranges.h>

#include "tools/command_fixture.hpp"

namespace oncollide::test {
namespace {

using Words = std::vector<std::string>;

class StandardOutput : public CommandLine {
protected:
    void SetUp() override
    {
        write_two_cubes();
        folder_.write("r.urdf", R"(<robot name="r">
            <link name="a"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
            <joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint><link name="b"/>
            <joint name="k" type="fixed"><parent link="b"/><child link="c"/></joint>
            <link name="c"><collision><geometry><sphere radius="0.1"/></geometry></collision></link></robot>)");
    }
    Outcome closed(Words words)
    {
        words.insert(words.begin(), {"-c", "exec \"$0\" \"$@\" >&-", ONCOLLIDE_COMMAND});
        return run_program("/bin/sh", words, {.folder = folder_.path(), .environment = {{"ONCOLLIDE_DATA", ""}}});
    }
    /// Expects code 73 and a last line that says why.
    void expect_lost(const Words& words)
    {
        SCOPED_TRACE(fmt::format("{}", fmt::join(words, " ")));
        const Outcome full = run(words, {.folder = {}, .out = "/dev/full"}), none = closed(words);
        EXPECT_EQ(full.code, 73) << full.err;
        EXPECT_TRUE(full.err.ends_with("oncollide: standard output: cannot write: No space left on device\n"))
            << full.err;
        EXPECT_EQ(none.code, 73) << none.err;
        EXPECT_TRUE(none.err.ends_with("oncollide: standard output: cannot write: Bad file descriptor\n")) << none.err;
    }
};

TEST_F(StandardOutput, ThatLosesTextForPeopleIsAnErrorOfEveryCommand)
{
    ASSERT_EQ(run({"cook", "a.off", "-o", "a.cooked", "--quiet"}).code, 0);
    for (const Words& words : {Words{"run", "s.json"},
                               {"check", "a.off", "b.off"},
                               {"clash", "a.off", "b.off"},
                               {"robot", "r.urdf"},
                               {"cook", "a.off", "-o", "new.cooked"},
                               {"cook", "--check", "a.cooked"},
                               {"scene", "--list"},
                               {"scene", "many", "--bodies", "5", "--out", "new.json"},
                               {"spheres", "a.off", "--depth", "2", "--directions", "5"},
                               {"doctor"},
                               {"reference", "bash"},
                               {"accuracy", "s.json", "--depths", "2"}}) {
#ifndef ONCOLLIDE_XML
        if (words[0] == "robot") continue;
#endif
        expect_lost(words);
    }
}

TEST_F(StandardOutput, ThatLosesResultsIsAnErrorOfEveryCommand)
{
    for (const Words& words : {Words{"run", "s.json", "--csv", "-"},
                               {"run", "s.json", "--json", "-"},
                               {"run", "s.json", "--trace", "-", "--quiet"},
                               {"check", "a.off", "b.off", "--json", "-"},
                               {"check", "a.off", "b.off", "--contacts", "-"},
                               {"clash", "a.off", "b.off", "-o", "-"},
                               {"robot", "r.urdf", "--csv", "-"},
                               {"robot", "r.urdf", "--json", "-", "--quiet"},
                               {"spheres", "a.off", "--depth", "2", "--directions", "5", "--csv", "-"},
                               {"accuracy", "s.json", "--depths", "2", "--json", "-"}}) {
#ifndef ONCOLLIDE_XML
        if (words[0] == "robot") continue;
#endif
        expect_lost(words);
    }
}

TEST_F(StandardOutput, ThatIsNotUsedMayBeClosed)
{
    EXPECT_EQ(closed({"check", "a.off", "b.off", "--quiet"}).code, 1);
    EXPECT_EQ(closed({"run", "s.json", "--quiet", "--json", "out.json"}).code, 0);
    EXPECT_TRUE(nlohmann::json::accept(folder_.read("out.json")));
}

TEST_F(StandardOutput, ThatIsLostTakesNoOtherOutputWithIt)
{
    EXPECT_EQ(closed({"run", "s.json", "--json", "-", "--csv", "out.csv"}).code, 73);
    EXPECT_NE(folder_.read("out.csv").find("body 0,body 1"), std::string::npos) << folder_.read("out.csv");
    EXPECT_EQ(closed({"check", "a.off", "b.off", "--json", "-", "--contacts", "contacts.csv"}).code, 73);
    EXPECT_TRUE(folder_.read("contacts.csv").starts_with("part_a,part_b,")) << folder_.read("contacts.csv");
}

/// All text goes through cli/standard_output.hpp, so the commands that no test above runs obey the same rule.
TEST_F(StandardOutput, HasOneOwner)
{
    const std::filesystem::path tools = ONCOLLIDE_SOURCE_DIR "/tools";
    for (const auto& entry : std::filesystem::recursive_directory_iterator(tools)) {
        const std::string name = entry.path().lexically_relative(tools).string();
        if (!name.ends_with("pp") || name == "command/cli/standard_output.cpp") continue;
        std::ifstream file(entry.path());
        const std::string text{std::istreambuf_iterator<char>(file), {}};
        for (const char* other : {"std::cout", "std::cerr", "std::printf", "std::puts", " stdout)", "(stdout)"})
            EXPECT_EQ(text.find(other), std::string::npos) << name << " uses " << other;
    }
}

} // namespace
} // namespace oncollide::test

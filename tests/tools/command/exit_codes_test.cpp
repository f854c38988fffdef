// The exit codes of docs/command-line.md, over all commands.
#include <fmt/ranges.h>

#include "tools/command_fixture.hpp"

namespace oncollide::test {
namespace {

using Words = std::vector<std::string>;

class ExitCodes : public CommandLine {
protected:
    void SetUp() override
    {
        write_two_cubes();
        for (const char* broken : {"x.json", "x.off", "x.urdf", "x.h5", "x.csv", "x.cooked"})
            folder_.write(broken, "{ nothing of the kind");
    }
    /// Commands with an input file, which replaces "IN" and whose extension follows.
    static const std::vector<Words>& readers()
    {
        static const std::vector<Words> commands{
            {"run", "IN.json"},
            {"check", "IN.off", "a.off"},
            {"check", "a.off", "IN.off"},
            {"clash", "IN.off", "a.off"},
            {"clash", "a.off", "b.off", "--ignore", "IN.csv"},
            {"clash", "a.off", "b.off", "--baseline", "IN.json"},
            {"cook", "IN.off", "-o", "new.cooked"},
            {"cook", "--check", "IN.cooked"},
            {"merge", "IN.csv", "--out", "new.csv"},
            {"render", "IN.json", "--out", "new.png"},
            {"scene", "IN.json", "--out", "new.json"},
            {"spheres", "IN.off"},
            {"accuracy", "IN.json"},
            {"accuracy", "continuous", "IN.json"},
            {"accuracy", "study", "IN.json"},
#ifdef ONCOLLIDE_XML
            {"robot", "IN.urdf"},
            {"spheres", "IN.urdf", "--count", "5"},
#endif
        };
        return commands;
    }
    void expect_code(int code, Words words, const std::string& input)
    {
        for (std::string& word : words)
            if (word.starts_with("IN.")) word.replace(0, 2, input);
        const std::string line = fmt::format("{}", fmt::join(words, " "));
        const Outcome outcome = run(std::move(words));
        EXPECT_EQ(outcome.code, code) << line << ": " << outcome.err;
        EXPECT_NE(outcome.err.find(fmt::format("{}.", input)), std::string::npos) << line << ": " << outcome.err;
        EXPECT_TRUE(outcome.err.starts_with("oncollide: ")) << line << ": " << outcome.err;
    }
};

TEST_F(ExitCodes, AMissingInputIs66InEveryCommand)
{
    for (const Words& command : readers()) expect_code(66, command, "missing");
    EXPECT_TRUE(std::ranges::none_of(folder_.list(), [](const std::string& file) { return file.starts_with("new"); }));
}

TEST_F(ExitCodes, AnInvalidInputIs65InEveryCommand)
{
    for (const Words& command : readers()) expect_code(65, command, "x");
    EXPECT_TRUE(std::ranges::none_of(folder_.list(), [](const std::string& file) { return file.starts_with("new"); }));
}

TEST_F(ExitCodes, AnOutputThatCannotBeWrittenIs73InEveryCommand)
{
    for (Words words : {Words{"run", "s.json", "--json"},
                        {"run", "s.json", "--csv"},
                        {"run", "s.json", "--trace"},
                        {"check", "a.off", "b.off", "--json"},
                        {"check", "a.off", "b.off", "--contacts"},
                        {"clash", "a.off", "b.off", "-o"},
                        {"cook", "a.off", "-o"},
                        {"scene", "s.json", "--out"},
                        {"spheres", "a.off", "--csv"},
                        {"spheres", "a.off", "--levels"},
                        {"doctor", "--report"},
                        {"accuracy", "s.json", "--csv"},
                        {"accuracy", "study", "s.json", "--html"}}) {
        const std::string name = words.back() == "-o" && words[0] == "cook" ? "no/out.cooked" : "no/out.json";
        words.push_back(name);
        expect_error(73, words, {name});
    }
}

TEST_F(ExitCodes, VerdictsAreTheSameInEveryCommand)
{
    write_cube("far.off");
    const std::string overlap = "0.5 0.2 0.1 0 0 0 1", apart = "5 0 0 0 0 0 1";
    EXPECT_EQ(run({"check", "a.off", "b.off", "--pose-b", apart}).code, 0);
    EXPECT_EQ(run({"check", "a.off", "b.off", "--pose-b", overlap}).code, 1);
    EXPECT_EQ(run({"check", "a.off", "b.off", "--pose-b", overlap, "--exact", "off"}).code, 2);
    EXPECT_EQ(run({"run", "s.json"}).code, 0);
    EXPECT_EQ(run({"run", "s.json", "--exit-code"}).code, 1);
    EXPECT_EQ(run({"run", "s.json", "--exit-code", "--exact", "off"}).code, 2);
    EXPECT_EQ(run({"clash", "a.off", "b.off"}).code, 1);
}

TEST_F(ExitCodes, ARunThatComparesNothingIsNoSuccessForScripts)
{
    const auto scene = [&](const std::string& bodies) {
        folder_.write("n.json", R"({"frames": 1, "geometries": {"g": {"shape": {"kind": "sphere", "radius": 1}}},
                                    "bodies": [)" +
                                    bodies + "]}");
    };
    const auto refused = [&](const char* why) {
        expect_error(65, {"run", "n.json", "--exit-code"}, {"n.json", why, "nothing is compared"});
        expect_error(65, {"accuracy", "n.json"}, {"n.json", why});
        const Outcome outcome = run({"run", "n.json"});
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_NE(outcome.err.find("warning: n.json: "), std::string::npos) << outcome.err;
    };
    scene("");
    refused("the scene has no bodies");
    scene(R"({"geometry": "g"})");
    refused("only one body");
    scene(R"({"geometry": "g", "static": true}, {"geometry": "g", "static": true})");
    refused("all 2 bodies are static");
    scene(R"({"geometry": "g", "group": 1}, {"geometry": "g", "group": 1})");
    refused("groups and layers keep all 2 bodies apart");
    scene(R"({"geometry": "g", "group": 1}, {"geometry": "g", "group": 1}, {"geometry": "g"})");
    EXPECT_EQ(run({"run", "n.json", "--exit-code"}).code, 1);
}

} // namespace
} // namespace oncollide::test

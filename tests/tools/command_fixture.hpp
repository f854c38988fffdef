#pragma once
#include <algorithm>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tools/run_command.hpp"

namespace oncollide::test {

/// The built program that has the command: oncollide, or oncollide-lab in tests that depend on it.
inline std::string program_of([[maybe_unused]] const std::vector<std::string>& arguments)
{
#ifdef ONCOLLIDE_LAB
    for (const char* of_lab : {"bench", "study", "hard", "fuzz", "manifolds"})
        if (!arguments.empty() && arguments[0] == of_lab) return ONCOLLIDE_LAB;
#endif
    return ONCOLLIDE_COMMAND;
}

/// Runs the built programs in an empty folder without any data.
class CommandLine : public ::testing::Test {
protected:
    Outcome run(std::vector<std::string> arguments) { return run(std::move(arguments), Surroundings{}); }
    Outcome run(std::vector<std::string> arguments, Surroundings around)
    {
        around.folder = folder_.path();
        // An empty variable counts as not set, and ../shared/data is not found from a temporary folder.
        around.environment.emplace_back("ONCOLLIDE_DATA", "");
        return run_program(program_of(arguments), arguments, around);
    }

    /// Expects exit code `code` and one line on standard error that contains every word; nothing on standard output.
    void expect_error(int code, std::vector<std::string> arguments, const std::vector<std::string>& words)
    {
        std::string line;
        for (const std::string& argument : arguments) line += " " + argument;
        const std::string name = std::filesystem::path(program_of(arguments)).filename();
        SCOPED_TRACE(name + line);
        const Outcome outcome = run(std::move(arguments));
        EXPECT_EQ(outcome.code, code) << outcome.err;
        EXPECT_EQ(outcome.out, "");
        EXPECT_TRUE(outcome.err.starts_with(name + ": ")) << outcome.err;
        EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
        for (const std::string& word : words) EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
    }

    nlohmann::json read_json(const std::string& name) { return nlohmann::json::parse(folder_.read(name)); }

    /// Writes a.off and b.off, equal cubes, and s.json, in which two of them cross.
    void write_two_cubes()
    {
        write_cube("a.off"), write_cube("b.off");
        folder_.write("s.json", R"({"frames": 1, "geometries": {"a": {"mesh": {"file": "a.off"}}},
                                    "bodies": [{"geometry": "a"}, {"geometry": "a", "position": [0.5, 0.2, 0.1]}]})");
    }
    /// A closed cube of side 1 around the origin.
    void write_cube(const std::string& name)
    {
        folder_.write(name,
                      "OFF\n8 12 0\n"
                      "-.5 -.5 -.5\n.5 -.5 -.5\n.5 .5 -.5\n-.5 .5 -.5\n-.5 -.5 .5\n.5 -.5 .5\n.5 .5 .5\n-.5 .5 .5\n"
                      "3 0 2 1\n3 0 3 2\n3 4 5 6\n3 4 6 7\n3 0 1 5\n3 0 5 4\n"
                      "3 1 2 6\n3 1 6 5\n3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7\n");
    }

    /// A scene file from the smallest useful catalogue scene.
    std::string small_scene()
    {
        const Outcome outcome = run({"scene", "city", "--bodies", "40", "--frames", "5", "--out", "small.json"});
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return "small.json";
    }

    TemporaryFolder folder_;
};

} // namespace oncollide::test

// An empty value, as of an unset variable of the shell, is an error for every option and argument of every command.
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>

#include "cli/command.hpp"
#include "command_fixture.hpp"

namespace oncollide::test {
namespace {

/// Parses command lines without running their commands.
class EmptyValues : public CommandLine {
protected:
    EmptyValues() : line_("oncollide", "", "") { tools::add_commands(line_.arguments()); }

    /// The error of a command line; "" if it is accepted.
    std::string error_of(std::vector<std::string> words)
    {
        words.insert(words.begin(), "oncollide");
        std::vector<char*> argv;
        for (std::string& word : words) argv.push_back(word.data());
        try {
            line_.parse(int(argv.size()), argv.data());
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::usage) << error.what();
            return error.what();
        }
        return "";
    }
    /// Expects that all values of a command and of those below it may not be empty. Returns their number.
    std::size_t check(const tools::CommandText& command)
    {
        std::vector<std::string> begin; // "bench many"
        std::istringstream path(command.path);
        for (std::string word; path >> word;) begin.push_back(word);
        begin.erase(begin.begin());
        std::size_t checked = 0;
        const auto expect = [&](const tools::OptionText& option, std::vector<std::string> words) {
            words.insert(words.begin(), begin.begin(), begin.end());
            const std::string said = error_of(words);
            EXPECT_TRUE(std::ranges::any_of(option.names, [&](const std::string& name) {
                return said.find(fmt::format("{}: the value is empty", name)) != said.npos;
            })) << fmt::format("{}: '{}'", fmt::join(words, " "), said);
            ++checked;
        };
        for (const tools::OptionText& option : command.options) {
            if (option.value.empty()) continue;
            for (const std::string& name : option.names) {
                expect(option, {name, ""});
                if (name.starts_with("--")) expect(option, {name + "=", "next"}); // is not the value
            }
        }
        std::vector<std::string> before; // positions that are given
        for (const tools::OptionText& position : command.positions) {
            std::vector<std::string> words = before;
            words.push_back("");
            expect(position, words);
            before.push_back("1");
        }
        for (const tools::CommandText& below : command.commands) checked += check(below);
        return checked;
    }

    tools::CommandLine line_;
};

TEST_F(EmptyValues, AreAnErrorForEveryOptionAndArgument)
{
    EXPECT_GT(check(line_.arguments().describe_program()), 800u) << "some commands or options were not found";
    EXPECT_NE(error_of({"reference", ""}).find(": the value is empty"), std::string::npos) << "a hidden command";
}

TEST_F(EmptyValues, OfAListOrOfAPairAreErrorsToo)
{
    EXPECT_NE(error_of({"render", "many", "--out", "x.png", "--frame", "1,,2"}).find("--frame: the value is empty"),
              std::string::npos);
    EXPECT_NE(error_of({"render", "many", "--out", "x.png", "--level", ","}).find("--level: the value is empty"),
              std::string::npos);
    expect_error(64, {"robot", "r.urdf", "--package", "panda="}, {"--package", "NAME=FOLDER"});
    expect_error(64, {"clash", "a.obj", "b.obj", "--units", "a*="}, {"--units"});
    expect_error(64, {"accuracy", "study", "many", "--max-errors", "1cm,,2cm"}, {"--max-errors"});
    expect_error(64, {"accuracy", "study", "many", "--depths", "4,"}, {"--depths"});
}

TEST_F(EmptyValues, AreNamedAsUsersMeetThem)
{
    expect_error(64, {"robot", "r.urdf", "--world", ""},
                 {"robot: --world: the value is empty; is a shell variable not set?", "(oncollide robot --help)"});
    expect_error(64, {"check", "a.off", "b.off", "--pose-b="}, {"check: --pose-b: the value is empty"});
    expect_error(64, {"check", "a.off", ""}, {"check: B: the value is empty"});
    expect_error(64, {"clash", "a.off", ""}, {"clash: parts: the value is empty"});
    expect_error(64, {"run", "city", "--threads", ""}, {"run: --threads: the value is empty"});
}

} // namespace
} // namespace oncollide::test

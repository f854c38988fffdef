// Rules that every command and every option of the program keeps.
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>

#include "cli/command.hpp"
#include "tools/command_fixture.hpp"

namespace oncollide::test {
namespace {

using Words = std::vector<std::string>;

class EveryCommand : public CommandLine {
protected:
    EveryCommand() : line_(tools::program.name, "", "") { tools::program.add_commands(line_.arguments()); }

    tools::CommandText program() { return line_.arguments().describe_program(); }
    Outcome run_tested(Words words, const std::string& out = {})
    {
        return run_program(ONCOLLIDE_TESTED, std::move(words),
                           {.folder = folder_.path(), .out = out, .environment = {{"ONCOLLIDE_DATA", ""}}});
    }
    /// "bench", "many" of the command "oncollide-lab bench many".
    static Words words_of(const tools::CommandText& command)
    {
        std::istringstream path(command.path);
        Words words;
        for (std::string word; path >> word;) words.push_back(word);
        words.erase(words.begin());
        return words;
    }
    /// The error of a command line that is parsed and not run; "" if it is accepted.
    std::string error_of(Words words)
    {
        words.insert(words.begin(), tools::program.name);
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
    std::size_t check_empty_values(const tools::CommandText& command)
    {
        std::size_t checked = 0;
        const auto expect = [&](const tools::OptionText& option, Words more) {
            Words words = words_of(command);
            words.insert(words.end(), more.begin(), more.end());
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
        Words before; // positions that are given
        for (const tools::OptionText& position : command.positions) {
            Words words = before;
            words.push_back("");
            expect(position, words);
            before.push_back("1");
        }
        for (const tools::CommandText& below : command.commands) checked += check_empty_values(below);
        return checked;
    }
    void expect_usage(const tools::CommandText& command)
    {
        Words words = words_of(command);
        words.push_back("--no-such-option");
        const Outcome outcome = run_tested(words);
        EXPECT_EQ(outcome.code, 64) << command.path << outcome.err;
        EXPECT_NE(outcome.err.find(fmt::format("({} --help)", command.path)), std::string::npos) << outcome.err;
        for (const tools::CommandText& below : command.commands) expect_usage(below);
    }
    /// Expects code 73 and a last line that says why, where help is lost.
    void expect_lost(const Words& words)
    {
        const Outcome full = run_tested(words, "/dev/full");
        EXPECT_EQ(full.code, 73) << fmt::format("{}: {}", fmt::join(words, " "), full.err);
        EXPECT_TRUE(full.err.ends_with(
            fmt::format("{}: standard output: cannot write: No space left on device\n", tools::program.name)))
            << full.err;
    }
    void expect_lost_help(const tools::CommandText& command)
    {
        Words words = words_of(command);
        words.push_back("--help");
        expect_lost(words);
        for (const tools::CommandText& below : command.commands) expect_lost_help(below);
    }

private:
    tools::CommandLine line_;
};

/// An unset variable of the shell is an empty value.
TEST_F(EveryCommand, RefusesEmptyValuesOfAllOptionsAndArguments)
{
    EXPECT_GT(check_empty_values(program()), 250u) << "some commands or options were not found";
    EXPECT_NE(error_of({"reference", ""}).find(": the value is empty"), std::string::npos) << "a hidden command";
}

TEST_F(EveryCommand, RefusesAnUnknownOption)
{
    expect_usage(program());
}

TEST_F(EveryCommand, SaysThatItsHelpIsLost)
{
    expect_lost_help(program());
    for (const char* word : {"--version", "version", "help"}) expect_lost({word});
}

TEST_F(EveryCommand, IsNamedInTheHelpAndTheReferences)
{
    const std::string help = run_tested({"--help"}).out, markdown = run_tested({"reference", "markdown"}).out;
    ASSERT_EQ(run_tested({"reference", "man", "--out", "."}).code, 0);
    EXPECT_TRUE(markdown.starts_with(fmt::format("# Reference of {}\n", tools::program.name)));
    EXPECT_EQ(help.find("reference"), std::string::npos) << "it is only for builds";
    EXPECT_TRUE(run_tested({"--version"})
                    .out.starts_with(tools::program.name + std::string(" " ONCOLLIDE_PROJECT_VERSION "\n")));
    const std::string name = tools::program.name;
    for (const char* shell : {"bash", "zsh", "fish"}) {
        const std::string completion = run_tested({"reference", shell}).out;
        for (const tools::CommandText& command : program().commands) {
            EXPECT_NE(completion.find(command.path), std::string::npos) << shell << ": " << command.path;
            EXPECT_NE(help.find("\n  " + command.name + " "), std::string::npos) << command.path;
            EXPECT_NE(markdown.find(fmt::format("\n## {}\n", command.path)), std::string::npos) << command.path;
            EXPECT_GT(folder_.read(name + "-" + command.name + ".1").size(), 300u);
        }
    }
}

} // namespace
} // namespace oncollide::test

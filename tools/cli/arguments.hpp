#pragma once
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
} // namespace CLI

// The command line, as the subcommands see it. The library behind it is a header that takes ten seconds to compile:
// arguments.cpp alone includes it.
namespace oncollide::tools {

/// An option of a command. Copies stand for the same option.
class Option {
public:
    explicit Option(CLI::Option* option) : option_(option) {}
    Option type_name(const std::string& name); ///< what help calls its value
    Option required();
    Option expected(int count);
    Option expected(int least, int most);
    Option repeatable();             ///< each use adds one value
    Option separated_by(char comma); ///< one argument holds all values
    Option needs(Option other);
    /// @param fault  says what is wrong with a value; empty: nothing
    Option check(std::function<std::string(const std::string&)> fault);
    bool given() const; ///< once the command line is parsed

private:
    CLI::Option* option_;
};

/// What the chosen command does; returns the exit code. Parsing only chooses it, so that a bad command line is told
/// from work that fails.
using Command = std::function<int()>;

/// A command and its options. Copies stand for the same command.
class Arguments {
public:
    Arguments(CLI::App* app, Command* chosen) : app_(app), chosen_(chosen) {}

    Arguments add_command(const std::string& name, const std::string& summary);
    /// @param names  "--long" or "--long,--alias", or a word for a position. `value` must live until the command ran.
    /// For int, long, double, std::uint64_t, std::string, optionals of these, vectors of int and of std::string.
    template <class Value>
    Option add_option(const std::string& names, Value& value, const std::string& help);
    Option add_flag(const std::string& name, bool& value, const std::string& help);
    void remove_option(const std::string& name);
    void footer(const std::string& text);
    void at_most_one_command(); ///< words after it belong to it
    /// What to do when this command is chosen, and none of its own commands.
    void action(Command command);

private:
    CLI::App* app_;
    Command* chosen_;
};

/// The whole command line of a program.
class CommandLine {
public:
    CommandLine(const std::string& program, const std::string& summary, const std::string& version);
    ~CommandLine();

    Arguments arguments();
    /// What was chosen; once help or version were printed, something that does nothing.
    /// Throws Error{usage} with one line that says what is wrong.
    Command parse(int argc, char** argv);

private:
    std::unique_ptr<CLI::App> app_;
    Command chosen_;
};

/// Throws Error{usage}.
[[noreturn]] void usage(const std::string& message);
/// The same for a value that is out of range.
void check_range(const char* option, std::int64_t value, std::int64_t least,
                 std::int64_t most = std::numeric_limits<std::int64_t>::max());

} // namespace oncollide::tools

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

// The command line, as the subcommands see it. Only arguments.cpp includes the library behind it, whose header takes
// ten seconds to compile.
namespace oncollide::tools {

/// An option of a command. Copies refer to the same option.
class Option {
public:
    explicit Option(CLI::Option* option) : option_(option) {}
    Option required();
    Option expected(int least, int most);
    Option repeatable();             ///< each use adds one value
    Option separated_by(char comma); ///< one argument holds all values
    Option length();                 ///< a number of metres, or with a unit, such as 1mm
    Option needs(Option other);
    bool given() const; ///< valid after the command line was parsed

private:
    CLI::Option* option_;
};

/// Help and reference text of an option or of a positional argument.
struct OptionText {
    std::vector<std::string> names; ///< "-o", "--out"; positional argument: its name, without dashes
    std::string value;              ///< "FILE", "off|on|fcl"; empty: takes no value
    std::string help, group;
    bool required, repeatable;
};

/// Help and reference text of a command.
struct CommandText {
    std::string name, path; ///< "study" and "oncollide accuracy study"
    std::string summary, footer;
    std::vector<OptionText> positions, options;
    std::vector<CommandText> commands;
};

/// "oncollide run [OPTIONS] scene"
std::string usage_of(const CommandText& command);
/// The text of --help, wrapped to `width` columns; only words without a space in them may be longer.
std::string help_text(const CommandText& command, std::size_t width);

/// Runs the chosen command and returns the exit code. Parsing only chooses the command, so that usage errors differ
/// from failures of its work.
using Command = std::function<int()>;

/// A command and its options. Copies refer to the same command.
class Arguments {
public:
    Arguments(CLI::App* app, Command* chosen) : app_(app), chosen_(chosen) {}

    Arguments add_command(const std::string& name, const std::string& summary);
    /// @param names  "--long" or "--long,--alias", or the name of a positional argument; then, after a space, the word
    ///               for its value in --help. `value` must outlive the command.
    /// For int, long, double, std::uint64_t, std::string, optionals of these, vectors of int and of std::string. An
    /// empty value is a usage error.
    template <class Value>
    Option add_option(const std::string& names, Value& value, const std::string& help);
    Option add_flag(const std::string& name, bool& value, const std::string& help);
    void remove_option(const std::string& name);
    void footer(const std::string& text);
    void group(const std::string& name); ///< heading in --help of options added after this call
    void hide();                         ///< from --help: for scripts, not for people
    void at_most_one_command();          ///< words after a command belong to it
    /// Adds a hidden command; every use of it is a usage error with this text.
    void refuse_command(const std::string& name, const std::string& why);
    /// Sets the function that runs when this command, and none of its subcommands, is chosen.
    void action(Command command);
    /// All commands of the program, not only this one.
    CommandText describe_program() const;

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
    /// The chosen command; after printing help or the version, a command that does nothing.
    /// Throws Error{usage} with one line that says what is wrong.
    Command parse(int argc, char** argv);

private:
    std::unique_ptr<CLI::App> app_;
    Command chosen_;
};

/// Throws Error{usage}.
[[noreturn]] void usage(const std::string& message);
/// Throws Error{usage} if the value is out of range.
void check_range(const char* option, std::int64_t value, std::int64_t least,
                 std::int64_t most = std::numeric_limits<std::int64_t>::max());

} // namespace oncollide::tools

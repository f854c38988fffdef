#include "cli/arguments.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/text/near_word.hpp>

#include "cli/lengths.hpp"
#include "cli/standard_output.hpp"
#include "cli/system.hpp"

namespace oncollide::tools {
namespace {

std::string joined(const std::vector<std::string>& words)
{
    std::string result;
    for (const std::string& word : words) result += (result.empty() ? "" : ", ") + word;
    return result;
}

std::vector<std::string_view> views(const std::vector<std::string>& words)
{
    return {words.begin(), words.end()};
}

std::vector<std::string> command_names(const CLI::App& app)
{
    std::vector<std::string> names;
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
        if (!command->get_group().empty()) names.push_back(command->get_name());
    return names;
}

std::vector<std::string> option_names(const CLI::App& command)
{
    std::vector<std::string> names;
    for (const CLI::Option* option : command.get_options())
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    return names;
}

OptionText describe(const CLI::Option& option)
{
    OptionText text;
    for (const std::string& name : option.get_snames()) text.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) text.names.push_back("--" + name);
    if (option.get_positional()) text.names.push_back(option.get_name(true, false));
    if (option.get_items_expected_max() > 0) text.value = option.get_type_name();
    text.help = option.get_description(), text.group = option.get_group();
    text.required = option.get_required();
    text.repeatable = option.get_items_expected_max() > 1 ||
                      (!text.value.empty() && option.get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll);
    return text;
}

CommandText describe(const CLI::App& app, const std::string& above)
{
    CommandText text{.name = app.get_name(),
                     .path = above + app.get_name(),
                     .summary = app.get_description(),
                     .footer = app.get_footer(),
                     .positions = {},
                     .options = {},
                     .commands = {}};
    for (const CLI::Option* option : app.get_options())
        if (!option->get_group().empty())
            (option->get_positional() ? text.positions : text.options).push_back(describe(*option));
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
        if (!command->get_group().empty()) text.commands.push_back(describe(*command, text.path + " "));
    return text;
}

/// The innermost command that the command line names.
const CLI::App& chosen_in(const CLI::App& app)
{
    const CLI::App* chosen = &app;
    while (!chosen->get_subcommands().empty()) chosen = chosen->get_subcommands().front();
    return *chosen;
}

/// "accuracy study: " and "(oncollide accuracy study --help)", the ends of a message about a command.
std::pair<std::string, std::string> ends_for(const CLI::App& command)
{
    std::string path;
    const CLI::App* at = &command;
    for (; at->get_parent(); at = at->get_parent()) path = at->get_name() + (path.empty() ? "" : " ") + path;
    return {path.empty() ? "" : path + ": ",
            fmt::format("({} {}{}--help)", at->get_name(), path, path.empty() ? "" : " ")};
}

[[noreturn]] void refuse(const CLI::App& command, const std::string& why)
{
    const auto [place, help] = ends_for(command);
    usage(fmt::format("{}{} {}", place, why, help));
}

/// One line that says why the command line was refused.
std::string explain(const CLI::App& app, const CLI::ParseError& error)
{
    const CLI::App& command = chosen_in(app);
    const auto [place, help] = ends_for(command);
    const std::vector<std::string> extras = app.remaining(true);
    if (dynamic_cast<const CLI::ExtrasError*>(&error) && !extras.empty()) {
        const std::string word = extras.front().substr(0, extras.front().find('='));
        const std::vector<std::string> commands = command_names(command), options = option_names(command);
        if (!word.starts_with("-"))
            return commands.empty() ? fmt::format("{}unexpected argument '{}' {}", place, word, help)
                                    : fmt::format("{}unknown command '{}'{} {}", place, word,
                                                  valid_names(word, views(commands), "commands"), help);
        const std::string near = did_you_mean(word, views(options));
        return fmt::format("{}unknown option '{}'{} {}", place, word,
                           near.empty() ? "; valid: " + joined(options) : near, help);
    }
    std::string text = error.what();
    std::replace(text.begin(), text.end(), '\n', ' ');
    if (const std::size_t at = text.find(": 1 required "); at != std::string::npos && text.ends_with(" missing"))
        text = fmt::format("{} needs a {}", text.substr(0, at), text.substr(at + 13, text.size() - at - 21));
    if (const std::size_t at = text.find(": At Most 1 required"); at != std::string::npos)
        text = text.substr(0, at) + " is given more than once";
    return fmt::format("{}{} {}", place, text, help);
}

/// An empty value comes from an unset variable of the shell; to most commands it would mean that nothing was given.
[[noreturn]] void refuse_empty(const CLI::App& command, const CLI::Option& option)
{
    refuse(command, option.get_name() + ": the value is empty; is a shell variable not set?");
}

/// Options were checked by words_of().
void check_positions(const CLI::App& command)
{
    for (const CLI::App* at = &command; at; at = at->get_parent())
        for (const CLI::Option* option : at->get_options())
            if (option->get_positional() && std::ranges::count(option->results(), "")) refuse_empty(*at, *option);
}

/// True for lists such as "1,,2", and for the empty list. CLI11 skips empty parts.
bool has_empty_part(const std::string& list, char comma)
{
    return (comma + list + comma).find(std::string(2, comma)) != std::string::npos;
}

bool is_number(const std::string& text)
{
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc{} && end == text.data() + text.size();
}

/// The words of the command line in a form that CLI11 reads as people mean it.
std::vector<std::string> words_of(const CLI::App& app, std::vector<std::string> given)
{
    if (given.front() == "version") given.front() = "--version";
    if (given.front() == "help") given.erase(given.begin()), given.push_back("--help");
    std::vector<std::string> words;
    const CLI::App* command = &app;
    const CLI::Option* option = nullptr; // the next word is its value
    for (std::size_t i = 0; i < given.size(); ++i) {
        std::string word = given[i];
        if (option) {
            const bool length = option->get_type_name() == "M" || option->get_type_name() == "LENGTH";
            const bool has_unit = i + 1 < given.size() && is_number(word) && find_unit(given[i + 1]);
            if (length && has_unit) word += given[++i]; // joins 2 and mm
            if (word.empty() || (option->get_delimiter() && has_empty_part(word, option->get_delimiter())))
                refuse_empty(*command, *option);
            option = nullptr;
        } else if (word == "--") {
            words.insert(words.end(), given.begin() + std::ptrdiff_t(i), given.end());
            break;
        } else if (word.starts_with("-")) {
            const bool no_value = word.starts_with("--") && word.find('=') == word.size() - 1;
            option = command->get_option_no_throw(no_value ? word.substr(0, word.size() - 1) : word);
            if (option && option->get_items_expected_max() == 0) option = nullptr;
            // CLI11 would take the word after "--option=" as the value.
            if (option && no_value) refuse_empty(*command, *option);
        } else if (const auto below =
                       command->get_subcommands([&](const CLI::App* each) { return each->get_name() == word; });
                   !below.empty()) {
            command = below.front();
        }
        words.push_back(word);
    }
    return words;
}

/// CLI11 reads -1 as 2^64 - 1, and clamps numbers that are too large.
std::string not_natural(const std::string& text)
{
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc{} && end == text.data() + text.size()) return {};
    return fmt::format("{} is not a whole number from 0 to 2^64 - 1", text);
}

} // namespace

Option Option::required()
{
    option_->required();
    return *this;
}

Option Option::expected(int least, int most)
{
    option_->expected(least, most);
    return *this;
}

Option Option::repeatable()
{
    option_->expected(1)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    return *this;
}

Option Option::separated_by(char comma)
{
    option_->delimiter(comma)->allow_extra_args(false);
    return *this;
}

Option Option::length()
{
    option_->type_name("M")->description(option_->get_description() + "; metres, or such as 1mm or 0.1in");
    option_->transform([option = option_](const std::string& text) {
        constexpr std::string_view of_numbers = "0123456789.+-eE";
        const std::size_t unit = text.find_first_not_of(of_numbers);
        if (unit == text.npos || unit == 0) return text; // a number, or no length at all: CLI11 reads or refuses it
        return fmt::format("{}", length_from(option->get_name(), text, unit_from("", "m")));
    });
    return *this;
}

Option Option::needs(Option other)
{
    option_->needs(other.option_);
    return *this;
}

bool Option::given() const
{
    return option_->count() > 0;
}

Arguments Arguments::add_command(const std::string& name, const std::string& summary)
{
    CLI::App* const command = app_->add_subcommand(name, summary);
    command->option_defaults()->group("Options");
    return {command, chosen_};
}

template <class Value>
Option Arguments::add_option(const std::string& names, Value& value, const std::string& help)
{
    const std::size_t space = names.find(' ');
    CLI::Option* const option = app_->add_option(names.substr(0, space), value, help);
    if (space != names.npos) option->type_name(names.substr(space + 1));
    if constexpr (std::is_same_v<Value, std::uint64_t> || std::is_same_v<Value, std::optional<std::uint64_t>>)
        option->check(&not_natural);
    return Option(option);
}

template Option Arguments::add_option(const std::string&, int&, const std::string&);
template Option Arguments::add_option(const std::string&, long&, const std::string&);
template Option Arguments::add_option(const std::string&, double&, const std::string&);
template Option Arguments::add_option(const std::string&, std::uint64_t&, const std::string&);
template Option Arguments::add_option(const std::string&, std::string&, const std::string&);
template Option Arguments::add_option(const std::string&, std::optional<int>&, const std::string&);
template Option Arguments::add_option(const std::string&, std::optional<double>&, const std::string&);
template Option Arguments::add_option(const std::string&, std::optional<std::uint64_t>&, const std::string&);
template Option Arguments::add_option(const std::string&, std::optional<std::string>&, const std::string&);
template Option Arguments::add_option(const std::string&, std::vector<int>&, const std::string&);
template Option Arguments::add_option(const std::string&, std::vector<std::string>&, const std::string&);

Option Arguments::add_flag(const std::string& name, bool& value, const std::string& help)
{
    return Option(app_->add_flag(name, value, help));
}

void Arguments::remove_option(const std::string& name)
{
    app_->remove_option(app_->get_option(name));
}

void Arguments::footer(const std::string& text)
{
    app_->footer(text);
}

void Arguments::group(const std::string& name)
{
    app_->option_defaults()->group(name);
}

void Arguments::hide()
{
    app_->group("");
}

void Arguments::at_most_one_command()
{
    app_->require_subcommand(0, 1);
}

void Arguments::refuse_command(const std::string& name, const std::string& why)
{
    CLI::App* const command = app_->add_subcommand(name)->group("");
    command->set_help_flag();
    command->prefix_command();
    Arguments(command, chosen_).action([why]() -> int { usage(why); });
}

void Arguments::action(Command command)
{
    app_->callback([app = app_, chosen = chosen_, command = std::move(command)] {
        if (app->get_subcommands().empty()) *chosen = command;
    });
}

CommandText Arguments::describe_program() const
{
    const CLI::App* program = app_;
    while (program->get_parent()) program = program->get_parent();
    return describe(*program, "");
}

CommandLine::CommandLine(const std::string& program, const std::string& summary, const std::string& version)
    : app_(std::make_unique<CLI::App>(summary, program))
{
    app_->set_help_flag("-h,--help", "print this help");
    app_->set_version_flag("--version", version, "print version and build");
    app_->option_defaults()->group("Options");
}

CommandLine::~CommandLine() = default;

Arguments CommandLine::arguments()
{
    return {app_.get(), &chosen_};
}

Command CommandLine::parse(int argc, char** argv)
{
    const std::vector<std::string> names = command_names(*app_);
    const auto refuse = [](const std::string& why) { throw Error(ErrorKind::usage, why); };
    if (argc < 2) {
        const bool has_demo = std::ranges::find(names, "demo") != names.end();
        refuse(fmt::format("no command given; {}{}",
                           has_demo ? "try 'oncollide demo', or one of: " : "commands: ", joined(names)));
    }
    std::vector<std::string> words = words_of(*app_, {argv + 1, argv + argc});
    const std::string first = words.front();
    const auto nothing = [] { return 0; };
    const auto is_first = [&](const CLI::App* command) { return command->get_name() == first; };
    if (!first.starts_with("-") && std::as_const(*app_).get_subcommands(is_first).empty())
        refuse(fmt::format("unknown command '{}'{}", first, valid_names(first, views(names), "commands")));
    try {
        std::ranges::reverse(words); // CLI11 wants them in reverse
        app_->parse(std::move(words));
    } catch (const CLI::CallForHelp&) {
        const CLI::App* command = &chosen_in(*app_);
        std::string above;
        for (const CLI::App* over = command->get_parent(); over; over = over->get_parent())
            above = over->get_name() + " " + above;
        write_to_stdout(help_text(describe(*command, above), terminal_width()));
        return nothing;
    } catch (const CLI::Success& wanted) { // --version
        write_to_stdout(fmt::format("{}\n", wanted.what()));
        return nothing;
    } catch (const CLI::ParseError& error) {
        check_positions(chosen_in(*app_)); // these errors come before any missing argument
        refuse(explain(*app_, error));
    }
    check_positions(chosen_in(*app_));
    if (!chosen_) refuse("no command given; commands: " + joined(names));
    return chosen_;
}

void usage(const std::string& message)
{
    throw Error(ErrorKind::usage, message);
}

void check_range(const char* option, std::int64_t value, std::int64_t least, std::int64_t most)
{
    if (value >= least && value <= most) return;
    const bool open = most == std::numeric_limits<std::int64_t>::max();
    usage(fmt::format("{} {}: must be {}", option, value,
                      open ? fmt::format("at least {}", least) : fmt::format("from {} to {}", least, most)));
}

} // namespace oncollide::tools

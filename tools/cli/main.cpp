// The oncollide command: subcommands are added here, each lives in a file of its own.
#include "cli/command.hpp"

#include <iostream>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/report.hpp>

namespace oncollide::tools {
namespace {

/// Steps from one word to the other by adding, dropping or changing a letter.
std::size_t edit_distance(const std::string& a, const std::string& b)
{
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = std::exchange(row[0], i);
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t changed = diagonal + (a[i - 1] != b[j - 1]);
            diagonal = row[j];
            row[j] = std::min({changed, row[j] + 1, row[j - 1] + 1});
        }
    }
    return row.back();
}

/// "; did you mean '--depth'?", or nothing when no candidate is near.
std::string hint(const std::string& word, const std::vector<std::string>& candidates)
{
    std::string best;
    std::size_t least = word.size() < 3   ? 2
                        : word.size() < 6 ? 3
                                          : 4; // no more letters may be wrong than this, less one
    for (const std::string& candidate : candidates)
        if (const std::size_t distance = edit_distance(word, candidate); distance < least)
            least = distance, best = candidate;
    return best.empty() ? "" : fmt::format("; did you mean '{}'?", best);
}

std::string joined(const std::vector<std::string>& words)
{
    std::string result;
    for (const std::string& word : words) result += (result.empty() ? "" : ", ") + word;
    return result;
}

std::vector<std::string> command_names(const CLI::App& app)
{
    std::vector<std::string> names;
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
        names.push_back(command->get_name());
    return names;
}

std::vector<std::string> option_names(const CLI::App& command)
{
    std::vector<std::string> names;
    for (const CLI::Option* option : command.get_options())
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    return names;
}

/// One line that says what is wrong with the command line.
std::string explain(const CLI::App& app, const CLI::ParseError& error)
{
    const CLI::App* chosen = &app;
    std::string path; // "bench many "
    while (!chosen->get_subcommands().empty()) {
        chosen = chosen->get_subcommands().front();
        path += chosen->get_name() + " ";
    }
    const CLI::App& command = *chosen;
    const std::string place = path.empty() ? "" : path.substr(0, path.size() - 1) + ": ";
    const std::string help = fmt::format("(oncollide {}--help)", path);
    const std::vector<std::string> extras = app.remaining(true);
    if (dynamic_cast<const CLI::ExtrasError*>(&error) && !extras.empty()) {
        const std::string word = extras.front().substr(0, extras.front().find('='));
        if (!word.starts_with("-")) return fmt::format("{}unexpected argument '{}' {}", place, word, help);
        const std::string near = hint(word, option_names(command));
        return fmt::format("{}unknown option '{}'{} {}", place, word,
                           near.empty() ? "; valid: " + joined(option_names(command)) : near, help);
    }
    std::string text = error.what();
    std::replace(text.begin(), text.end(), '\n', ' ');
    if (const std::size_t at = text.find(": 1 required "); at != std::string::npos && text.ends_with(" missing"))
        text = fmt::format("{} needs a {}", text.substr(0, at), text.substr(at + 13, text.size() - at - 21));
    if (const std::size_t at = text.find(": At Most 1 required"); at != std::string::npos)
        text = text.substr(0, at) + " is given more than once";
    return fmt::format("{}{} {}", place, text, help);
}

int report_usage(const std::string& message)
{
    std::cerr << "oncollide: " << message << "\n";
    return int(ErrorKind::usage);
}

int parse_and_run(int argc, char** argv)
{
    CLI::App app{"Finds which bodies of a large environment collide, frame by frame, at a certified accuracy.",
                 "oncollide"};
    app.set_version_flag("--version", fmt::format("oncollide {}", version));
    app.footer(
        "Exit codes: 0 success, 64 usage, 65 bad data, 66 no input, 70 internal fault, 71 no GPU, 73 cannot write,\n"
        "130 interrupted. 'check' answers with 0 separate, 1 colliding, 2 within or undecided.\n"
        "Start with:  oncollide demo\n"
        "Then:        oncollide COMMAND --help");
    Command command;
    add_demo(app, command);
    add_run(app, command);
    add_render(app, command);
    add_check(app, command);
    add_scene(app, command);
    add_spheres(app, command);
    add_bench(app, command);
    add_accuracy(app, command);
    add_doctor(app, command);

    const std::vector<std::string> names = command_names(app);
    if (argc < 2) return report_usage("no command given; try 'oncollide demo', or one of: " + joined(names));
    const std::string first = argv[1];
    if (first == "help") {
        std::cout << app.help();
        return 0;
    }
    if (!first.starts_with("-") && std::find(names.begin(), names.end(), first) == names.end())
        return report_usage(fmt::format("unknown command '{}'{} commands: {}", first,
                                        hint(first, names).empty() ? ";" : hint(first, names), joined(names)));
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& wanted) { // --help and --version
        app.exit(wanted, std::cout, std::cerr);
        return 0;
    } catch (const CLI::ParseError& error) {
        return report_usage(explain(app, error));
    }
    return command ? command() : report_usage("no command given; commands: " + joined(names));
}

} // namespace
} // namespace oncollide::tools

int main(int argc, char** argv)
{
    using namespace oncollide;
    try {
        int code = tools::parse_and_run(argc, argv);
        if (!std::cout.flush()) throw Error(ErrorKind::cannot_write, "standard output: cannot write");
        return code;
    } catch (const Error& error) {
        std::cerr << "oncollide: " << error.what() << "\n";
        return int(error.kind());
    } catch (const std::bad_alloc&) {
        std::cerr << "oncollide: out of memory\n";
    } catch (const std::exception& error) {
        std::cerr << "oncollide: internal fault: " << error.what() << "\n";
    }
    return int(ErrorKind::internal);
}

// oncollide reference: the source of pages, man pages and completions. Hidden from --help: only the build needs it.
#include "commands/reference.hpp"

#include <filesystem>
#include <memory>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/text/near_word.hpp>
#include <oncollide/pipeline/settings_table.hpp>
#include <oncollide/runs/report.hpp>
#include <oncollide/samples/catalogue.hpp>

#include "cli/command.hpp"

namespace oncollide::tools {
namespace {

namespace fs = std::filesystem;

std::string joined_names(const OptionText& option)
{
    std::string names;
    for (const std::string& name : option.names) names += (names.empty() ? "" : ", ") + name;
    return option.value.empty() ? names : names + " " + option.value;
}

/// Escapes characters that Markdown interprets: in code within a table, only the bar.
std::string escaped_markdown(std::string_view text, std::string_view interpreted = "|<*_")
{
    std::string result;
    for (const char c : text) {
        if (interpreted.find(c) != std::string_view::npos) result += '\\';
        result += c;
    }
    return result;
}

void add_rows(std::string& out, const std::vector<OptionText>& options, std::string_view heading)
{
    if (options.empty()) return;
    out += fmt::format("\n| {} | |\n|---|---|\n", heading);
    for (const OptionText& option : options) {
        out += fmt::format("| `{}` | {}{} |\n", escaped_markdown(joined_names(option), "|"),
                           escaped_markdown(option.help), option.required ? " (required)" : "");
    }
}

void add_section(std::string& out, const CommandText& command)
{
    out += fmt::format("\n## {}\n\n{}\n\n```\n{}\n```\n", command.path, escaped_markdown(command.summary),
                       usage_of(command));
    add_rows(out, command.positions, "argument");
    std::vector<std::string> groups;
    for (const OptionText& option : command.options)
        if (std::find(groups.begin(), groups.end(), option.group) == groups.end()) groups.push_back(option.group);
    for (const std::string& group : groups) {
        std::vector<OptionText> options;
        for (const OptionText& option : command.options)
            if (option.group == group) options.push_back(option);
        add_rows(out, options, group);
    }
    if (!command.footer.empty()) out += fmt::format("\n```\n{}\n```\n", command.footer);
    for (const CommandText& below : command.commands) add_section(out, below);
}

/// Escapes for roff: dashes that are not hyphens, backslashes, and a dot or an apostrophe at the start of a line.
std::string escaped_roff(std::string_view text)
{
    std::string result;
    bool line_begins = true;
    for (const char c : text) {
        if (line_begins && (c == '.' || c == '\'')) result += "\\&";
        if (c == '\\')
            result += "\\e";
        else if (c == '-')
            result += "\\-";
        else
            result += c;
        line_begins = c == '\n';
    }
    return result;
}

std::string page_name(const CommandText& command)
{
    std::string name = command.path;
    for (char& c : name)
        if (c == ' ') c = '-';
    return name;
}

void write_man_pages(const CommandText& command, const CommandText& program, const fs::path& folder)
{
    OutputFile file(folder / (page_name(command) + ".1"));
    file.write(man_page_of(command, program));
    file.commit();
    for (const CommandText& below : command.commands) write_man_pages(below, program, folder);
}

struct ReferenceOptions {
    std::string what, out = "-";
};

int reference(const ReferenceOptions& options, const CommandText& program)
{
    std::vector<std::string> scenes;
    for (const CatalogueEntry& entry : catalogue()) scenes.push_back(entry.name);
    std::string text;
    if (options.what == "man") {
        if (options.out == "-") usage("reference man: needs --out FOLDER");
        write_man_pages(program, program, options.out);
        return 0;
    }
    if (options.what == "markdown")
        text = markdown_of(program);
    else if (options.what == "settings")
        text = settings_markdown();
    else if (options.what == "bash")
        text = bash_completion_of(program, scenes);
    else if (options.what == "zsh")
        text = zsh_completion_of(program, scenes);
    else if (options.what == "fish")
        text = fish_completion_of(program, scenes);
    else
        usage(fmt::format("reference: no '{}'{}", options.what,
                          valid_names(options.what, {"markdown", "settings", "man", "bash", "zsh", "fish"})));
    OutputFile file(options.out);
    file.write(text);
    file.commit();
    return 0;
}

} // namespace

std::string markdown_of(const CommandText& program)
{
    std::string out = fmt::format("# Reference of {0}\n\nGenerated from the options of {0} {1}; every command prints "
                                  "its part with `--help`. For what all commands share see "
                                  "[command-line.md](command-line.md).\n",
                                  program.path, version);
    add_section(out, program);
    return out;
}

std::string settings_markdown()
{
    std::string out =
        "| `Settings`, Python | option | JSON | meaning | default | changes results |\n|---|---|---|---|---|---|\n";
    for (const SettingRow& row : settings_table()) {
        out += fmt::format("| `{}` | `{}{}{}` | `{}` | {} | {} | {} |\n", row.member, row.option(),
                           row.value.empty() ? "" : " ", escaped_markdown(row.value, "|"), row.key,
                           escaped_markdown(row.help), row.by_default, row.affects_results ? "yes" : "no");
    }
    return out;
}

std::string man_page_of(const CommandText& command, const CommandText& program)
{
    std::string title = page_name(command), out;
    for (char& c : title) c = char(std::toupper(static_cast<unsigned char>(c)));
    out += fmt::format(".TH {} 1 \"\" \"oncollide {}\" \"User Commands\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n.B {}\n",
                       escaped_roff(title), version, escaped_roff(page_name(command)), escaped_roff(command.summary),
                       escaped_roff(usage_of(command)));
    const auto add_options = [&](const std::vector<OptionText>& options) {
        for (const OptionText& option : options)
            out += fmt::format(".TP\n.B {}\n{}{}\n", escaped_roff(joined_names(option)), escaped_roff(option.help),
                               option.required ? " (required)" : "");
    };
    if (!command.positions.empty()) out += ".SH ARGUMENTS\n";
    add_options(command.positions);
    out += ".SH OPTIONS\n";
    add_options(command.options);
    if (!command.commands.empty()) out += ".SH COMMANDS\n";
    for (const CommandText& below : command.commands)
        out += fmt::format(".TP\n.BR {} (1)\n{}\n", escaped_roff(page_name(below)), escaped_roff(below.summary));
    if (!command.footer.empty()) out += fmt::format(".SH NOTES\n.nf\n{}\n.fi\n", escaped_roff(command.footer));
    if (command.path != program.path)
        out += fmt::format(".SH SEE ALSO\n.BR {} (1)\n", escaped_roff(page_name(program)));
    return out;
}

void add_reference(Arguments app)
{
    Arguments sub = app.add_command("reference", "Write the reference of all commands, generated from their options");
    sub.hide();
    auto options = std::make_shared<ReferenceOptions>();
    sub.add_option("what markdown|settings|man|bash|zsh|fish", options->what,
                   "a page, man pages, or completions for a shell")
        .required();
    sub.add_option("--out FILE", options->out, "file (for man pages: folder) to write (default: standard output)");
    sub.action([options, sub] { return reference(*options, sub.describe_program()); });
}

} // namespace oncollide::tools

// The text of --help for a terminal, from the same descriptions as the reference pages (reference.cpp).
#include <algorithm>

#include <fmt/format.h>

#include "cli/arguments.hpp"

namespace oncollide::tools {
namespace {

constexpr std::size_t indent = 26; ///< column of the options' descriptions

/// Appends `text` from column `column`; following lines begin at column `left`. Ends the last line.
void wrap(std::string& out, std::string_view text, std::size_t column, std::size_t left, std::size_t width)
{
    bool first = true; // first word of its line
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find(' ', at), text.size());
        const std::string_view word = text.substr(at, end - at);
        at = end + 1;
        if (!first && column + 1 + word.size() > width) {
            out += '\n' + std::string(left, ' ');
            column = left, first = true;
        }
        if (!first) out += ' ', ++column;
        out += word, column += word.size(), first = false;
    }
    out += '\n';
}

void add_row(std::string& out, const std::string& name, const std::string& text, std::size_t width)
{
    out += "  " + name;
    std::size_t column = 2 + name.size();
    if (column + 2 > indent) out += '\n', column = 0;
    out += std::string(indent - column, ' ');
    wrap(out, text, indent, indent, width);
}

std::string row_name(const OptionText& option)
{
    std::string name;
    for (const std::string& each : option.names) name += (name.empty() ? "" : ", ") + each;
    return option.value.empty() ? name : name + " " + option.value;
}

std::string row_text(const OptionText& option)
{
    return option.help + (option.required && option.names.front().starts_with("-") ? " (required)" : "");
}

/// Lines up to a line that ends a sentence form one paragraph. Lines that begin with spaces (examples, tables) are kept
/// as they are.
void add_footer(std::string& out, std::string_view text, std::size_t width)
{
    std::string paragraph;
    const auto end_paragraph = [&] {
        if (!paragraph.empty()) wrap(out, paragraph, 0, 0, width);
        paragraph.clear();
    };
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        const std::string_view line = text.substr(at, end - at);
        at = end + 1;
        if (line.empty() || line.starts_with(' ')) {
            end_paragraph();
            out.append(line) += '\n';
            continue;
        }
        if (!paragraph.empty()) paragraph += ' ';
        paragraph += line;
        if (line.ends_with('.') || line.ends_with(':')) end_paragraph();
    }
    end_paragraph();
}

} // namespace

std::string usage_of(const CommandText& command)
{
    std::string usage = command.path;
    if (!command.options.empty()) usage += " [OPTIONS]";
    for (const OptionText& position : command.positions) {
        const std::string name = position.names.front() + (position.repeatable ? "..." : "");
        usage += position.required ? " " + name : " [" + name + "]";
    }
    return usage + (command.commands.empty() ? "" : command.positions.empty() ? " COMMAND" : " [COMMAND]");
}

std::string help_text(const CommandText& command, std::size_t width)
{
    std::string out;
    wrap(out, command.summary, 0, 0, width);
    out += fmt::format("\nUsage: {}\n", usage_of(command));

    if (!command.positions.empty()) out += '\n';
    for (const OptionText& position : command.positions) add_row(out, row_name(position), row_text(position), width);
    if (!command.commands.empty()) out += "\nCommands:\n";
    for (const CommandText& below : command.commands) add_row(out, below.name, below.summary, width);
    std::vector<std::string> groups; // in the order of their first option
    for (const OptionText& option : command.options)
        if (std::ranges::find(groups, option.group) == groups.end()) groups.push_back(option.group);
    for (const std::string& group : groups) {
        out += fmt::format("\n{}:\n", group);
        for (const OptionText& option : command.options)
            if (option.group == group) add_row(out, row_name(option), row_text(option), width);
    }
    if (!command.footer.empty()) out += '\n';
    add_footer(out, command.footer, width);
    return out;
}

} // namespace oncollide::tools

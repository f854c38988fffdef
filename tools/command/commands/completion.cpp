// Shell completion: which command the preceding words name, and which words may follow.
#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "commands/reference.hpp"

namespace oncollide::tools {
namespace {

/// The completions of an option's value or of a positional argument.
struct Values {
    std::vector<std::string> words;
    bool files = false, folders = false;
};

/// Derived from the value's name in --help: lower-case words between bars are the values themselves; FILE and DIR are
/// paths.
Values values_of(const OptionText& option, const std::vector<std::string>& scenes)
{
    Values values;
    const std::string& text = option.value;
    for (std::size_t at = 0; at <= text.size() && text.find('|') != std::string::npos;) {
        const std::size_t end = std::min(text.find('|', at), text.size());
        const std::string word = text.substr(at, end - at);
        if (std::ranges::none_of(word, [](unsigned char c) { return std::isupper(c); })) values.words.push_back(word);
        at = end + 1;
    }
    if (text.find("NAME") != std::string::npos && option.names.front().find("-") == std::string::npos)
        values.words = scenes;
    values.folders = text.starts_with("DIR");
    for (const char* kind : {"FILE", "MESH", ".json", ".glb", ".csv", ".h5", ".html"})
        values.files |= text.find(kind) != std::string::npos;
    return values;
}

std::vector<std::string> names_of(const std::vector<OptionText>& options)
{
    std::vector<std::string> names;
    for (const OptionText& option : options) names.insert(names.end(), option.names.begin(), option.names.end());
    return names;
}

/// All commands, the program first.
std::vector<const CommandText*> all_of(const CommandText& command)
{
    std::vector<const CommandText*> all{&command};
    for (const CommandText& below : command.commands)
        for (const CommandText* each : all_of(below)) all.push_back(each);
    return all;
}

/// "_oncollide": the name of the function that completes the program's words.
std::string function_of(const CommandText& program)
{
    std::string name = "_" + program.path;
    std::ranges::replace(name, '-', '_');
    return name;
}

/// The paths of all commands below the program, quoted and joined by `between`.
std::string paths_of(const CommandText& program, std::string_view between)
{
    std::string paths;
    for (const CommandText* command : all_of(program))
        if (command != &program) paths += fmt::format("{}'{}'", paths.empty() ? "" : between, command->path);
    return paths;
}

/// Escapes text for single quotes of zsh, in a specification of _arguments.
std::string zsh_text(std::string_view text)
{
    std::string result;
    for (const char c : text) {
        if (c == '\'') {
            result += "'\\''";
            continue;
        }
        if (c == '[' || c == ']' || c == ':' || c == '\\') result += '\\';
        result += c;
    }
    return result;
}

/// Escapes text for single quotes of fish.
std::string fish_text(std::string_view text)
{
    std::string result;
    for (const char c : text) {
        if (c == '\'' || c == '\\') result += '\\';
        result += c;
    }
    return result;
}

} // namespace

std::string bash_completion_of(const CommandText& program, const std::vector<std::string>& scenes)
{
    const std::string function = function_of(program);
    std::string out = fmt::format("# Completion of {0} for bash.\n{1}() {{\n"
                                  "    local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} "
                                  "path={0} i words=\n"
                                  "    for ((i = 1; i < COMP_CWORD; i++)); do\n"
                                  "        case \"$path ${{COMP_WORDS[i]}}\" in\n"
                                  "        {2}) path+=\" ${{COMP_WORDS[i]}}\" ;;\n        esac\n    done\n"
                                  "    case $path in\n",
                                  program.path, function, paths_of(program, " | "));
    for (const CommandText* command : all_of(program)) {
        out += fmt::format("    '{}')\n        case $before in\n", command->path);
        for (const OptionText& option : command->options) {
            if (option.value.empty()) continue;
            const Values values = values_of(option, scenes);
            out += fmt::format("        {}) ", fmt::join(option.names, " | "));
            if (!values.words.empty())
                out += fmt::format("COMPREPLY=($(compgen -W '{}' -- \"$word\")); return ;;\n",
                                   fmt::join(values.words, " "));
            else if (values.folders)
                out += "COMPREPLY=($(compgen -d -- \"$word\")); return ;;\n";
            else
                out += fmt::format("{}return ;;\n", values.files ? "COMPREPLY=($(compgen -f -- \"$word\")); " : "");
        }
        std::vector<std::string> words = names_of(command->options);
        for (const CommandText& below : command->commands) words.push_back(below.name);
        bool files = false;
        for (const OptionText& position : command->positions) {
            const Values values = values_of(position, scenes);
            words.insert(words.end(), values.words.begin(), values.words.end()), files |= values.files;
        }
        out += fmt::format("        esac\n        words='{}'\n", fmt::join(words, " "));
        if (files) out += "        [[ $word == -* ]] || COMPREPLY=($(compgen -f -- \"$word\"))\n";
        out += "        ;;\n";
    }
    return out + fmt::format("    esac\n    COMPREPLY+=($(compgen -W \"$words\" -- \"$word\"))\n}}\n"
                             "complete -o filenames -F {} {}\n",
                             function, program.path);
}

std::string zsh_completion_of(const CommandText& program, const std::vector<std::string>& scenes)
{
    const auto action = [&](const OptionText& option) {
        const Values values = values_of(option, scenes);
        if (!values.words.empty() && values.files)
            return fmt::format("{{compadd {}; _files}}", fmt::join(values.words, " "));
        if (!values.words.empty()) return fmt::format("({})", fmt::join(values.words, " "));
        return std::string(values.files ? "_files" : values.folders ? "_files -/" : "");
    };
    const std::string function = function_of(program);
    std::string out = fmt::format("#compdef {0}\n{1}() {{\n    local path={0}\n"
                                  "    while (( CURRENT > 2 )); do\n        case \"$path $words[2]\" in\n"
                                  "        ({2}) path=\"$path $words[2]\"; shift words; (( CURRENT-- )) ;;\n"
                                  "        (*) break ;;\n        esac\n    done\n    case $path in\n",
                                  program.path, function, paths_of(program, "|"));
    for (const CommandText* command : all_of(program)) {
        out += fmt::format("    ('{}')\n        _arguments", command->path);
        for (const OptionText& option : command->options)
            for (const std::string& name : option.names)
                out += fmt::format(
                    " \\\n            '{}{}[{}]{}'", option.repeatable ? "*" : "", name, zsh_text(option.help),
                    option.value.empty() ? "" : fmt::format(":{}:{}", zsh_text(option.value), action(option)));
        std::string commands;
        for (const CommandText& below : command->commands) commands += (commands.empty() ? "" : " ") + below.name;
        if (!commands.empty()) out += fmt::format(" \\\n            '1:command:({})'", commands);
        if (commands.empty())
            for (const OptionText& position : command->positions)
                out += fmt::format(" \\\n            '{}:{}:{}'", position.repeatable ? "*" : "",
                                   zsh_text(position.names.front()), action(position));
        out += " ;;\n";
    }
    return out + fmt::format("    esac\n}}\n{} \"$@\"\n", function);
}

std::string fish_completion_of(const CommandText& program, const std::vector<std::string>& scenes)
{
    std::string out =
        fmt::format("# Completion of {0} for fish.\nfunction _{1}_path\n"
                    "    set -l path {0}\n    for word in (commandline -opc)[2..-1]\n"
                    "        switch \"$path $word\"\n            case {2}\n"
                    "                set path \"$path $word\"\n        end\n    end\n    echo $path\nend\n",
                    program.path, function_of(program), paths_of(program, " "));
    for (const CommandText* command : all_of(program)) {
        const std::string start = fmt::format("complete -c {} -n 'test (_{}_path) = \"{}\"'", program.path,
                                              function_of(program), command->path);
        if (std::ranges::none_of(command->positions, [&](const OptionText& p) { return values_of(p, scenes).files; }))
            out += start + " -f\n";
        for (const CommandText& below : command->commands)
            out += fmt::format("{} -f -a {} -d '{}'\n", start, below.name, fish_text(below.summary));
        for (const OptionText& position : command->positions)
            if (const Values values = values_of(position, scenes); !values.words.empty())
                out += fmt::format("{} -a '{}'\n", start, fmt::join(values.words, " "));
        for (const OptionText& option : command->options) {
            out += start;
            for (const std::string& name : option.names)
                out += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
            const Values values = values_of(option, scenes);
            if (!values.words.empty())
                out += fmt::format(" -x -a '{}'", fmt::join(values.words, " "));
            else if (!option.value.empty())
                out += values.files || values.folders ? " -r -F" : " -x";
            out += fmt::format(" -d '{}'\n", fish_text(option.help));
        }
    }
    return out;
}

} // namespace oncollide::tools

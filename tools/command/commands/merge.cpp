// oncollide merge: joins the files of all parts of a sweep into the file that a single process would have written.
#include "cli/command.hpp"
#include "cli/outputs.hpp"
#include "cli/shard.hpp"

#include <charconv>
#include <fstream>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/text/listed.hpp>
#include <oncollide/base/text/printable.hpp>

namespace oncollide::tools {
namespace {

constexpr std::string_view mark = "# oncollide shard ";

bool number_of(std::string_view text, int& number)
{
    const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc{} && rest == text.data() + text.size();
}

std::optional<Shard> parse(std::string_view text)
{
    Shard shard;
    const std::size_t slash = text.find('/');
    if (slash == std::string_view::npos || !number_of(text.substr(0, slash), shard.part) ||
        !number_of(text.substr(slash + 1), shard.parts) || shard.part < 1 || shard.part > shard.parts)
        return std::nullopt;
    return shard;
}

/// The file of a part, read up to its first row.
struct Part {
    std::string path, work, header;
    Shard shard;
    std::ifstream file;
};

Part open_part(const std::string& path)
{
    check_readable(path);
    Part part{.path = path, .work = {}, .header = {}, .shard = {}, .file = std::ifstream(path, std::ios::binary)};
    std::string line;
    std::getline(part.file, line);
    const std::size_t colon = line.find(": ");
    std::optional<Shard> shard;
    if (line.starts_with(mark) && colon != std::string::npos)
        shard = parse(std::string_view(line).substr(mark.size(), colon - mark.size()));
    if (!shard)
        refuse(path, "is not a part of a sweep: its first line does not name one (was it written with "
                     "--shard?)");
    part.shard = *shard, part.work = line.substr(colon + 2);
    if (!std::getline(part.file, part.header)) refuse(path, "ends before its header");
    return part;
}

void copy_rows(Part& part, OutputFile& out)
{
    std::vector<char> buffer(1 << 20);
    while (part.file.read(buffer.data(), std::streamsize(buffer.size())) || part.file.gcount())
        out.write({buffer.data(), std::size_t(part.file.gcount())});
    if (part.file.bad()) throw Error(ErrorKind::no_input, part.path + ": cannot read");
}

int merge(const std::string& out, const std::vector<std::string>& paths)
{
    check_files({{"--out", out}}, paths);
    std::vector<std::optional<Part>> parts;
    for (const std::string& path : paths) {
        Part part = open_part(path);
        if (parts.empty()) parts.resize(std::size_t(part.shard.parts));
        const std::optional<Part>* other = nullptr;
        for (const auto& known : parts)
            if (known) other = &known;
        if (other && ((*other)->work != part.work || (*other)->header != part.header ||
                      (*other)->shard.parts != part.shard.parts))
            refuse(path,
                   fmt::format("belongs to a different run than {}: '{}', {} parts; there '{}', {} parts",
                               (*other)->path, part.work, part.shard.parts, (*other)->work, (*other)->shard.parts));
        std::optional<Part>& place = parts[std::size_t(part.shard.part - 1)];
        if (place) refuse(path, fmt::format("is part {}, the same as {}", part.shard.part, place->path));
        place = std::move(part);
    }
    std::vector<std::string> missing;
    for (std::size_t k = 0; k < parts.size(); ++k)
        if (!parts[k]) missing.push_back(fmt::format("{}/{}", k + 1, parts.size()));
    if (!missing.empty()) throw Error(ErrorKind::no_input, "merge: parts are missing: " + listed(missing));
    OutputFile file(out);
    file.write(parts.front()->header + "\n");
    for (auto& part : parts) copy_rows(*part, file);
    file.commit();
    return 0;
}

} // namespace

std::string Shard::line(const std::string& work) const
{
    return whole() ? "" : fmt::format("{}{}/{}: {}\n", mark, part, parts, printable(work));
}

void check_parts(const Shard& shard, std::size_t items, const char* what)
{
    if (!shard.whole() && std::size_t(shard.parts) > items)
        usage(fmt::format("--shard {}/{}: there are {} {} to divide", shard.part, shard.parts, items, what));
}

Shard shard_from(const std::string& text)
{
    if (text.empty()) return {};
    if (const std::optional<Shard> shard = parse(text)) return *shard;
    usage(fmt::format("--shard {}: expected I/N: part I of N, with I from 1 to N", text));
}

void add_merge(Arguments app)
{
    struct MergeOptions {
        std::string out;
        std::vector<std::string> parts;
    };
    Arguments sub = app.add_command("merge", "Join the CSV files of all parts of a sweep (--shard) into one");
    auto options = std::make_shared<MergeOptions>();
    sub.add_option("parts PART.csv", options->parts, "the files of all parts, in any order").required();
    sub.add_option("--out FILE", options->out, "joined file; '-' is standard output").required();
    sub.footer("Example:\n"
               "  for i in 1 2 3 4; do oncollide run city --shard $i/4 --csv part$i.csv & done; wait\n"
               "  oncollide merge part*.csv --out city.csv\n"
               "The result is byte for byte the file that 'oncollide run city --csv city.csv' writes. See\n"
               "docs/many-processes.md for GNU parallel and Slurm.");
    sub.action([options] { return merge(options->out, options->parts); });
}

} // namespace oncollide::tools

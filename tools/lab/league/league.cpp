// oncollide-lab league: judges libraries of collision detection by the same certified cases.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <set>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/files/paths.hpp>
#include <oncollide/base/text/near_word.hpp>
#include <oncollide/base/text/number_text.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/base/threads/parallel.hpp>

#include "cli/log.hpp"
#include "cli/progress.hpp"
#include "cli/standard_output.hpp"
#include "commands/lab.hpp"
#include "common/text.hpp"
#include "league/adapter.hpp"
#include "league/league_report.hpp"

namespace oncollide::tools {
namespace {

struct LeagueOptions {
    std::vector<std::string> families, libraries, adapters;
    std::string out, write;
    std::int64_t cases = 1000, seed = -1;
    int threads = 0;
    bool list = false, answers = false, quiet = false;
};

/// Keeps the named items, in the order of all; no names: all. Throws Error{usage} with the valid names.
template <class Item, class Name>
void keep_named(const char* option, std::vector<Item>& items, const std::vector<std::string>& wanted, Name name)
{
    std::vector<std::string_view> known;
    for (const Item& item : items) known.push_back(name(item));
    for (const std::string& one : wanted)
        if (std::ranges::find(known, one) == known.end())
            usage(fmt::format("{}: unknown '{}'{}", option, printable(one), valid_names(one, known, "valid")));
    if (wanted.empty()) return;
    std::erase_if(items, [&](const Item& item) { return std::ranges::find(wanted, name(item)) == wanted.end(); });
}

std::vector<LeagueEntry> entries_of(const LeagueOptions& o)
{
    std::vector<std::string> files = o.adapters;
    if (files.empty())
        for (const auto& file : known_adapters()) files.push_back(file.string());
    if (files.empty())
        throw Error(
            ErrorKind::no_input,
            "league: no adapters; they belong in a folder league beside oncollide-lab, or give --adapter FILE.so");
    std::vector<LeagueEntry> entries;
    for (const std::string& file : files) {
        if (!o.answers) try_to_open(file);
        const std::vector<const league_library*> libraries = open_adapter(file);
        if (libraries.empty() && !o.adapters.empty()) // known adapters may lack another program
            throw Error(ErrorKind::bad_data, fmt::format("--adapter {}: no libraries", printable(file)));
        for (const league_library* library : libraries) entries.push_back({file, library, !o.adapters.empty()});
    }
    keep_named("--library", entries, o.libraries,
               [](const LeagueEntry& entry) { return std::string_view(entry.library->name); });
    std::ranges::stable_sort(entries, [](const LeagueEntry& p, const LeagueEntry& q) { // oncollide first
        const auto ours = [](const LeagueEntry& e) {
            return std::string_view(e.library->name).starts_with("oncollide");
        };
        return ours(p) > ours(q);
    });
    return entries;
}

/// Cases `first` to `first + count - 1` of a family, which a step of the run judges.
struct Step {
    std::size_t family;
    std::uint64_t first, count;
};

/// Size and time of a program or an adapter: results of another one do not count.
std::string stamp_of(const std::string& file)
{
    std::error_code error;
    const auto size = std::filesystem::file_size(file, error);
    return fmt::format("{}@{}", size, std::filesystem::last_write_time(file, error).time_since_epoch().count());
}

/// The cells of finished steps, in a file beside the reports, from which a run that was interrupted goes on.
class Finished {
public:
    Finished(const std::string& folder, const std::string& run) : run_(run)
    {
        if (folder.empty()) return;
        file_ = (std::filesystem::path(folder) / "league.steps").string();
        std::ifstream in(file_);
        for (std::string line; std::getline(in, line);) {
            const auto json = nlohmann::json::parse(line, nullptr, false);
            try {
                if (json.at("run") == run_) cells_[json.at("step")] = LeagueCell::from(json.at("cell"));
            } catch (const nlohmann::json::exception&) {
                continue; // the line was cut short, or is of another version
            }
        }
        out_.open(file_, std::ios::app);
        if (!out_) throw Error(ErrorKind::cannot_write, fmt::format("{}: cannot be written", printable(file_)));
    }
    std::optional<LeagueCell> find(const std::string& step) const
    {
        const auto at = cells_.find(step);
        return at == cells_.end() ? std::nullopt : std::optional(at->second);
    }
    void add(const std::string& step, const LeagueCell& cell)
    {
        if (file_.empty()) return;
        const std::lock_guard lock(mutex_);
        out_ << nlohmann::json{{"run", run_}, {"step", step}, {"cell", cell.json()}}.dump(
                    -1, ' ', true, nlohmann::json::error_handler_t::replace)
             << std::endl;
    }

private:
    std::string file_, run_;
    std::map<std::string, LeagueCell> cells_;
    std::ofstream out_;
    std::mutex mutex_;
};

/// The truths of some cases, found when a library first needs them: for doubles, and for floats.
class Truths {
public:
    Truths(const LeagueFamily& family, const Step& step) : family_(family), step_(step) {}
    /// False: no case needs a process of the library.
    bool any_supported(const league_library& library)
    {
        if (kinds_.empty())
            for (std::uint64_t k = 0; k < step_.count; ++k)
                kinds_.insert(kinds_of(AskedCase(family_.make(step_.first + k)).view()));
        return std::ranges::any_of(
            kinds_, [&](const auto& kinds) { return library.supports(family_.question, kinds.first, kinds.second); });
    }
    const std::vector<LeagueTruth>& of(int bits)
    {
        std::vector<LeagueTruth>& truths = bits == 32 ? floats_ : doubles_;
        for (std::uint64_t k = truths.size(); k < step_.count; ++k) {
            LeagueCase asked = family_.make(step_.first + k);
            if (bits == 32) asked = rounded_to_float(std::move(asked));
            truths.push_back(family_.truth(asked));
            confirm(step_.first + k, asked, truths.back());
        }
        return truths;
    }

private:
    /// Another method confirms one truth in a hundred.
    void confirm(std::uint64_t seed, const LeagueCase& asked, const LeagueTruth& truth) const
    {
        if (seed % 100 || !family_.confirms || family_.confirms(asked, truth)) return;
        throw Error(ErrorKind::internal,
                    fmt::format("league: two oracles contradict each other: family '{}', seed {}", family_.name, seed));
    }

    const LeagueFamily& family_;
    Step step_;
    std::set<std::pair<int, int>> kinds_;
    std::vector<LeagueTruth> doubles_, floats_;
};

std::vector<std::vector<LeagueCell>> run_league(const LeagueOptions& o, const std::vector<LeagueFamily>& families,
                                                const std::vector<LeagueEntry>& entries)
{
    constexpr std::uint64_t at_once = 2000;
    std::vector<Step> steps;
    for (std::size_t f = 0; f < families.size(); ++f)
        for (std::uint64_t first = 0; first < std::uint64_t(o.cases); first += at_once)
            steps.push_back({f, first, std::min(at_once, std::uint64_t(o.cases) - first)});
    std::vector<std::vector<LeagueCell>> cells(families.size(), std::vector<LeagueCell>(entries.size()));
    Finished finished(o.out, fmt::format("{} {}", version, stamp_of("/proc/self/exe")));
    std::mutex mutex;
    Progress progress("families", steps.size(), o.quiet);
    parallel_chunks(steps.size(), 1, threads_of(o.threads), [&](std::size_t begin, std::size_t end, int) {
        for (const Step& step : std::span(steps).subspan(begin, end - begin)) {
            const LeagueFamily& family = families[step.family];
            Truths truths(family, step);
            for (std::size_t e = 0; e < entries.size(); ++e) {
                const league_library& library = *entries[e].library;
                const std::string name = fmt::format("{} {}/{}/{}+{}", library.name, stamp_of(entries[e].adapter),
                                                     family.name, step.first, step.count);
                std::optional<LeagueCell> cell = finished.find(name);
                if (!cell) {
                    if (truths.any_supported(library))
                        cell = judge_replies(family, library, truths.of(library.bits),
                                             ask_in_child(family, entries[e], step.first, step.count));
                    else
                        cell = LeagueCell{.cases = step.count, .unsupported = step.count};
                    finished.add(name, *cell);
                }
                const std::lock_guard lock(mutex);
                cells[step.family][e].add(*cell);
            }
            const std::lock_guard lock(mutex);
            progress.step();
        }
    });
    return cells;
}

/// Writes the case in the form of the file's ending, as the library gets it.
void write_case(const LeagueOptions& o, const LeagueFamily& family, const league_library& library)
{
    LeagueCase made = family.make(std::uint64_t(o.seed));
    if (library.bits == 32) made = rounded_to_float(std::move(made));
    std::string text;
    if (o.write.ends_with(".obj"))
        text = obj_of(made);
    else if (o.write.ends_with(".cpp"))
        text = program_of(AskedCase(made).view(), library.name);
    else if (o.write.ends_with(".json"))
        text = json_of(AskedCase(made).view()).dump(1) + "\n";
    else
        usage(fmt::format("--write {}: the name must end in .obj, .json or .cpp", printable(o.write)));
    OutputFile file(o.write);
    file.write(text);
    file.commit();
}

/// Queries all libraries about one case, and prints their results.
int show_case(const LeagueOptions& o, const LeagueFamily& family, const std::vector<LeagueEntry>& entries)
{
    if (!o.write.empty()) write_case(o, family, *entries.at(0).library);
    say("case       {}, seed {}: {}\n", family.name, o.seed, name_of(family.question));
    bool wrong = false; // oncollide itself
    for (const LeagueEntry& entry : entries) {
        Truths truths(family, {0, std::uint64_t(o.seed), 1});
        const LeagueCell cell = judge_replies(family, *entry.library, truths.of(entry.library->bits),
                                              ask_in_child(family, entry, std::uint64_t(o.seed), 1));
        wrong |= entry.library->name == std::string_view("oncollide") && cell.right() == 0;
        const std::string what = cell.unsupported     ? "unsupported"
                                 : cell.failed        ? "failed"
                                 : cell.worst.empty() ? "right"
                                                      : fmt::format("{}: expected {}, given {}", cell.worst[0].fault,
                                                                    cell.worst[0].expected, cell.worst[0].given);
        say("{:<18} {}\n", entry.library->name, what);
    }
    return wrong ? int(ErrorKind::internal) : 0;
}

void list(const std::vector<LeagueFamily>& families, const std::vector<LeagueEntry>& entries)
{
    std::size_t longest = 0;
    for (const LeagueFamily& family : families) longest = std::max(longest, family.name.size());
    for (const LeagueFamily& family : families)
        say("{:<{}}  {:<9} {}\n", family.name, longest, name_of(family.question), family.what);
    say("\n");
    for (const LeagueEntry& entry : entries) say("{:<18} {}\n", entry.library->name, entry.library->settings);
}

int league(const LeagueOptions& o)
{
    check_range("--cases", o.cases, 1, 10'000'000), check_range("--threads", o.threads, 0, 1024);
    std::vector<LeagueFamily> families = league_families();
    keep_named("--family", families, o.families,
               [](const LeagueFamily& family) { return std::string_view(family.name); });
    const std::vector<LeagueEntry> entries = entries_of(o);
    if (o.answers) {
        answer_in_child(families.at(0), *entries.at(0).library, std::uint64_t(o.seed), std::uint64_t(o.cases));
        return 0;
    }
    if (o.list) {
        list(families, entries);
        return 0;
    }
    if (o.seed >= 0) {
        if (families.size() != 1) usage("--seed: needs one --family");
        return show_case(o, families[0], entries);
    }
    if (!o.write.empty()) usage("--write: needs --seed and --family");
    if (!o.out.empty()) {
        std::error_code error;
        std::filesystem::create_directories(o.out, error);
        if (error) throw Error(ErrorKind::cannot_write, fmt::format("--out {}: {}", printable(o.out), error.message()));
    }
    const LeagueTable table{families, entries, run_league(o, families, entries)};
    say("{}", text_of(table));
    if (!o.out.empty()) write_reports(o.out, table);
    return table.wrong_of("oncollide") ? int(ErrorKind::internal) : 0;
}

} // namespace

void add_league(Arguments app)
{
    Arguments sub = app.add_command("league", "Judge libraries of collision detection by the same certified cases");
    auto o = std::make_shared<LeagueOptions>();
    sub.add_option("--cases N", o->cases, "cases of each family (default 1000)");
    sub.add_option("--family NAME", o->families, "only this family (repeatable)").repeatable();
    sub.add_option("--library NAME", o->libraries, "only this library (repeatable)").repeatable();
    sub.add_flag("--list", o->list, "print the families and the libraries, and end");
    sub.add_option("--adapter FILE.so", o->adapters,
                   "judge the libraries of this adapter instead of the known ones (repeatable): docs/league.md")
        .repeatable();
    sub.add_option("--out FOLDER", o->out,
                   "write league.html, league.json and league.csv; a run that was interrupted goes on from there");
    sub.add_option("--seed N", o->seed, "query the libraries about this case of one family, and print their results");
    sub.add_option("--write FILE", o->write,
                   "with --seed: write the case as .obj, .json, or .cpp: a program that gives it to the first library");
    sub.add_option("--threads N", o->threads, "cases of this many families at once; 0: all cores (default 0)");
    sub.add_flag("--answers", o->answers, "write the results of one library in binary, for the command itself");
    sub.add_flag("--quiet", o->quiet, "no progress");
    sub.footer(
        "A case is a family and a seed. The truth comes from rational arithmetic, integers or long double, without\n"
        "code of any library. Each library runs in a process of its own: a crash, 5 s or 2 GB are results.\n"
        "Libraries in single precision get cases rounded to float, and the truth about these.\n\n"
        "Examples:\n"
        "  oncollide-lab league --cases 200\n"
        "  oncollide-lab league --cases 20000 --out league\n"
        "  oncollide-lab league --family 'rays: through edges' --seed 17 --write case.obj\n"
        "  oncollide-lab league --adapter ./libmine.so\n"
        "Exit code: 70 if the library oncollide is wrong.");
    sub.action([o] { return league(*o); });
}

} // namespace oncollide::tools

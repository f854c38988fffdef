#include "bench/common/benchmark.hpp"

#include <cstdlib>
#include <ctime>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/paths.hpp>

#include "cli/outputs.hpp"
#include "cli/shard.hpp"
#include "common/text.hpp"

namespace oncollide::tools {
namespace {

constexpr int most_threads = 1024, most_repeats = 1000;

/// "--bodies" of "--bodies N".
std::string first_name(const std::string& names)
{
    return names.substr(0, names.find_first_of(" ,"));
}

} // namespace

BenchmarkCommand::BenchmarkCommand(Arguments bench, const std::string& name, const std::string& summary,
                                   SharedOptions& shared)
    : command_(bench.add_command(name, summary)), shared_(shared)
{
}

void BenchmarkCommand::action(Command run)
{
    command_.action([run, checks = checks_, files = files_] {
        for (const auto& check : *checks) check();
        std::vector<std::pair<const char*, std::string>> outputs;
        std::vector<std::string> inputs;
        for (const auto& [name, file] : files->outputs) outputs.emplace_back(name, *file);
        for (const std::string* file : files->inputs) inputs.push_back(*file);
        for (const auto* list : files->lists) inputs.insert(inputs.end(), list->begin(), list->end());
        check_files(outputs, inputs);
        return run();
    });
}

void BenchmarkCommand::whole(const std::string& names, int& value, const std::string& help, Range range)
{
    option(names, value, fmt::format("{} (default {})", help, value));
    checks_->push_back(
        [name = first_name(names), &value, range] { check_range(name.c_str(), value, range.least, range.most); });
}

void BenchmarkCommand::whole(const std::string& names, std::optional<int>& value, const std::string& help, Range range)
{
    option(names, value, help);
    checks_->push_back([name = first_name(names), &value, range] {
        if (value) check_range(name.c_str(), *value, range.least, range.most);
    });
}

Option BenchmarkCommand::input(const std::string& names, std::string& file, const std::string& help)
{
    files_->inputs.push_back(&file);
    return option(names, file, help);
}

Option BenchmarkCommand::input(const std::string& names, std::vector<std::string>& files, const std::string& help)
{
    files_->lists.push_back(&files);
    return option(names, files, help);
}

void BenchmarkCommand::output(const char* name, const char* value, std::string& file, const std::string& help)
{
    files_->outputs.emplace_back(name, &file);
    option(fmt::format("{} {}", name, value), file, help);
}

void BenchmarkCommand::repeats(const std::string& what)
{
    whole("--repeats N", shared_.repeats, what, {1, most_repeats});
}

void BenchmarkCommand::threads(const std::string& what)
{
    whole("--threads N", shared_.threads, what + "; 0: all", {0, most_threads});
}

void BenchmarkCommand::seed(const std::string& what)
{
    option("--seed S", shared_.seed, fmt::format("seed of {} (default {})", what, shared_.seed));
}

void BenchmarkCommand::csv(const std::string& of_a_row)
{
    output("--csv", "FILE", shared_.csv, "write one row per " + of_a_row);
}

void BenchmarkCommand::json(const std::string& what)
{
    output("--json", "FILE", shared_.json, fmt::format("write {} as JSON", what));
}

Option BenchmarkCommand::plot(const std::string& what)
{
    files_->outputs.emplace_back("--plot", &shared_.plot);
    return option("--plot FILE.svg", shared_.plot, "draw " + what);
}

void BenchmarkCommand::only()
{
    option("--only LIST", shared_.only, "run only these contenders");
}

void BenchmarkCommand::data(const std::string& folder)
{
    option("--data DIR", shared_.data,
           fmt::format("folder with {} (default: $ONCOLLIDE_DATA, else ../shared/data)", folder));
}

void BenchmarkCommand::gpu()
{
    option("--gpu N", shared_.gpu, "number of the GPU ('oncollide doctor' lists them)");
}

void BenchmarkCommand::shard(const std::string& what)
{
    option("--shard I/N", shared_.shard, fmt::format("divide the {} among N processes: {}", what, shard_help));
}

ScratchFolder::ScratchFolder(const std::filesystem::path& in)
{
    std::string pattern = ((in.empty() ? temporary_files() : in) / "oncollide-bench-XXXXXX").string();
    if (!::mkdtemp(pattern.data())) throw Error(ErrorKind::cannot_write, pattern + ": cannot create");
    path_ = pattern;
}

ScratchFolder::~ScratchFolder()
{
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

double processor_ms()
{
    std::timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e3 * double(t.tv_sec) + 1e-6 * double(t.tv_nsec);
}

int code_of(bool wrong)
{
    return wrong ? int(ErrorKind::internal) : 0;
}

} // namespace oncollide::tools

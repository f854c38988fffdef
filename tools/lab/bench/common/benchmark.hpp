#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <oncollide/base/error.hpp>

#include "bench/common/benchmarks.hpp"
#include "bench/common/result_table.hpp"
#include "cli/arguments.hpp"
#include "cli/shard.hpp"
#include "common/race.hpp"
#include "common/text.hpp"

// Every benchmark includes this header: options with one spelling, one help text and one check of each, races, tables
// of results, text and exit codes.
namespace oncollide::tools {

/// A benchmark offers some of these.
struct SharedOptions {
    std::string csv, json, plot; ///< files to write; empty: none
    std::string only, data, shard;
    int repeats = 3, threads = 1, gpu = -1;
    std::uint64_t seed = 12345;
};

/// Allowed values of a whole number.
struct Range {
    std::int64_t least = 1, most = std::numeric_limits<std::int64_t>::max();
};

/// A command of 'oncollide-lab bench', while its options are added. Checks the ranges and all files before it runs.
class BenchmarkCommand {
public:
    template <class Value>
    Option option(const std::string& names, Value& value, const std::string& help)
    {
        return command_.add_option(names, value, help);
    }
    Option flag(const std::string& name, bool& value, const std::string& help)
    {
        return command_.add_flag(name, value, help);
    }
    /// The help ends with the default.
    void whole(const std::string& names, int& value, const std::string& help, Range range = {});
    void whole(const std::string& names, std::optional<int>& value, const std::string& help, Range range = {});
    /// A file that no output may overwrite, or several.
    Option input(const std::string& names, std::string& file, const std::string& help);
    Option input(const std::string& names, std::vector<std::string>& files, const std::string& help);
    void output(const char* name, const char* value, std::string& file, const std::string& help);

    void repeats(const std::string& what = "number of runs; the least time counts");
    void threads(const std::string& what);
    void seed(const std::string& what);
    void csv(const std::string& of_a_row);
    void json(const std::string& what = "the same");
    Option plot(const std::string& what);
    void only();
    void data(const std::string& folder = "meshes/");
    void gpu();
    void shard(const std::string& what);

    Arguments arguments() { return command_; }
    void footer(const std::string& text) { command_.footer(text); }

protected:
    using Checks = std::vector<std::function<void()>>;
    BenchmarkCommand(Arguments bench, const std::string& name, const std::string& summary, SharedOptions& shared);
    /// Runs after the checks.
    void action(Command run);

private:
    struct Files {
        std::vector<std::pair<const char*, const std::string*>> outputs;
        std::vector<const std::string*> inputs;
        std::vector<const std::vector<std::string>*> lists;
    };
    Arguments command_;
    SharedOptions& shared_;
    std::shared_ptr<Checks> checks_ = std::make_shared<Checks>();
    std::shared_ptr<Files> files_ = std::make_shared<Files>();
};

/// The same with its options, which derive from SharedOptions and hold the defaults.
template <class Options>
class Benchmark : public BenchmarkCommand {
public:
    Benchmark(Arguments bench, const std::string& name, const std::string& summary, int (*run)(const Options&),
              Options defaults = {})
        : Benchmark(bench, name, summary, run, std::make_shared<Options>(std::move(defaults)))
    {
    }
    /// Also calls `before` with the options, after the checks.
    void prepare(std::function<void(Options&)> before) { *before_ = std::move(before); }
    Options* operator->() { return options_.get(); }

private:
    Benchmark(Arguments bench, const std::string& name, const std::string& summary, int (*run)(const Options&),
              std::shared_ptr<Options> options)
        : BenchmarkCommand(bench, name, summary, *options), options_(options)
    {
        action([run, options, before = before_] {
            if (*before) (*before)(*options);
            return run(*options);
        });
    }

    std::shared_ptr<Options> options_;
    std::shared_ptr<std::function<void(Options&)>> before_ = std::make_shared<std::function<void(Options&)>>();
};

/// A new folder, which is removed at the end of its scope.
class ScratchFolder {
public:
    /// Throws Error{cannot_write}. @param in  empty: the system's temporary folder
    explicit ScratchFolder(const std::filesystem::path& in = {});
    ~ScratchFolder();
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;
    const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

/// Processor time of this thread, so that other work on the machine affects it less.
double processor_ms();

/// The exit code of a benchmark: 70 if a result is wrong.
int code_of(bool wrong);

} // namespace oncollide::tools

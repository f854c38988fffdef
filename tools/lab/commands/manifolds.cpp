// oncollide-lab manifolds: the claims of manifolds, judged by rational arithmetic.
#include "commands/lab.hpp"

#include <memory>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/threads/parallel.hpp>

#include "cli/progress.hpp"
#include "cli/standard_output.hpp"
#include "verify/trials/manifold_trial.hpp"

namespace oncollide::tools {
namespace {

struct ManifoldFuzzOptions {
    std::int64_t pairs = 10'000;
    std::uint64_t seed = 1;
    int threads = 1;
};

int judge_manifolds(const ManifoldFuzzOptions& options)
{
    check_range("--pairs", options.pairs, 1);
    check_range("--threads", options.threads, 0, 1024);
    Progress progress("pairs", std::size_t(options.pairs));
    const ManifoldTally tally = try_manifolds(options.seed, std::uint64_t(options.pairs), threads_of(options.threads),
                                              [&] { progress.step(); });
    write_to_stdout(fmt::format("{} pairs, {} cross, {} contacts; {} of one region, judged in all claims\n"
                                "{} needed rational arithmetic; {} were not in general position\n{} faults\n",
                                tally.pairs, tally.met, tally.contacts, tally.whole, tally.exact, tally.special,
                                tally.faults));
    if (tally.faults == 0) return 0;
    write_to_stdout(fmt::format("first: seed {}: {}\n", tally.first.seed, tally.first.what));
    return int(ErrorKind::internal);
}

} // namespace

void add_manifolds(Arguments app)
{
    Arguments sub = app.add_command("manifolds", "Judge the claims of manifolds by rational arithmetic");
    auto options = std::make_shared<ManifoldFuzzOptions>();
    sub.add_option("--pairs N", options->pairs, "number of pairs (default 10000)");
    sub.add_option("--seed S", options->seed, "seed of the first pair; each pair has the next number (default 1)");
    sub.add_option("--threads N", options->threads, "number of threads; 0: all (default 1)");
    sub.footer(
        "Small closed meshes with random corners. Judged are the lost contacts of all regions, and of a pair with "
        "one region both bounds of the depth and the error of the normal. Exit code 70: a claim is wrong.");
    sub.action([options] { return judge_manifolds(*options); });
}

} // namespace oncollide::tools

// oncollide-lab manifolds: the claims of manifolds, judged by rational arithmetic; of shapes, in extended precision.
#include "commands/lab.hpp"

#include <memory>
#include <optional>
#include <set>
#include <string>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/threads/parallel.hpp>

#include "cli/progress.hpp"
#include "cli/standard_output.hpp"
#include "verify/trials/manifold_trial.hpp"
#include "verify/trials/shape_manifold_trial.hpp"

namespace oncollide::tools {
namespace {

struct ManifoldFuzzOptions {
    std::int64_t pairs = 10'000;
    std::uint64_t seed = 1;
    int threads = 1;
    bool shapes = false, all_faults = false;
    std::string kinds;
};

/// "presence 3, surface 1"
std::string claims_of(const ShapeManifoldTally::Counts& counts)
{
    std::string text;
    const auto claims = counts.claims();
    for (std::size_t k = 0; k < claims.size(); ++k)
        if (claims[k] > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", oracle::shape_claims[k], claims[k]);
    return text;
}

int judge_shape_manifolds(const ManifoldFuzzOptions& options)
{
    std::optional<std::pair<int, int>> only;
    if (!options.kinds.empty()) only = kinds_of(options.kinds);
    Progress progress("pairs", std::size_t(options.pairs));
    const ShapeManifoldTally tally = try_shape_manifolds(
        options.seed, std::uint64_t(options.pairs), threads_of(options.threads), [&] { progress.step(); }, only);
    for (const auto& [kinds, counts] : tally.by_kinds) {
        write_to_stdout(fmt::format("{}: {} pairs, {} meet, {} within the margin, {} points; {} faulty",
                                    name_of_kinds(kinds), counts.pairs, counts.meet, counts.near, counts.points,
                                    counts.faulty));
        write_to_stdout(
            counts.faulty > 0 ? fmt::format(" ({}), first seed {}\n", claims_of(counts), counts.faults[0].seed) : "\n");
    }
    const ShapeManifoldTally::Counts all = tally.all();
    write_to_stdout(fmt::format("{} pairs, {} meet, {} within the margin, {} regions, {} points\n{} faulty pairs{}\n",
                                all.pairs, all.meet, all.near, all.regions, all.points, all.faulty,
                                all.faulty > 0 ? ": " + claims_of(all) : ""));
    if (all.faulty == 0) return 0;
    std::set<oracle::ShapeClaim> seen;
    for (const ShapeManifoldTally::Fault& fault : all.faults)
        if (seen.insert(fault.claim).second || options.all_faults)
            write_to_stdout(fmt::format("seed {}: {}\n", fault.seed, fault.what));
    return int(ErrorKind::internal);
}

int judge_manifolds(const ManifoldFuzzOptions& options)
{
    check_range("--pairs", options.pairs, 1);
    check_range("--threads", options.threads, 0, 1024);
    if (options.shapes) return judge_shape_manifolds(options);
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
    Arguments sub =
        app.add_command("manifolds", "Judge the claims of manifolds by arithmetic that is exact or nearly so");
    auto options = std::make_shared<ManifoldFuzzOptions>();
    sub.add_option("--pairs N", options->pairs, "number of pairs (default 10000)");
    sub.add_option("--seed S", options->seed, "seed of the first pair; each pair has the next number (default 1)");
    sub.add_option("--threads N", options->threads, "number of threads; 0: all (default 1)");
    const Option shapes =
        sub.add_flag("--shapes", options->shapes,
                     "judge shapes, every kind with every kind, and bounded shapes on meshes, terrains and maps");
    sub.add_option("--kinds A,B", options->kinds, "only these two kinds, such as sphere,box or cone,terrain")
        .needs(shapes);
    sub.add_flag("--all-faults", options->all_faults, "print every fault, not only the first of each claim")
        .needs(shapes);
    sub.footer(
        "Without --shapes: small closed meshes with random corners, judged by rational arithmetic. Judged are the lost "
        "contacts of all regions, and of a pair with one region both bounds of the depth and the error of the normal. "
        "With --shapes: pairs at rest, deep, enclosed, nearly parallel, thin, of very different sizes and far from the "
        "origin, judged by closed forms and by the distances of convex solids in extended precision. Judged is whether "
        "there is a region, and only one; its normal and its depths; whether another direction is shorter by 1 %; "
        "whether "
        "the points lie on the true surfaces; and whether the swapped pair has the same. A claim is wrong beyond a "
        "doubt "
        "of 1e-12 of the sizes and the distance. Each two kinds have a row with the seed of the first fault. Exit code "
        "70: a claim is wrong.");
    sub.action([options] { return judge_manifolds(*options); });
}

} // namespace oncollide::tools

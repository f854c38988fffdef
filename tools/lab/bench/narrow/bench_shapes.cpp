// oncollide-lab bench shapes: pairs of shapes close to contact, compared with FCL, which passes most of them to libccd.
#include "bench/bench.hpp"
#include "bench/narrow/shape_pairs.hpp"
#include "cli/options.hpp"
#include "common/race.hpp"
#include "common/text.hpp"
#include "truth/judge.hpp"

#include <algorithm>
#include <array>
#include <ctime>
#include <memory>

#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/narrowphase/pairs/pair_tests.hpp>

#include "cli/outputs.hpp"

namespace oncollide::tools {
namespace {

struct ShapesOptions {
    int pairs = 100'000;
    int threads = 0; ///< for the checks; both libraries are timed on one thread
    double least_gap = 1e-6;
    std::uint64_t seed = 12345;
    std::string csv;
};

constexpr std::size_t batch = 2000;
constexpr std::size_t kinds = shape_kinds.size();

/// Results of the pairs of two kinds.
struct ShapeRow {
    std::uint64_t pairs = 0, colliding = 0;
    double ours_ns = 0, fcl_ns = 0;
    std::uint64_t open = 0;  ///< reported `within` by oncollide
    std::uint64_t wrong = 0; ///< results or bounds of oncollide that the truth contradicts
    std::uint64_t fcl_missed = 0, fcl_invented = 0;
    double fcl_worst = 0; ///< largest distance of a pair that FCL reports as colliding, metres

    ShapeRow& operator+=(const ShapeRow& o)
    {
        pairs += o.pairs, colliding += o.colliding, ours_ns += o.ours_ns, fcl_ns += o.fcl_ns, open += o.open;
        wrong += o.wrong, fcl_missed += o.fcl_missed, fcl_invented += o.fcl_invented;
        fcl_worst = std::max(fcl_worst, o.fcl_worst);
        return *this;
    }
};

struct ShapeResults {
    Finding ours;
    bool fcl;
};

void judge(const ClosePair& pair, const ShapeResults& results, ShapeRow& row)
{
    PairTruth truth = truth_of(pair.a->model->geometry().data, pair.pose_a, pair.b->model->geometry().data, pair.pose_b,
                               {.deep = false});
    truth.uncertain = true; // one test alone may leave a pair open
    const bool apart = !truth.collide && !truth.open;
    const Finding& r = results.ours;
    row.colliding += r.verdict == Verdict::colliding;
    row.open += r.verdict == Verdict::within;
    row.wrong += !judge(r, truth, {}).right() || (r.verdict == Verdict::separate && r.bound <= 0);
    row.fcl_missed += truth.collide && !results.fcl;
    row.fcl_invented += apart && results.fcl;
    if (apart && results.fcl) row.fcl_worst = std::max(row.fcl_worst, truth.distance.low);
}

/// Processor time of this thread, so that other work on the machine does not count.
double processor_ns()
{
    std::timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e9 * double(t.tv_sec) + double(t.tv_nsec);
}

std::string named(std::size_t a, std::size_t b)
{
    return fmt::format("{} {}", shape_kinds[a], shape_kinds[b]);
}

void print_row(const std::string& name, const ShapeRow& r)
{
    const double n = double(std::max<std::uint64_t>(r.pairs, 1));
    say("{:<22}{:>10}{:>11.1f}%{:>12.0f}{:>10.0f}{:>8.2f}{:>8}{:>7}{:>10}{:>10}{:>11.1e}\n", name, grouped(r.pairs),
        100 * double(r.colliding) / n, r.ours_ns / n, r.fcl_ns / n, r.fcl_ns / r.ours_ns, grouped(r.open),
        grouped(r.wrong), grouped(r.fcl_missed), grouped(r.fcl_invented), r.fcl_worst);
}

class ShapeRace {
public:
    explicit ShapeRace(const ShapesOptions& options)
        : pairs_(options.seed, options.least_gap), threads_(options.threads)
    {
    }

    void run(std::uint64_t first, std::uint64_t count)
    {
        drawn_.clear();
        for (std::uint64_t i = 0; i < count; ++i) drawn_.push_back(pairs_.draw(first + i));
        // Sorted by kinds, so that each pair of kinds is timed separately.
        std::ranges::stable_sort(drawn_, {}, [](const ClosePair& p) { return p.kind_a * int(kinds) + p.kind_b; });
        results_.resize(count);
        for (std::size_t begin = 0, end; begin < count; begin = end) {
            const auto same = [&](const ClosePair& p) {
                return p.kind_a == drawn_[begin].kind_a && p.kind_b == drawn_[begin].kind_b;
            };
            end = begin;
            while (end < count && same(drawn_[end])) ++end;
            ShapeRow& row = rows[std::size_t(drawn_[begin].kind_a)][std::size_t(drawn_[begin].kind_b)];
            row.pairs += end - begin;
            time(begin, end, row, turn_++);
        }
        judge_all();
    }

    std::array<std::array<ShapeRow, kinds>, kinds> rows;
    std::uint64_t hash = 1469598103934665603u; ///< of oncollide's verdicts

private:
    void time(std::size_t begin, std::size_t end, ShapeRow& row, unsigned turn)
    {
        take_turns(2, turn, [&](std::size_t fcl) {
            const double from = processor_ns();
            for (std::size_t i = begin; i < end; ++i) {
                const ClosePair& p = drawn_[i];
                const PairTask task{0, p.a->model.get(), p.b->model.get(), &p.pose_a, &p.pose_b};
                if (fcl)
                    results_[i].fcl = fcl_contacts({p.a->fcl, p.pose_a}, {p.b->fcl, p.pose_b}) > 0;
                else
                    results_[i].ours = tests_for(task).decide(worker_, task, {}, nullptr);
            }
            (fcl ? row.fcl_ns : row.ours_ns) += processor_ns() - from;
        });
    }
    void judge_all()
    {
        constexpr std::size_t grain = 50;
        std::vector<ShapeRow> judged(drawn_.size());
        parallel_chunks(drawn_.size(), grain, threads_, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i) judge(drawn_[i], results_[i], judged[i]);
        });
        for (std::size_t i = 0; i < drawn_.size(); ++i) {
            rows[std::size_t(drawn_[i].kind_a)][std::size_t(drawn_[i].kind_b)] += judged[i];
            hash = (hash ^ std::uint64_t(results_[i].ours.verdict)) * 1099511628211u;
        }
    }

    ClosePairs pairs_;
    int threads_;
    PairWorker worker_;
    std::vector<ClosePair> drawn_;
    std::vector<ShapeResults> results_;
    unsigned turn_ = 0;
};

/// Close pairs of shapes of all kinds, compared with FCL's libccd. Returns the exit code: 70 if extended precision
/// contradicts a result of oncollide.
int bench_shapes(const ShapesOptions& options)
{
    check_range("--pairs", options.pairs, 1, 1'000'000'000);
    check_range("--threads", options.threads, 0, 1024);
    if (!(options.least_gap > 0 && options.least_gap <= 0.1))
        usage("bench shapes: --least-gap must be above 0 and at most 0.1");
    check_files({{"--csv", options.csv}});
    CsvFile csv(options.csv, "a,b,pairs,colliding,oncollide_ns,fcl_ns,within,wrong,fcl_lost,fcl_made,fcl_worst_m");
    say("{}pairs      {}, gaps of {} to 0.1 m, seed {}; checked in extended precision on {} threads\n\n",
        describe_program("shapes"), grouped(std::uint64_t(options.pairs)), options.least_gap, options.seed,
        thread_count({.threads = options.threads}));
    ShapeRace race(options);
    for (std::uint64_t first = 0; first < std::uint64_t(options.pairs); first += batch)
        race.run(first, std::min<std::uint64_t>(batch, std::uint64_t(options.pairs) - first));

    say("{:<22}{:>10}{:>12}{:>12}{:>10}{:>8}{:>8}{:>7}{:>10}{:>10}{:>11}\n", "", "pairs", "colliding", "oncollide ns",
        "FCL ns", "ratio", "within", "wrong", "FCL lost", "FCL made", "worst, m");
    ShapeRow all;
    for (std::size_t a = 0; a < kinds; ++a)
        for (std::size_t b = a; b < kinds; ++b) {
            const ShapeRow& r = race.rows[a][b];
            if (r.pairs == 0) continue;
            print_row(named(a, b), r), all += r;
            csv.row(shape_kinds[a], shape_kinds[b], r.pairs, r.colliding, Fixed{r.ours_ns / double(r.pairs), 1},
                    Fixed{r.fcl_ns / double(r.pairs), 1}, r.open, r.wrong, r.fcl_missed, r.fcl_invented, r.fcl_worst);
        }
    print_row("all", all);
    say("\nhash       {:016x}\n", race.hash);
    csv.commit();
    return all.wrong ? int(ErrorKind::internal) : 0;
}

} // namespace

void add_shapes(Arguments bench)
{
    Arguments sub = bench.add_command("shapes", "Pairs of shapes close to contact, checked in extended precision");
    auto options = std::make_shared<ShapesOptions>();
    sub.add_option("--pairs N", options->pairs, "number of random pairs (default 100000)");
    sub.add_option("--seed S", options->seed, "seed of the pairs (default 12345)");
    sub.add_option("--least-gap", options->least_gap, "least gap or overlap; 0.1 m is the largest (default 1e-6)")
        .length();
    sub.add_option("--threads N", options->threads, "number of threads for the checks; 0: all (default 0)");
    sub.add_option("--csv FILE", options->csv, "write one row per pair of kinds");
    sub.footer(
        "Both libraries are timed on one thread, in alternation. 'within': pairs that oncollide does not decide; 'FCL "
        "lost' and 'FCL made': collisions that FCL misses, and false collisions of FCL; 'worst': largest distance "
        "of such a pair. Exit code 70: the truth contradicts a result or a bound of oncollide.");
    sub.action([options] { return bench_shapes(*options); });
}

} // namespace oncollide::tools

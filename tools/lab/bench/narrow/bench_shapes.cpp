// oncollide-lab bench shapes: pairs of shapes close to contact, compared with FCL, which passes most of them to libccd.
#include "bench/common/benchmark.hpp"
#include "bench/narrow/shape_pairs.hpp"
#include "truth/judge.hpp"

#include <algorithm>
#include <array>

#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/narrowphase/pairs/pair_tests.hpp>

namespace oncollide::tools {
namespace {

struct ShapesOptions : SharedOptions {
    int pairs = 100'000;
    double least_gap = 1e-6;
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

Figures figures_of(std::string_view a, std::string_view b, const ShapeRow& r)
{
    const double n = double(std::max<std::uint64_t>(r.pairs, 1));
    return figures("a", a, "b", b, "pairs", r.pairs, "colliding", r.colliding, "oncollide_ns", r.ours_ns / n, "fcl_ns",
                   r.fcl_ns / n, "ratio", r.fcl_ns / r.ours_ns, "within", r.open, "wrong", r.wrong, "fcl_lost",
                   r.fcl_missed, "fcl_made", r.fcl_invented, "fcl_worst_m", r.fcl_worst);
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
            const double from = processor_ms();
            for (std::size_t i = begin; i < end; ++i) {
                const ClosePair& p = drawn_[i];
                const PairTask task{0, p.a->model.get(), p.b->model.get(), &p.pose_a, &p.pose_b};
                if (fcl)
                    results_[i].fcl = fcl_contacts({p.a->fcl, p.pose_a}, {p.b->fcl, p.pose_b}) > 0;
                else
                    results_[i].ours = tests_for(task).decide(worker_, task, {}, nullptr);
            }
            (fcl ? row.fcl_ns : row.ours_ns) += 1e6 * (processor_ms() - from);
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
    if (!(options.least_gap > 0 && options.least_gap <= 0.1))
        usage("bench shapes: --least-gap must be above 0 and at most 0.1");
    ResultTable table(options.csv);
    say("{}pairs      {}, gaps of {} to 0.1 m, seed {}; checked in extended precision on {} threads\n\n",
        describe_program("shapes"), grouped(std::uint64_t(options.pairs)), options.least_gap, options.seed,
        threads_of(options.threads));
    ShapeRace race(options);
    for (std::uint64_t first = 0; first < std::uint64_t(options.pairs); first += batch)
        race.run(first, std::min<std::uint64_t>(batch, std::uint64_t(options.pairs) - first));

    ShapeRow all;
    for (std::size_t a = 0; a < kinds; ++a)
        for (std::size_t b = a; b < kinds; ++b) {
            const ShapeRow& r = race.rows[a][b];
            if (r.pairs > 0) table.row(figures_of(shape_kinds[a], shape_kinds[b], r)), all += r;
        }
    table.print(figures_of("all", "", all));
    say("\nhash       {:016x}\n", race.hash);
    table.commit();
    return code_of(all.wrong > 0);
}

} // namespace

void add_shapes(Arguments bench)
{
    Benchmark<ShapesOptions> b(bench, "shapes", "Pairs of shapes close to contact, checked in extended precision",
                               bench_shapes);
    b->threads = 0;
    b.whole("--pairs N", b->pairs, "number of random pairs", {1, 1'000'000'000});
    b.option("--least-gap", b->least_gap, "least gap or overlap; 0.1 m is the largest (default 1e-6)").length();
    b.seed("the pairs"), b.threads("number of threads for the checks"), b.csv("pair of kinds");
    b.footer("Both libraries are timed on one thread, in alternation. 'within': pairs that oncollide does not decide; "
             "'fcl lost' and 'fcl made': collisions that FCL misses, and false collisions of FCL; 'fcl worst': largest "
             "distance of such a pair. Exit code 70: the truth contradicts a result or a bound of oncollide.");
}

} // namespace oncollide::tools

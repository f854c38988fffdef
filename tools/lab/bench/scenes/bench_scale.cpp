// oncollide-lab bench scale: the work of each of very many ranks, without the machines. Bodies are a function of their
// index and the frame, so a single rank can be played without reading any file: it computes the bodies in and near its
// region.

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/runs/ranks/body_record.hpp>

#include "bench/common/benchmark.hpp"
#include "cli/system.hpp"

namespace oncollide::tools {
namespace {

struct ScaleOptions : SharedOptions {
    double bodies = 1e6;
    std::string ranks = "64"; ///< numbers of ranks; each number divides the whole world
    int sample = 0;           ///< ranks to play; 0: all
    double edge = 1;          ///< mean, in mean spacings
    int frame = 0;
};

using Eigen::Array3d, Eigen::Array3i, Eigen::Vector3d;

constexpr std::uint32_t large_every = 1000; // about one body of this many, chosen randomly, is 8 times as large
constexpr double large_by = 8;

/// One cube in each cell of a lattice of unit cells, at a random position in the cell.
class UniformWorld {
public:
    UniformWorld(double bodies, double edge, std::uint64_t seed, int frame)
        : side_(std::max(1, int(std::lround(std::cbrt(bodies))))), edge_(edge), seed_(seed), frame_(frame)
    {
    }
    int side() const { return side_; }
    std::uint64_t bodies() const { return std::uint64_t(side_) * side_ * side_; }
    std::uint32_t index(int x, int y, int z) const { return std::uint32_t((std::int64_t(z) * side_ + y) * side_ + x); }
    double largest() const { return 1.5 * edge_ * large_by; }

    Aabb box(int x, int y, int z) const
    {
        const std::uint32_t i = index(x, y, z);
        Vector3d at(x, y, z);
        for (int k = 0; k < 3; ++k) {
            // Moves back and forth in its cell.
            const double start = u01(seed_, i, std::uint64_t(k)),
                         speed = 0.1 * (u01(seed_, i, std::uint64_t(k) + 4) - 0.5);
            const double way = std::fmod(std::abs(start + frame_ * speed), 2.0);
            at[k] += way < 1 ? way : 2 - way;
        }
        const double size = edge_ * (0.5 + u01(seed_, i, 3)) * (u01(seed_, i, 7) * large_every < 1 ? large_by : 1);
        return {at - Vector3d::Constant(0.5 * size), at + Vector3d::Constant(0.5 * size)};
    }
    /// The mean k-th power of the edges.
    double moment(int k) const
    {
        const double uniform = (std::pow(1.5, k + 1) - std::pow(0.5, k + 1)) / (k + 1);
        return std::pow(edge_, k) * uniform * (1 + (std::pow(large_by, k) - 1) / large_every);
    }

private:
    int side_;
    double edge_;
    std::uint64_t seed_;
    int frame_;
};

/// The world in equal blocks, as recursive bisection divides a uniform world.
class Blocks {
public:
    Blocks(int ranks, double side) : ranks_(ranks), side_(side)
    {
        // The factors nearest to each other.
        int best = 1 << 30;
        for (int a = 1; a * a * a <= ranks; ++a)
            for (int b = a; ranks % a == 0 && a * b * b <= ranks; ++b)
                if (ranks / a % b == 0 && ranks / a / b - a < best)
                    best = ranks / a / b - a, count_ = {a, b, ranks / a / b};
    }
    int ranks() const { return ranks_; }
    const Array3i& count() const { return count_; }
    Array3i place(int rank) const
    {
        return {rank % count_[0], rank / count_[0] % count_[1], rank / count_[0] / count_[1]};
    }
    /// The block of a point: monotonic in each coordinate.
    Array3i of(const Vector3d& p) const
    {
        return (p.array() * count_.cast<double>() / side_).floor().cast<int>().max(0).min(count_ - 1);
    }
    Array3d begin(const Array3i& place) const { return place.cast<double>() * side_ / count_.cast<double>(); }

private:
    int ranks_;
    double side_;
    Array3i count_;
};

struct Rank {
    int number = 0;
    std::uint64_t home = 0, ghosts = 0, pairs = 0, hash = 0;
    std::size_t bytes = 0, held = 0; ///< of received ghosts, and of all data
    double model_ghosts = 0, ms = 0;
};

/// Bytes that a rank receives for a ghost without a name.
std::size_t ghost_bytes()
{
    Bytes message;
    put(message, BodyHere{});
    return message.size() + 1;
}

/// Number of ghosts of a block: bodies whose AABBs extend into it over a face, an edge or a corner inside the world.
double model_ghosts(const UniformWorld& world, const Blocks& blocks, const Array3i& place)
{
    const Array3d e = world.side() / blocks.count().cast<double>(); // lengths of the block
    const Array3d o =                                               // half the number of faces with a neighbour
        0.5 * ((place > 0).cast<double>() + (place + 1 < blocks.count()).cast<double>());
    return world.moment(1) * (e[1] * e[2] * o[0] + e[0] * e[2] * o[1] + e[0] * e[1] * o[2]) +
           world.moment(2) * (e[0] * o[1] * o[2] + e[1] * o[0] * o[2] + e[2] * o[0] * o[1]) +
           world.moment(3) * o.prod();
}

/// Finds the bodies of the rank, their pairs, and the owners of the pairs, by the rules of RankWorld.
Rank play_rank(const UniformWorld& world, const Blocks& blocks, int number)
{
    const Clock::time_point began = Clock::now();
    const Array3i place = blocks.place(number);
    Rank rank{.number = number, .model_ghosts = model_ghosts(world, blocks, place)};
    const double halo = 0.5 * world.largest() + 1;
    const Array3i from = (blocks.begin(place) - halo).floor().cast<int>().max(0),
                  to = (blocks.begin(place + 1) + halo).ceil().cast<int>().min(world.side());
    std::vector<Aabb> boxes;
    std::vector<std::uint32_t> gids;
    for (int z = from[2]; z < to[2]; ++z)
        for (int y = from[1]; y < to[1]; ++y)
            for (int x = from[0]; x < to[0]; ++x) {
                const Aabb box = world.box(x, y, z);
                if ((blocks.of(box.min) > place).any() || (blocks.of(box.max) < place).any()) continue;
                ++((blocks.of(box.centre()) == place).all() ? rank.home : rank.ghosts);
                boxes.push_back(box), gids.push_back(world.index(x, y, z));
            }
    const auto broad = make_kd_tree();
    std::vector<std::uint32_t> all(boxes.size());
    std::iota(all.begin(), all.end(), 0u);
    broad->add(all);
    const auto pairs = broad->find_pairs({.boxes = boxes}, true);
    for (const BodyPair pair : pairs) {
        if ((blocks.of(boxes[pair.a].min.cwiseMax(boxes[pair.b].min)) != place).any()) continue;
        ++rank.pairs;
        const auto [low, high] = std::minmax(gids[pair.a], gids[pair.b]);
        rank.hash += splitmix(std::uint64_t{low} << 32 | high);
    }
    rank.bytes = rank.ghosts * ghost_bytes();
    rank.held = boxes.capacity() * sizeof(Aabb) + (gids.capacity() + all.capacity()) * 4 + broad->bytes() +
                pairs.size() * sizeof(BodyPair) + rank.home * sizeof(BodyRecord) + rank.ghosts * sizeof(BodyHere);
    rank.ms = milliseconds_since(began);
    return rank;
}

/// Parallel efficiency of a frame by the model: the time of one process divided by the total time of all ranks; broad
/// phase only, a microsecond per body.
double model_efficiency(double home, double ghosts, int ranks)
{
    const double body_us = 1, bytes_of_a_ghost = 184, bytes_a_us = 10e9 / 48 / 1e6;
    const double talk = 26 * 2 + ghosts * bytes_of_a_ghost / bytes_a_us + 2 * std::log2(ranks) * 5;
    return home * body_us / ((home + 1.05 * ghosts) * 1.05 * body_us + talk);
}

std::vector<int> sampled(int ranks, int sample)
{
    if (sample == 0 || sample > ranks) sample = ranks;
    // A stride coprime to `ranks`, which the blocks' counts divide; otherwise only blocks at edges would be sampled.
    int stride = std::max(1, ranks / sample);
    while (std::gcd(stride, ranks) != 1) ++stride;
    std::vector<int> numbers;
    for (int k = 0; k < sample; ++k) numbers.push_back(int(std::int64_t(k) * stride % ranks));
    return numbers;
}

/// Prints the cost of the ranks. True if the number of ghosts agrees with the model to a tenth.
bool report(const UniformWorld& world, const Blocks& blocks, const std::vector<Rank>& ranks, const Rank& sum)
{
    Rank most;
    double worst = 1;
    for (const Rank& r : ranks) {
        most.home = std::max(most.home, r.home), most.ghosts = std::max(most.ghosts, r.ghosts);
        most.held = std::max(most.held, r.held);
        worst = std::min(worst, model_efficiency(double(r.home), double(r.ghosts), blocks.ranks()));
    }
    const double n = double(ranks.size()), home = double(sum.home) / n, ghosts = double(sum.ghosts) / n;
    say("ranks      {} as {} x {} x {} blocks, {} played\n\n", blocks.ranks(), blocks.count()[0], blocks.count()[1],
        blocks.count()[2], ranks.size());
    ResultTable table({}, {36});
    using Maybe = std::optional<double>;
    const auto row = [&](const char* what, double mean, Maybe extreme, Maybe model) {
        table.print(figures("per_rank", what, "mean", mean, "extreme", extreme, "model", model));
    };
    row("own bodies", home, double(most.home), double(world.bodies()) / blocks.ranks());
    row("ghosts", ghosts, double(most.ghosts), sum.model_ghosts / n);
    row("MB of ghosts per frame", 1e-6 * double(sum.bytes) / n, {},
        1e-6 * double(ghost_bytes()) * sum.model_ghosts / n);
    row("MB held", 1e-6 * double(sum.held) / n, 1e-6 * double(most.held), {});
    row("us per body, with its creation", 1e3 * sum.ms / n / (home + ghosts), {}, {});
    row("efficiency by the model", model_efficiency(home, ghosts, blocks.ranks()), worst, {});
    say("pairs      {}, order-free hash {:016x}{}\n", sum.pairs, sum.hash,
        int(ranks.size()) == blocks.ranks() ? "" : " (of the ranks played)");
    const bool off = sum.model_ghosts > 0 && std::abs(double(sum.ghosts) / sum.model_ghosts - 1) > 0.1;
    if (off) say("FAULT      the number of ghosts differs from the model by more than a tenth\n");
    return !off;
}

/// Plays ranks of a large uniform world one after another on this machine, and compares them with a cost model. Returns
/// the exit code: 70 if ghosts differ from the model by more than a tenth, or two numbers of ranks find different
/// pairs.
int bench_scale(const ScaleOptions& o)
{
    if (!(o.bodies >= 1 && o.bodies <= 4e9)) usage(fmt::format("--bodies {}: must be from 1 to 4e9", o.bodies));
    if (!(o.edge > 0 && o.edge <= 10)) usage(fmt::format("--edge {}: must be above 0 and at most 10", o.edge));
    const std::vector<std::size_t> counts = parse_counts("--ranks", o.ranks, 1'000'000);
    const Shard shard = shard_from(o.shard);
    if (!shard.whole() && counts.size() > 1) usage("--shard: needs a single number of ranks, whose ranks are divided");
    check_parts(shard, sampled(int(counts.front()), o.sample).size(), "ranks");
    const UniformWorld world(o.bodies, o.edge, o.seed, o.frame);
    say("world      {} cubes, frame {}, mean edge {} spacings, one of {} is {} times as large\n", world.bodies(),
        o.frame, o.edge, large_every, large_by);
    ResultTable table(o.csv, {},
                      shard.line(fmt::format("bench scale, {} bodies, {} ranks, sample {}, edge {}, seed {}, frame {}",
                                             world.bodies(), o.ranks, o.sample, o.edge, o.seed, o.frame)));
    std::optional<Rank> whole; // the sums of the first number of ranks of which all were played; its number: of ranks
    bool good = true;
    for (const std::size_t count : counts) {
        const Blocks blocks(int(count), world.side());
        std::vector<int> numbers = sampled(int(count), o.sample);
        keep_part(shard, numbers, "ranks");
        std::vector<Rank> ranks(numbers.size());
        parallel_chunks(numbers.size(), 1, threads_of(o.threads), [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t k = begin; k < end; ++k) ranks[k] = play_rank(world, blocks, numbers[k]);
        });
        Rank sum{.number = int(count)};
        for (const Rank& r : ranks) {
            sum.home += r.home, sum.ghosts += r.ghosts, sum.pairs += r.pairs, sum.hash += r.hash;
            sum.bytes += r.bytes, sum.held += r.held, sum.model_ghosts += r.model_ghosts, sum.ms += r.ms;
            table.row({}, figures("world", world.bodies(), "ranks", count, "rank", r.number, "bodies", r.home, "ghosts",
                                  r.ghosts, "model_ghosts", r.model_ghosts, "pairs", r.pairs, "hash", Hex{r.hash},
                                  "ghost_bytes", r.bytes, "held_bytes", r.held, "ms", r.ms));
        }
        good &= report(world, blocks, ranks, sum);
        if (ranks.size() < count) continue;
        if (!whole) whole = sum;
        if (sum.pairs != whole->pairs || sum.hash != whole->hash) {
            say("FAULT      {} ranks found different pairs than {}\n", count, whole->number);
            good = false;
        }
    }
    say("process    {:.0f} MB at most\n", double(peak_memory()) / 1e6);
    table.commit();
    return code_of(!good);
}

} // namespace

void add_scale(Arguments bench)
{
    Benchmark<ScaleOptions> b(
        bench, "scale", "Ranks of a large world, simulated one after another, compared with a cost model", bench_scale);
    b.option("--bodies N", b->bodies, "approximate number of bodies in the world, a cube of cells (default 1e6)");
    b.option("--ranks LIST", b->ranks, "numbers of ranks to compare (default 64)");
    b.whole("--sample N", b->sample, "number of ranks to play; 0: all", {0});
    b.option("--edge E", b->edge, "mean edge of the bodies, in mean spacings (default 1)");
    b.whole("--frame F", b->frame, "frame of the motion", {0});
    b.threads("ranks played at the same time"), b.seed("the bodies"), b.csv("rank"), b.shard("ranks");
    b.footer("If all ranks are played, pairs and hash do not depend on the number of ranks. Exit code 70: they do,\n"
             "or the number of ghosts differs from the model by more than a tenth.\n"
             "  oncollide-lab bench scale --ranks 8,64 --bodies 1e6\n"
             "  oncollide-lab bench scale --ranks 10000 --bodies 1e9 --sample 26");
}

} // namespace oncollide::tools

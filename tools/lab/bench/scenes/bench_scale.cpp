// oncollide-lab bench scale: the work of each of very many ranks, without the machines. Bodies are a function of their
// index and the frame, so a single rank can be played without reading any file: it computes the bodies in and near its
// region.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <numeric>
#include <vector>

#include <fmt/format.h>

#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/runs/ranks/body_record.hpp>

#include "bench/bench.hpp"
#include "cli/options.hpp"
#include "cli/shard.hpp"
#include "cli/system.hpp"
#include "common/text.hpp"

namespace oncollide::tools {
namespace {

struct ScaleOptions {
    double bodies = 1e6;
    std::string ranks = "64"; ///< numbers of ranks; each number divides the whole world
    int sample = 0;           ///< ranks to play; 0: all
    double edge = 1;          ///< mean, in mean spacings
    int frame = 0, threads = 1;
    std::uint64_t seed = 12345;
    std::string csv, shard;
};

using Eigen::Vector3d;

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
    Blocks(int ranks, double side) : side_(side)
    {
        // The factors nearest to each other.
        int best = 1 << 30;
        for (int a = 1; a * a * a <= ranks; ++a)
            for (int b = a; ranks % a == 0 && a * b * b <= ranks; ++b)
                if (ranks / a % b == 0 && ranks / a / b - a < best)
                    best = ranks / a / b - a, count_ = {a, b, ranks / a / b};
    }
    std::array<int, 3> place(int rank) const
    {
        return {rank % count_[0], rank / count_[0] % count_[1], rank / count_[0] / count_[1]};
    }
    /// The block along an axis: monotonic in x.
    int part(double x, int axis) const
    {
        const int count = count_[std::size_t(axis)];
        return std::clamp(int(std::floor(x * count / side_)), 0, count - 1);
    }
    double begin(int part, int axis) const { return part * side_ / count_[std::size_t(axis)]; }
    const std::array<int, 3>& count() const { return count_; }

private:
    double side_;
    std::array<int, 3> count_{};
};

struct Rank {
    int number = 0;
    std::uint64_t home = 0, ghosts = 0, pairs = 0, hash = 0;
    std::size_t bytes = 0; ///< of received ghosts, and of all data held
    std::size_t held = 0;
    double ms = 0;
};

/// Bytes that a rank receives for a ghost without a name.
std::size_t ghost_bytes()
{
    Bytes message;
    put(message, BodyHere{});
    return message.size() + 1;
}

/// Finds the bodies of the rank, their pairs, and the owners of the pairs, by the rules of RankWorld.
Rank play_rank(const UniformWorld& world, const Blocks& blocks, int number)
{
    const auto begin_time = std::chrono::steady_clock::now();
    Rank rank{.number = number};
    const auto place = blocks.place(number);
    std::array<int, 3> from, to;
    const double halo = 0.5 * world.largest() + 1;
    for (int k = 0; k < 3; ++k) {
        from[std::size_t(k)] = std::max(0, int(std::floor(blocks.begin(place[std::size_t(k)], k) - halo)));
        to[std::size_t(k)] = std::min(world.side(), int(std::ceil(blocks.begin(place[std::size_t(k)] + 1, k) + halo)));
    }
    std::vector<Aabb> boxes;
    std::vector<std::uint32_t> gids;
    for (int z = from[2]; z < to[2]; ++z)
        for (int y = from[1]; y < to[1]; ++y)
            for (int x = from[0]; x < to[0]; ++x) {
                const Aabb box = world.box(x, y, z);
                const Vector3d centre = box.centre();
                bool touches = true, home = true;
                for (int k = 0; k < 3; ++k) {
                    const int here = place[std::size_t(k)];
                    touches &= blocks.part(box.min[k], k) <= here && here <= blocks.part(box.max[k], k);
                    home &= blocks.part(centre[k], k) == here;
                }
                if (!touches) continue;
                ++(home ? rank.home : rank.ghosts);
                boxes.push_back(box), gids.push_back(world.index(x, y, z));
            }
    const auto broad = make_kd_tree();
    std::vector<std::uint32_t> all(boxes.size());
    std::iota(all.begin(), all.end(), 0u);
    broad->add(all);
    const auto pairs = broad->find_pairs({.boxes = boxes}, true);
    for (const BodyPair pair : pairs) {
        const Vector3d corner = boxes[pair.a].min.cwiseMax(boxes[pair.b].min);
        bool mine = true;
        for (int k = 0; k < 3; ++k) mine &= blocks.part(corner[k], k) == place[std::size_t(k)];
        if (!mine) continue;
        ++rank.pairs;
        const auto [low, high] = std::minmax(gids[pair.a], gids[pair.b]);
        rank.hash += splitmix(std::uint64_t{low} << 32 | high);
    }
    rank.bytes = rank.ghosts * ghost_bytes();
    rank.held = boxes.capacity() * sizeof(Aabb) + (gids.capacity() + all.capacity()) * 4 + broad->bytes() +
                pairs.size() * sizeof(BodyPair) + rank.home * sizeof(BodyRecord) + rank.ghosts * sizeof(BodyHere);
    rank.ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin_time).count();
    return rank;
}

/// Number of ghosts of a block: bodies whose AABBs extend into it over a face, an edge or a corner inside the world.
double model_ghosts(const UniformWorld& world, const Blocks& blocks, int number)
{
    const auto place = blocks.place(number);
    std::array<double, 3> edge, open; // lengths; number of faces with a neighbour, halved
    for (int k = 0; k < 3; ++k) {
        const int count = blocks.count()[std::size_t(k)], at = place[std::size_t(k)];
        edge[std::size_t(k)] = double(world.side()) / count;
        open[std::size_t(k)] = 0.5 * ((at > 0) + (at + 1 < count));
    }
    const double s1 = world.moment(1), s2 = world.moment(2), s3 = world.moment(3);
    return s1 * (edge[1] * edge[2] * open[0] + edge[0] * edge[2] * open[1] + edge[0] * edge[1] * open[2]) +
           s2 * (edge[0] * open[1] * open[2] + edge[1] * open[0] * open[2] + edge[2] * open[0] * open[1]) +
           s3 * open[0] * open[1] * open[2];
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
    std::vector<int> numbers;
    if (sample == 0 || sample >= ranks) {
        numbers.resize(std::size_t(ranks));
        std::iota(numbers.begin(), numbers.end(), 0);
        return numbers;
    }
    // A stride coprime to `ranks`, which the blocks' counts divide; otherwise only blocks at edges would be sampled.
    int stride = std::max(1, ranks / sample);
    while (std::gcd(stride, ranks) != 1) ++stride;
    for (int k = 0; k < sample; ++k) numbers.push_back(int(std::int64_t(k) * stride % ranks));
    return numbers;
}

/// A partition of the world, as far as it was played.
struct Partition {
    Blocks blocks;
    int count; ///< number of ranks
    std::vector<Rank> ranks;

    bool all() const { return ranks.size() == std::size_t(count); }
    std::uint64_t pairs() const { return sum(&Rank::pairs); }
    std::uint64_t hash() const { return sum(&Rank::hash); }

private:
    std::uint64_t sum(std::uint64_t Rank::*of) const
    {
        return std::transform_reduce(ranks.begin(), ranks.end(), std::uint64_t{0}, std::plus<>(),
                                     [&](const Rank& rank) { return rank.*of; });
    }
};

Partition play(const UniformWorld& world, int count, int sample, int threads, const Shard& shard)
{
    Partition partition{Blocks(count, world.side()), count, {}};
    std::vector<int> numbers = sampled(count, sample);
    keep_part(shard, numbers, "ranks");
    partition.ranks.resize(numbers.size());
    parallel_chunks(numbers.size(), 1, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t k = begin; k < end; ++k) partition.ranks[k] = play_rank(world, partition.blocks, numbers[k]);
    });
    return partition;
}

/// Prints the cost of the ranks. True if the number of ghosts agrees with the model to a tenth.
bool report(const UniformWorld& world, const Partition& partition)
{
    double home = 0, ghosts = 0, model = 0, ms = 0, bytes = 0, most_home = 0, most_ghosts = 0, most_held = 0;
    double least_efficiency = 1;
    for (const Rank& r : partition.ranks) {
        home += double(r.home), ghosts += double(r.ghosts), ms += r.ms, bytes += double(r.bytes);
        model += model_ghosts(world, partition.blocks, r.number);
        most_home = std::max(most_home, double(r.home)), most_ghosts = std::max(most_ghosts, double(r.ghosts));
        most_held = std::max(most_held, double(r.held));
        least_efficiency =
            std::min(least_efficiency, model_efficiency(double(r.home), double(r.ghosts), partition.count));
    }
    const double n = double(partition.ranks.size());
    const auto& blocks = partition.blocks.count();
    say("ranks      {} as {} x {} x {} blocks, {} played\n\n", partition.count, blocks[0], blocks[1], blocks[2],
        partition.ranks.size());
    say("{:<34}{:>14}{:>14}{:>14}\n", "per rank", "mean", "max", "model");
    say("{:<34}{:>14.0f}{:>14.0f}{:>14.0f}\n", "own bodies", home / n, most_home,
        double(world.bodies()) / partition.count);
    say("{:<34}{:>14.0f}{:>14.0f}{:>14.0f}\n", "ghosts", ghosts / n, most_ghosts, model / n);
    say("{:<34}{:>14.3f}{:>14}{:>14.3f}\n", "MB of ghosts per frame", bytes / n / 1e6, "",
        double(ghost_bytes()) * model / n / 1e6);
    say("{:<34}{:>14}{:>14.1f}\n", "MB held", "", most_held / 1e6);
    say("{:<34}{:>14.3f}\n", "us per body, with its creation", 1e3 * ms / (home + ghosts));
    say("{:<34}{:>14.3f}{:>14}\n", "efficiency by the model", model_efficiency(home / n, ghosts / n, partition.count),
        "");
    say("{:<34}{:>14.3f}\n\n", "  of the worst rank", least_efficiency);
    say("pairs      {}, order-free hash {:016x}{}\n", partition.pairs(), partition.hash(),
        partition.all() ? "" : " (of the ranks played)");
    const bool off = model > 0 && std::abs(ghosts / model - 1) > 0.1;
    if (off) say("FAULT      the number of ghosts differs from the model by more than a tenth\n");
    return !off;
}

void write_rows(const std::string& path, const std::string& head, const UniformWorld& world,
                const std::vector<Partition>& partitions)
{
    CsvFile csv(path, "world,ranks,rank,bodies,ghosts,model_ghosts,pairs,hash,ghost_bytes,held_bytes,ms", head);
    for (const Partition& partition : partitions)
        for (const Rank& r : partition.ranks)
            csv.row(world.bodies(), partition.count, r.number, r.home, r.ghosts,
                    Fixed{model_ghosts(world, partition.blocks, r.number), 1}, r.pairs, Hex{r.hash}, r.bytes, r.held,
                    Fixed{r.ms, 3});
    csv.commit();
}

/// Plays ranks of a large uniform world one after another on this machine, and compares them with a cost model. Returns
/// the exit code: 70 if ghosts differ from the model by more than a tenth, or two numbers of ranks find different
/// pairs.
int bench_scale(const ScaleOptions& o)
{
    if (!(o.bodies >= 1 && o.bodies <= 4e9)) usage(fmt::format("--bodies {}: must be from 1 to 4e9", o.bodies));
    if (!(o.edge > 0 && o.edge <= 10)) usage(fmt::format("--edge {}: must be above 0 and at most 10", o.edge));
    check_range("--sample", o.sample, 0);
    check_range("--frame", o.frame, 0), check_range("--threads", o.threads, 0, 1024);
    check_files({{"--csv", o.csv}});
    const std::vector<std::size_t> counts = parse_counts("--ranks", o.ranks, 1'000'000);
    const Shard shard = shard_from(o.shard);
    if (!shard.whole() && counts.size() > 1) usage("--shard: needs a single number of ranks, whose ranks are divided");
    check_parts(shard, sampled(int(counts.front()), o.sample).size(), "ranks");
    const UniformWorld world(o.bodies, o.edge, o.seed, o.frame);
    const int threads = o.threads ? o.threads : hardware_threads();
    say("world      {} cubes, frame {}, mean edge {} spacings, one of {} is {} times as large\n", world.bodies(),
        o.frame, o.edge, large_every, large_by);
    std::vector<Partition> partitions;
    bool good = true;
    for (const std::size_t count : counts) {
        partitions.push_back(play(world, int(count), o.sample, threads, shard));
        good &= report(world, partitions.back());
        const Partition& first = partitions.front();
        if (first.all() && partitions.back().all() &&
            (partitions.back().pairs() != first.pairs() || partitions.back().hash() != first.hash())) {
            say("FAULT      {} ranks found different pairs than {}\n", count, first.count);
            good = false;
        }
    }
    say("process    {:.0f} MB at most\n", double(peak_memory()) / 1e6);
    write_rows(o.csv,
               shard.line(fmt::format("bench scale, {} bodies, {} ranks, sample {}, edge {}, seed {}, frame {}",
                                      world.bodies(), o.ranks, o.sample, o.edge, o.seed, o.frame)),
               world, partitions);
    return good ? 0 : int(ErrorKind::internal);
}

} // namespace

void add_scale(Arguments bench)
{
    Arguments sub = bench.add_command("scale", "Ranks of a large world, simulated one after another, compared with a "
                                               "cost model");
    auto options = std::make_shared<ScaleOptions>();
    sub.add_option("--bodies N", options->bodies,
                   "approximate number of bodies in the world, a cube of cells (default 1e6)");
    sub.add_option("--ranks LIST", options->ranks, "numbers of ranks to compare (default 64)");
    sub.add_option("--sample N", options->sample, "number of ranks to play; 0: all (default 0)");
    sub.add_option("--edge E", options->edge, "mean edge of the bodies, in mean spacings (default 1)");
    sub.add_option("--frame F", options->frame, "frame of the motion (default 0)");
    sub.add_option("--threads N", options->threads,
                   "ranks played at the same time; 0: as many as processors (default 1)");
    sub.add_option("--seed S", options->seed, "seed of the bodies (default 12345)");
    sub.add_option("--csv FILE", options->csv, "write one row per rank");
    sub.add_option("--shard I/N", options->shard, std::string("divide the ranks among N processes: ") + shard_help);
    sub.footer("If all ranks are played, pairs and hash do not depend on the number of ranks. Exit code 70: they do,\n"
               "or the number of ghosts differs from the model by more than a tenth.\n"
               "  oncollide-lab bench scale --ranks 8,64 --bodies 1e6\n"
               "  oncollide-lab bench scale --ranks 10000 --bodies 1e9 --sample 26");
    sub.action([options] { return bench_scale(*options); });
}

} // namespace oncollide::tools

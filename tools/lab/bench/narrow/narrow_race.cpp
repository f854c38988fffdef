#include "bench/narrow/narrow_race.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/scenes/motion.hpp>

#include "cli/progress.hpp"
#include "cli/system.hpp"
#include "common/race.hpp"
#include "common/text.hpp"

namespace oncollide::tools {
namespace {

constexpr double long_ms = 5;        // a query that took longer in total is not repeated
constexpr double long_loop_ms = 200; // a loop

/// The result of any kind of query.
struct Found {
    bool colliding = false;
    std::vector<TrianglePair> pairs;
    double distance = 0;
};

void give(NarrowPeer& peer, NarrowQuery query, const Eigen::Isometry3d& pose, Found& found)
{
    if (query == NarrowQuery::boolean)
        found.colliding = peer.collides(pose);
    else if (query == NarrowQuery::all)
        peer.all_pairs(pose, found.pairs);
    else
        found.distance = peer.distance(pose);
}

/// Independent of the order of pairs.
std::uint64_t hash_of(NarrowQuery query, const Found& found)
{
    if (query == NarrowQuery::boolean) return splitmix(found.colliding);
    if (query == NarrowQuery::distance) return splitmix(std::bit_cast<std::uint64_t>(found.distance));
    std::uint64_t sum = 0;
    for (const TrianglePair& pair : found.pairs) sum += splitmix(std::uint64_t{pair.a} << 32 | pair.b);
    return splitmix(sum);
}

std::uint64_t not_in(const std::vector<TrianglePair>& these, const std::vector<TrianglePair>& those)
{
    std::uint64_t count = 0;
    for (const TrianglePair& pair : these) count += !std::binary_search(those.begin(), those.end(), pair);
    return count;
}

class NarrowRace {
public:
    NarrowRace(const Mesh& a, const Mesh& b, const NarrowWorkload& workload, const NarrowTruth& truth,
               const std::vector<NarrowQuery>& queries, int repeats)
        : a_(a), b_(b), workload_(workload), truth_(truth), queries_(queries), repeats_(repeats)
    {
    }

    /// Builds the contender and runs every pose once.
    void enter(const NarrowContender& contender)
    {
        NarrowRow row;
        row.contender = &contender;
        for (NarrowQuery query : queries_)
            if (supports(contender, query)) row.queries[std::size_t(query)] = empty_result(query);
        trim_memory();
        const double before = double(resident_memory());
        row.build_ms = least_ms(1, [&] { row.peer = contender.make(a_, b_); });
        const Clock::time_point from = Clock::now();
        Progress progress("warming up " + contender.name, workload_.poses.size());
        for (const NarrowPose& pose : workload_.poses) {
            for (NarrowQuery query : queries_)
                if (supports(contender, query)) give(*row.peer, query, pose.known.b, found_);
            progress.step();
        }
        row.warm_up_ms = milliseconds_since(from);
        trim_memory();
        row.bytes = std::max(0.0, double(resident_memory()) - before);
        rows_.push_back(std::move(row));
    }

    std::vector<NarrowRow> run()
    {
        Progress progress("measuring", workload_.poses.size());
        for (std::size_t pose = 0; pose < workload_.poses.size(); ++pose, progress.step())
            for (NarrowQuery query : queries_)
                take_turns(rows_.size(), pose, [&](std::size_t k) {
                    if (supports(*rows_[k].contender, query)) measure(rows_[k], query, pose);
                });
        for (std::size_t group = 0; group < workload_.groups.size(); ++group)
            for (NarrowQuery query : queries_)
                take_turns(rows_.size(), group, [&](std::size_t k) {
                    if (supports(*rows_[k].contender, query)) measure_loop(rows_[k], query, group);
                });
        for (NarrowRow& row : rows_) row.figures = row.peer->figures();
        return std::move(rows_);
    }

private:
    QueryResult empty_result(NarrowQuery query) const
    {
        const std::size_t poses = workload_.poses.size();
        QueryResult result;
        result.us.resize(poses), result.hashes.resize(poses);
        if (query == NarrowQuery::distance)
            result.errors.resize(poses);
        else
            result.missed.resize(poses), result.extra.resize(poses);
        return result;
    }

    void measure(NarrowRow& row, NarrowQuery query, std::size_t pose)
    {
        QueryResult& result = *row.queries[std::size_t(query)];
        result.us[pose] =
            1e3 * least_ms(
                      repeats_, [&] { give(*row.peer, query, workload_.poses[pose].known.b, found_); }, long_ms);
        result.hashes[pose] = hash_of(query, found_);
        compare(query, pose, result);
    }

    void measure_loop(NarrowRow& row, NarrowQuery query, std::size_t group)
    {
        QueryResult& result = *row.queries[std::size_t(query)];
        std::vector<const Eigen::Isometry3d*> poses;
        for (const NarrowPose& pose : workload_.poses)
            if (pose.group == group) poses.push_back(&pose.known.b);
        const double ms = least_ms(
            repeats_,
            [&] {
                for (const Eigen::Isometry3d* pose : poses) give(*row.peer, query, *pose, found_);
            },
            long_loop_ms);
        result.loop_us.push_back(poses.empty() ? 0 : 1e3 * ms / double(poses.size()));
    }

    void compare(NarrowQuery query, std::size_t pose, QueryResult& result)
    {
        if (query == NarrowQuery::boolean) {
            result.missed[pose] = !found_.colliding && truth_.colliding[pose];
            result.extra[pose] = found_.colliding && !truth_.colliding[pose];
        } else if (query == NarrowQuery::all) {
            std::vector<TrianglePair>& given = found_.pairs;
            std::sort(given.begin(), given.end());
            const auto once = std::unique(given.begin(), given.end());
            const std::uint64_t twice = std::uint64_t(given.end() - once);
            given.erase(once, given.end());
            result.missed[pose] = not_in(truth_.pairs[pose], given);
            result.extra[pose] = not_in(given, truth_.pairs[pose]) + twice;
        } else {
            result.errors[pose] = std::abs(found_.distance - truth_.distances[pose]);
        }
    }

    const Mesh &a_, &b_;
    const NarrowWorkload& workload_;
    const NarrowTruth& truth_;
    const std::vector<NarrowQuery>& queries_;
    int repeats_;
    std::vector<NarrowRow> rows_;
    Found found_;
};

} // namespace

bool supports(const NarrowContender& contender, NarrowQuery query)
{
    return query == NarrowQuery::boolean ||
           (query == NarrowQuery::all ? contender.has_all_pairs : contender.has_distance);
}

std::vector<NarrowRow> race(const Mesh& a, const Mesh& b, const NarrowWorkload& workload, const NarrowTruth& truth,
                            const std::vector<NarrowContender>& contenders, const std::vector<NarrowQuery>& queries,
                            int repeats)
{
    NarrowRace race(a, b, workload, truth, queries, repeats);
    for (const NarrowContender& contender : contenders)
        if (std::any_of(queries.begin(), queries.end(), [&](NarrowQuery query) { return supports(contender, query); }))
            race.enter(contender);
    return race.run();
}

} // namespace oncollide::tools

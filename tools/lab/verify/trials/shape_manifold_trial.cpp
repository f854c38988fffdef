#include "verify/trials/shape_manifold_trial.hpp"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/world.hpp>

#include "verify/cases/placed_body.hpp"

namespace oncollide::tools {
namespace {

constexpr int shape_count = std::size(shape_kinds), ground_count = std::size(ground_kinds);
constexpr int half_space = int(ShapeKind::half_space);

const std::vector<std::pair<int, int>>& pairs_of_kinds()
{
    static const std::vector<std::pair<int, int>> all = [] {
        std::vector<std::pair<int, int>> pairs;
        for (int a = 0; a < shape_count; ++a)
            for (int b = a; b < shape_count; ++b)
                if (a != half_space) pairs.emplace_back(a, b);
        for (int a = 0; a < shape_count; ++a)
            for (int b = 0; b < ground_count; ++b)
                if (a != half_space) pairs.emplace_back(a, shape_count + b);
        return pairs;
    }();
    return all;
}

std::string_view name_of_kind(int kind)
{
    return kind < shape_count ? shape_kinds[kind] : ground_kinds[kind - shape_count];
}

class ShapeManifoldTrial {
public:
    ShapeManifoldTrial(std::uint64_t seed, const std::pair<int, int>& kinds, ShapeManifoldTally& tally)
        : seed_(seed), kinds_(kinds), counts_(tally.by_kinds[kinds])
    {
    }

    void run()
    {
        ++counts_.pairs;
        if (kinds_.second >= shape_count)
            try_ground();
        else
            try_shapes();
    }

private:
    /// Half of the pairs have the kinds in the other order.
    bool swap_kinds() const { return (seed_ >> 1) % 2 != 0; }

    void try_shapes()
    {
        auto [first, second] = kinds_;
        if (swap_kinds()) std::swap(first, second);
        const ShapePair pair = draw_shape_pair(ShapeKind(first), ShapeKind(second), seed_);
        const Eigen::Vector3d origin = pair.pose_a.translation();
        const oracle::SolidTruth a(pair.a, pair.pose_a, origin), b(pair.b, pair.pose_b, origin);
        query(pair.a, pair.pose_a, pair.b, pair.pose_b, pair.margin);
        take(oracle::judge_shapes(a, b, answer()), pair.what);
    }

    void try_ground()
    {
        const ShapeOnGround drawn =
            draw_shape_on_ground(ShapeKind(kinds_.first), GroundKind(kinds_.second - shape_count), seed_);
        const bool shape_first = swap_kinds();
        if (shape_first)
            query(drawn.shape, drawn.pose_shape, drawn.ground, drawn.pose_ground, drawn.margin);
        else
            query(drawn.ground, drawn.pose_ground, drawn.shape, drawn.pose_shape, drawn.margin);
        const oracle::SolidTruth solid(drawn.shape, drawn.pose_shape, drawn.pose_shape.translation());
        take(oracle::judge_on_ground(drawn.parts, drawn.may_be_below, solid, shape_first, answer()), drawn.what);
    }

    void query(const GeometryData& a, const Eigen::Isometry3d& pose_a, const GeometryData& b,
               const Eigen::Isometry3d& pose_b, double margin)
    {
        World world({.mode = Mode::solid});
        const auto add = [&](const GeometryData& data, const Eigen::Isometry3d& pose) {
            return world.bodies().add({.model = add_model(world, data), .pose = pose});
        };
        const BodyId of_a = add(a, pose_a), of_b = add(b, pose_b);
        options_.margin = margin, options_.measures = seed_ % 8 == 0;
        verdict_ = world.pairs().decide(of_a, of_b).verdict;
        there_ = world.pairs().manifold(of_a, of_b, options_), back_ = world.pairs().manifold(of_b, of_a, options_);
    }
    oracle::ShapeAnswer answer() const { return {verdict_, there_, back_, options_}; }

    void take(const oracle::ShapeVerdict& found, const std::string& what)
    {
        counts_.meet += found.meet, counts_.near += found.near;
        counts_.regions += there_.regions.size(), counts_.points += there_.points.size();
        if (found.faults.empty()) return;
        ++counts_.faulty;
        for (const oracle::ShapeFault& fault : found.faults)
            counts_.faults.push_back(
                {seed_, fault.claim, fmt::format("{} ({}): {}", name_of_kinds(kinds_), what, fault.what)});
    }

    const std::uint64_t seed_;
    const std::pair<int, int> kinds_;
    ShapeManifoldTally::Counts& counts_;
    ManifoldOptions options_;
    Verdict verdict_ = Verdict::undecided;
    Manifold there_, back_;
};

} // namespace

ShapeManifoldTally::Counts& ShapeManifoldTally::Counts::operator+=(const Counts& o)
{
    pairs += o.pairs, meet += o.meet, near += o.near, regions += o.regions, points += o.points, faulty += o.faulty;
    faults.insert(faults.end(), o.faults.begin(), o.faults.end());
    std::ranges::stable_sort(faults, {}, &Fault::seed);
    return *this;
}

std::array<std::uint64_t, oracle::shape_claim_count> ShapeManifoldTally::Counts::claims() const
{
    std::array<std::uint64_t, oracle::shape_claim_count> of_each{};
    for (const Fault& fault : faults) ++of_each[static_cast<std::size_t>(fault.claim)];
    return of_each;
}

ShapeManifoldTally& ShapeManifoldTally::operator+=(const ShapeManifoldTally& o)
{
    for (const auto& [kinds, counts] : o.by_kinds) by_kinds[kinds] += counts;
    return *this;
}

ShapeManifoldTally::Counts ShapeManifoldTally::all() const
{
    Counts sum;
    for (const auto& [kinds, counts] : by_kinds) sum += counts;
    return sum;
}

std::string name_of_kinds(const std::pair<int, int>& kinds)
{
    return fmt::format("{} {}", name_of_kind(kinds.first), name_of_kind(kinds.second));
}

std::pair<int, int> kinds_of(const std::string& names)
{
    std::string valid;
    for (int kind = 0; kind < shape_count + ground_count; ++kind)
        valid += fmt::format("{}{}", kind > 0 ? ", " : "", name_of_kind(kind));
    const auto find = [&](const std::string& name) {
        for (int kind = 0; kind < shape_count + ground_count; ++kind)
            if (name == name_of_kind(kind)) return kind;
        throw Error(ErrorKind::usage, fmt::format("--kinds: no kind '{}'; there are: {}", name, valid));
    };
    const std::size_t comma = names.find(',');
    if (comma == std::string::npos)
        throw Error(ErrorKind::usage, fmt::format("--kinds {}: give two kinds, as in sphere,box", names));
    std::pair<int, int> kinds{find(names.substr(0, comma)), find(names.substr(comma + 1))};
    if (kinds.first > kinds.second) std::swap(kinds.first, kinds.second);
    if (std::ranges::find(pairs_of_kinds(), kinds) == pairs_of_kinds().end())
        throw Error(ErrorKind::usage, fmt::format("--kinds {}: this pair is not judged", names));
    return kinds;
}

ShapeManifoldTally try_shape_manifolds(std::uint64_t first, std::uint64_t count, int threads,
                                       const std::function<void()>& done, std::optional<std::pair<int, int>> only)
{
    const auto run = [&](std::uint64_t seed, ShapeManifoldTally& tally) {
        const auto& all = pairs_of_kinds();
        ShapeManifoldTrial(seed, only ? *only : all[seed % all.size()], tally).run();
    };
    const std::size_t grain = std::clamp<std::size_t>(count / 256, 1, 4096); // a sum has a table of all kinds
    return sum_of_seeds<ShapeManifoldTally>(first, count, threads, run, done, grain);
}

} // namespace oncollide::tools

#include "view/page_frame.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include <oncollide/scenes/recording.hpp>

namespace oncollide::tools {
namespace {

// Limits per frame. Beyond these limits nothing is measured, and the page shows a pair between its bodies' AABBs.
constexpr std::size_t most_measured = 200;                      ///< pairs with nearest points, and pairs with contacts
constexpr std::size_t most_of_curve = 3000, most_of_pair = 400; ///< segments
constexpr std::size_t most_regions = 3000;

constexpr float not_known = std::numeric_limits<float>::quiet_NaN();

/// Rounded up, so that an upper bound stays certified as a float.
float above(double x)
{
    const float f = static_cast<float>(x);
    return double(f) < x ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}
float below(double x)
{
    return -above(-x);
}

/// JSON has neither infinities nor NaN.
nlohmann::json number(double x)
{
    return std::isfinite(x) ? nlohmann::json(x) : nlohmann::json();
}

/// Pairs with the lowest weight are left out first.
int weight(Verdict verdict)
{
    constexpr int weights[] = {0, 1, 3, 2};
    return weights[int(verdict)];
}

nlohmann::json stages_json(std::span<const StageStats> stages)
{
    nlohmann::json rows = nlohmann::json::array();
    for (const StageStats& s : stages)
        rows.push_back(
            {s.in, s.out, s.undecided, number(s.cpu_ms), s.skipped ? nlohmann::json(s.note) : nlohmann::json()});
    return rows;
}

nlohmann::json levels_json(std::span<const DelimitationLevel> levels)
{
    nlohmann::json rows = nlohmann::json::array();
    for (const DelimitationLevel& l : levels)
        rows.push_back({l.regions, l.regions_rejected, l.bodies_rejected, number(l.volume_rejected)});
    return rows;
}

} // namespace

PageFrames::PageFrames(const Scene& scene, const Pipeline& pipeline, const DeformingModels& deforming, bool separate,
                       std::size_t most_pairs)
    : scene_(scene), pipeline_(pipeline), deforming_(deforming), separate_(separate), most_pairs_(most_pairs),
      touched_(scene.geometries.size(), 0)
{
    Aabb around;
    for (std::size_t body = 0; body < scene.size(); ++body) around.add(scene.start_pose(body).translation());
    origin_ = around.empty() ? Eigen::Vector3d::Zero() : around.centre();
    for (std::uint32_t body = 0; body < scene.size(); ++body) {
        const bool recorded = scene.recording && body >= scene.recording->first &&
                              body - scene.recording->first < scene.recording->bodies;
        if (recorded || !std::holds_alternative<Still>(scene.motions[body])) moving_.push_back(body);
    }
}

const std::size_t PageFrames::bytes_of_rest = 28 * most_of_curve + 26 * most_regions;

std::size_t PageFrames::bytes_of_pair() const
{
    // Two bodies, bound, error, place and two distances as floats, times as two, and three small numbers.
    return 39 + (pipeline_.continuous() ? 8 : 0);
}

std::vector<PairResult> PageFrames::chosen(std::span<const PairResult> pairs) const
{
    std::vector<PairResult> all;
    for (const PairResult& pair : pairs)
        if (separate_ || pair.verdict != Verdict::separate) all.push_back(pair);
    if (all.size() <= most_pairs_) return all;
    std::stable_sort(all.begin(), all.end(),
                     [](const PairResult& a, const PairResult& b) { return weight(a.verdict) > weight(b.verdict); });
    all.resize(most_pairs_);
    std::sort(all.begin(), all.end(), [](const PairResult& a, const PairResult& b) {
        return std::pair(a.a.slot, a.b.slot) < std::pair(b.a.slot, b.b.slot);
    });
    return all;
}

/// The worst verdict of each body's pairs: 0 if it is in none, else 1 + weight().
std::vector<std::uint8_t> PageFrames::worst_of_bodies(std::span<const PairResult> pairs) const
{
    std::vector<std::uint8_t> worst(scene_.size());
    for (const PairResult& pair : pairs) {
        if (!separate_ && pair.verdict == Verdict::separate) continue;
        for (const BodyId body : {pair.a, pair.b})
            worst[index(body)] = std::max(worst[index(body)], std::uint8_t(1 + weight(pair.verdict)));
    }
    return worst;
}

/// The sweeps of chosen pairs; null: there is no sweep, or it found no contact.
std::vector<const PairSweep*> PageFrames::sweeps_of(const FrameView& view, std::span<const PairResult> chosen)
{
    std::vector<const PairSweep*> sweeps(chosen.size(), nullptr);
    std::size_t k = 0;
    for (const PairSweep& sweep : view.sweeps) {
        const PairResult& pair = view.pairs[sweep.pair];
        while (k < chosen.size() && std::pair(chosen[k].a.slot, chosen[k].b.slot) < std::pair(pair.a.slot, pair.b.slot))
            ++k;
        if (k == chosen.size()) break;
        if (chosen[k].a == pair.a && chosen[k].b == pair.b && std::isfinite(sweep.contact_by)) sweeps[k] = &sweep;
    }
    return sweeps;
}

PageFrames::Places PageFrames::places_of(std::span<const PairResult> pairs,
                                         std::span<const PairSweep* const> sweeps) const
{
    const World& world = pipeline_.world();
    Places places;
    places.where.assign(3 * pairs.size(), not_known);
    places.nearest.assign(pairs.size(), -1), places.apart.assign(pairs.size(), -1);
    const auto put = [&](std::size_t pair, const Eigen::Vector3d& at) {
        for (int axis = 0; axis < 3; ++axis) places.where[3 * pair + std::size_t(axis)] = float((at - origin_)[axis]);
    };
    const auto measure = [&](std::size_t k, double tolerance, double farthest) {
        const Distance d = world.pairs().distance(pairs[k].a, pairs[k].b, {tolerance, farthest});
        if (!std::isfinite(d.upper)) return;
        places.nearest[k] = below(d.lower), places.apart[k] = above(d.upper);
        put(k, 0.5 * (d.point_a + d.point_b));
    };

    std::vector<std::size_t> colliding;
    std::vector<PairOfBodies> bodies;
    std::size_t measured = 0;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
        const PairResult& pair = pairs[k];
        if (const PairSweep* const sweep = sweeps[k]; sweep && sweep->contact_by > 0) {
            if (sweep->kind != ContactKind::enclosed) put(k, sweep->contact.middle());
            continue;
        }
        if (pair.verdict == Verdict::colliding && colliding.size() < most_measured)
            colliding.push_back(k), bodies.push_back({pair.a, pair.b});
        if ((pair.verdict != Verdict::within && pair.verdict != Verdict::undecided) || measured++ >= most_measured)
            continue;
        const double error = world.pairs().max_error(pair.a, pair.b);
        measure(k, 0.02 * error, std::isfinite(pair.bound) ? 1.01 * pair.bound + error : pair.bound);
    }
    Lists<Contact> lists;
    world.pairs().contacts(bodies, lists);
    for (std::size_t c = 0, begin = 0; c < colliding.size(); begin = lists.offsets[++c]) {
        const std::size_t count = lists.offsets[c + 1] - begin;
        if (count == 0) { // one body is inside the other
            measure(colliding[c], world.pairs().max_error(bodies[c].a, bodies[c].b),
                    std::numeric_limits<double>::infinity());
            continue;
        }
        Aabb around;
        const std::size_t step = 1 + count / most_of_pair;
        for (std::size_t k = begin; k < begin + count; ++k) {
            const std::array<Eigen::Vector3d, 2>& ends = lists.items[k].ends;
            if (!ends[0].allFinite() || !ends[1].allFinite()) continue;
            around.add(ends[0]), around.add(ends[1]);
            if ((k - begin) % step || places.of_curve.size() >= most_of_curve) continue;
            append(places.curve, ends[0] - origin_), append(places.curve, ends[1] - origin_);
            places.of_curve.push_back(std::uint32_t(colliding[c]));
        }
        if (!around.empty()) put(colliding[c], around.centre());
    }
    return places;
}

PageFrame PageFrames::make(const FrameView& view)
{
    std::array<std::uint64_t, 4> verdicts{};
    for (const PairResult& pair : view.pairs) {
        ++verdicts[std::size_t(pair.verdict)];
        if (pair.verdict == Verdict::separate) continue;
        for (const BodyId body : {pair.a, pair.b}) ++touched_[index(scene_.geometry[index(body)])];
    }
    const std::vector<PairResult> pairs = chosen(view.pairs);
    const std::vector<const PairSweep*> sweeps = sweeps_of(view, pairs);
    const Places places = places_of(pairs, sweeps);
    std::vector<DelimitedRegion> regions = pipeline_.inspect().regions;
    const std::size_t all_regions = regions.size();
    if (regions.size() > most_regions) regions.resize(most_regions); // the deepest levels come last
    std::uint64_t listed = 0;
    for (std::size_t v = 0; v < verdicts.size(); ++v) listed += v || separate_ ? verdicts[v] : 0;
    const std::uint64_t left_out = listed - pairs.size();

    std::vector<float> positions, bounds, errors, boxes, times;
    std::vector<std::int16_t> turns;
    std::vector<std::uint32_t> a, b;
    std::vector<std::uint8_t> small; // verdicts, stages, kinds; levels of regions, and which regions are rejected
    for (const std::uint32_t body : moving_) {
        append(positions, scene_.poses[body].translation() - origin_);
        append(turns, Eigen::Quaterniond(scene_.poses[body].linear()).normalized());
    }
    for (const PairResult& pair : pairs) {
        a.push_back(index(pair.a)), b.push_back(index(pair.b));
        bounds.push_back(pair.verdict == Verdict::separate ? below(pair.bound) : above(pair.bound));
        errors.push_back(above(pipeline_.world().pairs().max_error(pair.a, pair.b)));
    }
    const bool swept = std::ranges::any_of(sweeps, [](const PairSweep* sweep) { return sweep != nullptr; });
    for (const PairSweep* const sweep : sweeps) {
        if (!swept) break;
        times.push_back(sweep ? below(sweep->clear_until) : not_known);
        times.push_back(sweep ? above(sweep->contact_by) : not_known);
    }
    for (const DelimitedRegion& region : regions)
        append(boxes, region.box.min - origin_), append(boxes, region.box.max - origin_);
    for (const PairResult& pair : pairs) small.push_back(std::uint8_t(pair.verdict));
    for (const PairResult& pair : pairs) small.push_back(std::uint8_t(pair.stage));
    for (const PairResult& pair : pairs) small.push_back(std::uint8_t(pair.kind));
    for (const DelimitedRegion& region : regions) small.push_back(std::uint8_t(region.level));
    for (const DelimitedRegion& region : regions) small.push_back(region.rejected);
    if (left_out) {
        const std::vector<std::uint8_t> worst = worst_of_bodies(view.pairs);
        small.insert(small.end(), worst.begin(), worst.end());
    }

    const DeformingModels::Columns deformed = deforming_.columns();
    PageFrame frame;
    frame.block.add(deformed.boxes);
    frame.block.add(positions), frame.block.add(a), frame.block.add(b), frame.block.add(bounds);
    frame.block.add(errors), frame.block.add(places.where), frame.block.add(places.nearest);
    frame.block.add(places.apart), frame.block.add(times), frame.block.add(places.curve),
        frame.block.add(places.of_curve);
    frame.block.add(boxes), frame.block.add(turns), frame.block.add(deformed.vertices), frame.block.add(small);
    frame.header = {{"frame", view.frame},
                    {"ms", number(view.ms)},
                    {"hash", fmt::format("{:016x}", view.hash)},
                    {"pairs", pairs.size()},
                    {"left_out", left_out},
                    {"swept", swept},
                    {"curve", places.of_curve.size()},
                    {"regions", regions.size()},
                    {"regions_left_out", all_regions - regions.size()},
                    {"verdicts", verdicts},
                    {"stages", stages_json(view.stages)},
                    {"levels", levels_json(view.delimitation)}};
    return frame;
}

} // namespace oncollide::tools

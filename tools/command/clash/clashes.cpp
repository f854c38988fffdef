#include "clash/clashes.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include <oncollide/base/threads/parallel.hpp>

#include "clash/duplicates.hpp"
#include "clash/matrix.hpp"
#include "clash/pair_limit.hpp"
#include "clash/parts/part_ids.hpp"
#include "clash/tolerance.hpp"
#include "self/self_places.hpp"

namespace oncollide::tools {
namespace {

ClashKind kind_of(ContactKind kind)
{
    return kind == ContactKind::enclosed   ? ClashKind::enclosed
           : kind == ContactKind::crossing ? ClashKind::crossing
           : kind == ContactKind::touching ? ClashKind::touching
                                           : ClashKind::near;
}

/// Returns the models, by mesh.
std::vector<ModelId> add_parts(const PartList& list, Clashes& found)
{
    World& world = *found.world;
    std::vector<ModelId> models(list.meshes.size());
    for (std::size_t i = 0; i < list.meshes.size(); ++i)
        if (list.meshes[i]) models[i] = world.models().add(list.meshes[i]);
    std::vector<BodySpec> bodies;
    for (std::size_t i = 0; i < list.parts.size(); ++i) {
        const Part& part = list.parts[i];
        const auto [layer, mask] = layers_of(list, part);
        bodies.push_back({.model = models[part.mesh],
                          .pose = part.pose,
                          .layer = layer,
                          .mask = mask,
                          .group = part.group,
                          .user = i});
    }
    found.bodies.resize(bodies.size());
    world.bodies().add(bodies, found.bodies);

    std::vector<std::uint8_t> closed(list.meshes.size(), 0);
    parallel_chunks(closed.size(), 1, thread_count(world.settings()), [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i)
            closed[i] =
                !list.mending.empty() ? list.mending[i].closed : list.meshes[i] && world.models().closed(models[i]);
    });
    for (std::uint32_t part = 0; part < list.parts.size(); ++part) {
        found.closed.push_back(closed[list.parts[part].mesh]);
        if (!found.closed.back()) found.open.push_back(part);
    }
    return models;
}

/// The common part of duplicates is the whole of each, so there is nothing to search for.
void measure_duplicate(const PartList& list, Clash& clash)
{
    const Part& part = list.parts[clash.a];
    const auto& mesh = std::get<Mesh>(list.meshes[part.mesh]->data);
    Aabb box;
    for (const Triangle& triangle : mesh.triangles)
        for (const std::uint32_t v : triangle) box.add(part.pose * mesh.vertices[v]);
    clash.reach.contact = clash.reach.overlap = box;
    clash.reach.thickness = (box.max - box.min).minCoeff();
    clash.where = box.centre();
}

/// The overlap of each pair of closed parts.
void measure_balls(const PartList& list, const Clashes& found, std::vector<Clash>& clashes)
{
    const int threads = thread_count(found.world->settings());
    const auto mesh = [&](std::uint32_t part) -> const Mesh& {
        return std::get<Mesh>(list.meshes[list.parts[part].mesh]->data);
    };
    parallel_chunks(clashes.size(), 1, threads, [&](std::size_t begin, std::size_t end, int) {
        for (Clash& clash : std::span(clashes).subspan(begin, end - begin)) {
            if (!clash.overlaps() || !found.closed[clash.a] || !found.closed[clash.b]) continue;
            clash.ball = common_ball(mesh(clash.a), list.parts[clash.a].pose, mesh(clash.b), list.parts[clash.b].pose,
                                     {.enough = (clash.limits.tolerance + clash.deflection) / 2,
                                      .relative = 0.05,
                                      .most_boxes_for_volume = 300});
            clash.has_ball = true;
        }
    });
}

void find_duplicates(const PartList& list, const World& world, double tolerance, std::vector<Clash>& clashes)
{
    parallel_chunks(clashes.size(), 1, thread_count(world.settings()), [&](std::size_t begin, std::size_t end, int) {
        for (Clash& clash : std::span(clashes).subspan(begin, end - begin)) {
            if (!same_geometry(list, list.parts[clash.a], list.parts[clash.b], tolerance)) continue;
            clash.kind = ClashKind::duplicate;
            measure_duplicate(list, clash);
        }
    });
}

void measure(const World& world, const Clashes& found, std::vector<Clash>& clashes)
{
    std::vector<PairOfBodies> pairs;
    std::vector<std::size_t> near, of_pairs;
    for (std::size_t i = 0; i < clashes.size(); ++i)
        if (clashes[i].kind == ClashKind::near)
            near.push_back(i);
        else if (clashes[i].kind != ClashKind::duplicate)
            pairs.push_back(found.pair(clashes[i])), of_pairs.push_back(i);
    std::vector<Penetration> reaches(pairs.size());
    world.pairs().penetration(pairs, reaches);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
        clashes[of_pairs[k]].reach = reaches[k];
        clashes[of_pairs[k]].where = reaches[k].overlap.centre();
    }
    parallel_chunks(near.size(), 4, thread_count(world.settings()), [&](std::size_t begin, std::size_t end, int) {
        for (const std::size_t i : std::span(near).subspan(begin, end - begin)) {
            Clash& clash = clashes[i];
            const auto [a, b] = found.pair(clash);
            const Distance d = world.pairs().distance(a, b);
            clash.lower = d.lower, clash.upper = d.upper;
            clash.nearest_a = d.point_a, clash.nearest_b = d.point_b;
            clash.where = 0.5 * (d.point_a + d.point_b);
        }
    });
}

/// Parts that overlap, or are apart, by no more than the tolerance touch. Not duplicates, however thin they are.
/// Overlaps and gaps below the deflections are within.
void apply_tolerance(const Clashes& found, bool touching, Clash& clash)
{
    const double tolerance = clash.limits.tolerance, deviating = tolerance + clash.deflection;
    const bool of_open = !clash.has_ball && clash.kind == ClashKind::crossing;
    bool within = false;
    if (clash.kind == ClashKind::near) {
        // Parts beyond the clearance are in the list because of the tolerance or the deflections.
        const bool beyond = clash.lower > clash.limits.clearance;
        clash.tolerated = clash.upper <= tolerance || (beyond && clash.lower <= tolerance);
        within = beyond;
    } else {
        clash.tolerated = clash.has_ball ? clash.ball_upper() <= tolerance
                                         : of_open && open_within_tolerance(found, clash, tolerance);
        within = clash.deflection > 0 && // unless a larger ball is certain
                 (clash.has_ball ? clash.ball_lower() <= deviating
                                 : of_open && open_within_tolerance(found, clash, deviating));
    }
    if (clash.kind == ClashKind::duplicate) clash.tolerated = within = false;
    clash.overlapped = clash.tolerated && clash.overlaps();
    if (clash.tolerated)
        clash.kind = ClashKind::touching;
    else if (within)
        clash.kind = ClashKind::within;
    const bool touches = clash.kind == ClashKind::touching || clash.kind == ClashKind::within;
    if (touches && !touching) clash.status = ClashStatus::contact;
}

/// True for parts that are in the list because of the limits or deflections of other parts.
bool is_apart(const Clash& clash)
{
    return clash.kind == ClashKind::near &&
           clash.lower > std::max(clash.limits.clearance, clash.limits.tolerance) + clash.deflection;
}

void find_self(const PartList& list, const std::vector<ModelId>& models, Clashes& found)
{
    std::vector<std::optional<PartMeetsItself>> by_mesh(list.meshes.size());
    for (std::size_t i = 0; i < list.meshes.size(); ++i) {
        if (!list.meshes[i]) continue;
        const auto pairs = found.world->models().self_contacts(models[i]);
        if (pairs.empty()) continue;
        const SelfPlace worst = std::move(places_of(std::get<Mesh>(list.meshes[i]->data), pairs)[0]);
        by_mesh[i] = {0, pairs.size(), {worst.pairs[0].a, worst.pairs[0].b}, worst.box.centre()};
    }
    for (std::uint32_t i = 0; i < list.parts.size(); ++i)
        if (const auto& meets = by_mesh[list.parts[i].mesh]) {
            found.self.push_back(*meets);
            found.self.back().part = i, found.self.back().where = list.parts[i].pose * meets->where;
        }
}

} // namespace

std::string_view name_of(ClashKind kind)
{
    constexpr std::string_view names[] = {"duplicate", "enclosed", "crossing", "within", "touching", "near"};
    return names[static_cast<int>(kind)];
}

std::string_view name_of(ClashStatus status)
{
    constexpr std::string_view names[] = {"new", "active", "ignored", "contact"};
    return names[static_cast<int>(status)];
}

double Clash::severity() const
{
    if (has_ball) return ball_lower();
    return reach.contact.empty() ? 0 : -1 / std::max(reach.contact.diagonal(), 1e-300);
}

bool more_severe(const Clash& a, const Clash& b)
{
    const auto order = [](const Clash& c) {
        const ClashKind rank = c.overlaps() ? ClashKind::crossing : c.kind;
        return std::tuple(rank, c.apart() ? c.lower : -c.severity(), c.a, c.b);
    };
    return order(a) < order(b);
}

PartLayers layers_of(const PartList& list, const Part& part)
{
    const std::uint32_t sets = part.sets; // bit 1: set A, bit 2: set B
    return list.has_sets ? PartLayers{sets ? sets : 4u, (sets & 1) << 1 | (sets & 2) >> 1} : PartLayers{};
}

void mend(PartList& parts, ClashSettings& settings)
{
    const double precision = precision_of(parts);
    settings.from_files = settings.tolerance == tolerance_of_files;
    if (settings.from_files) settings.tolerance = precision;
    if (settings.tolerance > 0)
        mend_parts(parts, std::min(precision, settings.tolerance) / 8, threads_of(settings.threads));
}

Settings settings_of(const ClashSettings& settings, double deflection)
{
    return {.clearance =
                std::max({settings.clearance, settings.tolerance, settings.matrix ? settings.matrix->largest() : 0}) +
                deflection,
            .exact = ExactLevel::predicates,
            .contact_kinds = true,
            .mode = Mode::solid,
            .open_as_surface = true,
            .threads = settings.threads};
}

Clashes find_clashes(const PartList& parts, const ClashSettings& settings)
{
    check_number_of_pairs(parts, settings);
    Clashes found;
    found.world = std::make_unique<World>(settings_of(settings, 2 * parts.deflection()));
    World& world = *found.world;
    const std::vector<ModelId> models = add_parts(parts, found);
    if (settings.self) find_self(parts, models, found);
    const FrameView frame = world.step();
    found.pairs = frame.pairs.size();
    for (const PairResult& pair : frame.pairs) {
        if (pair.verdict == Verdict::separate) continue;
        const auto [a, b] = std::minmax({static_cast<std::uint32_t>(world.bodies().user(pair.a)),
                                         static_cast<std::uint32_t>(world.bodies().user(pair.b))});
        const Part &part_a = parts.parts[a], &part_b = parts.parts[b];
        PairLimits limits{settings.clearance, settings.tolerance};
        if (settings.matrix) limits = settings.matrix->limits(part_a, part_b, limits);
        if (limits.skip) {
            ++found.skipped;
            continue;
        }
        found.list.push_back({.a = a,
                              .b = b,
                              .kind = kind_of(pair.kind),
                              .limits = limits,
                              .id = clash_id(part_a, part_b),
                              .deflection = 2 * std::max(part_a.details.deflection, part_b.details.deflection)});
    }
    find_duplicates(parts, world, settings.tolerance, found.list);
    measure(world, found, found.list);
    std::erase_if(found.list, is_apart);
    measure_balls(parts, found, found.list);
    for (Clash& clash : found.list) apply_tolerance(found, settings.touching, clash);
    std::ranges::sort(found.list, more_severe);
    return found;
}

} // namespace oncollide::tools

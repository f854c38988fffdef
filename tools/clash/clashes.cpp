#include "clash/clashes.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include <oncollide/base/threads/parallel.hpp>

#include "clash/tolerance.hpp"

namespace oncollide::tools {
namespace {

int rank(ContactKind kind)
{
    return kind == ContactKind::enclosed   ? 0
           : kind == ContactKind::crossing ? 1
           : kind == ContactKind::touching ? 2
                                           : 3;
}

void add_parts(const PartList& list, Clashes& found)
{
    World& world = *found.world;
    std::vector<ModelId> models(list.meshes.size());
    for (std::size_t i = 0; i < list.meshes.size(); ++i)
        if (list.meshes[i]) models[i] = world.add(list.meshes[i]);
    std::vector<BodySpec> bodies;
    for (std::size_t i = 0; i < list.parts.size(); ++i) {
        const Part& part = list.parts[i];
        bodies.push_back({.model = models[part.mesh], .pose = part.pose, .group = part.group, .user = i});
    }
    found.bodies.resize(bodies.size());
    world.add_bodies(bodies, found.bodies);

    std::vector<std::uint8_t> closed(list.meshes.size(), 0);
    parallel_chunks(closed.size(), 1, thread_count(world.settings()), [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) closed[i] = list.meshes[i] && world.closed(models[i]);
    });
    for (const Part& part : list.parts)
        if (!closed[part.mesh]) found.open.push_back(part.name);
}

void measure(const World& world, const Clashes& found, std::vector<Clash>& clashes)
{
    std::vector<PairOfBodies> pairs;
    std::vector<std::size_t> near, of_pairs;
    for (std::size_t i = 0; i < clashes.size(); ++i)
        if (clashes[i].kind == ContactKind::near)
            near.push_back(i);
        else
            pairs.push_back(found.pair(clashes[i])), of_pairs.push_back(i);
    std::vector<Penetration> reaches(pairs.size());
    world.penetration(pairs, reaches);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
        clashes[of_pairs[k]].reach = reaches[k];
        clashes[of_pairs[k]].where = reaches[k].overlap.centre();
    }
    parallel_chunks(near.size(), 4, thread_count(world.settings()), [&](std::size_t begin, std::size_t end, int) {
        for (const std::size_t i : std::span(near).subspan(begin, end - begin)) {
            Clash& clash = clashes[i];
            const auto [a, b] = found.pair(clash);
            const Distance d = world.distance(a, b);
            clash.lower = d.lower, clash.upper = d.upper;
            clash.nearest_a = d.point_a, clash.nearest_b = d.point_b;
            clash.where = 0.5 * (d.point_a + d.point_b);
        }
    });
}

} // namespace

std::string_view name_of(ClashStatus status)
{
    constexpr std::string_view names[] = {"new", "same", "ignored", "contact"};
    return names[static_cast<int>(status)];
}

double Clash::severity() const
{
    return std::isfinite(reach.thickness) ? reach.thickness
                                          : std::max(reach.depth, reach.contact.empty() ? 0 : reach.contact.diagonal());
}

bool more_severe(const Clash& a, const Clash& b)
{
    const auto order = [](const Clash& c) {
        return std::tuple(rank(c.kind), c.kind == ContactKind::near ? c.lower : -c.severity(), c.a, c.b);
    };
    return order(a) < order(b);
}

Clashes find_clashes(const PartList& parts, const ClashSettings& settings)
{
    Clashes found;
    found.world = std::make_unique<World>(Settings{.clearance = settings.clearance,
                                                   .exact = ExactLevel::predicates,
                                                   .contact_kinds = true,
                                                   .mode = Mode::solid,
                                                   .open_as_surface = true,
                                                   .threads = settings.threads});
    World& world = *found.world;
    add_parts(parts, found);
    const FrameView frame = world.step();
    found.pairs = frame.pairs.size();
    for (const PairResult& pair : frame.pairs) {
        if (pair.verdict == Verdict::separate) continue;
        const std::uint64_t a = world.user(pair.a), b = world.user(pair.b);
        found.list.push_back({.a = static_cast<std::uint32_t>(std::min(a, b)),
                              .b = static_cast<std::uint32_t>(std::max(a, b)),
                              .kind = pair.kind});
    }
    measure(world, found, found.list);
    for (Clash& clash : found.list) {
        if (clash.kind == ContactKind::crossing && is_within_tolerance(found, clash, settings.tolerance))
            clash.kind = ContactKind::touching, clash.tolerated = true;
        if (clash.kind == ContactKind::touching && !settings.touching) clash.status = ClashStatus::contact;
    }
    std::ranges::sort(found.list, more_severe);
    return found;
}

} // namespace oncollide::tools

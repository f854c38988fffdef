// The pairs of parts that are tested, and their order.
#include <oncollide/robots/robot_impl.hpp>

#include <algorithm>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/robots/description_fault.hpp>

namespace oncollide {

void Robot::Impl::find_pairs()
{
    pairs.clear(), group_pairs.clear();
    const auto tested = [&](const Part& a, const Part& b) {
        if (a.link == b.link || std::ranges::count(a.touching, b.link) || std::ranges::count(b.touching, a.link))
            return false;
        const std::pair<std::uint32_t, std::uint32_t> links = std::minmax(a.link, b.link);
        return !std::ranges::binary_search(description.excluded, links) &&
               !std::ranges::binary_search(allowed_links, links);
    };
    for (std::uint32_t b = 0; b < groups.size(); ++b)
        for (std::uint32_t a = 0; a < b; ++a) {
            const auto first = static_cast<std::uint32_t>(pairs.size());
            for (std::uint32_t i = groups[a].first; i < groups[a].end; ++i)
                for (std::uint32_t k = groups[b].first; k < groups[b].end; ++k)
                    if (tested(parts[i], parts[k])) pairs.push_back({i, k, parts[i].link});
            if (pairs.size() > first) group_pairs.push_back({a, b, first, static_cast<std::uint32_t>(pairs.size())});
        }
    choose_views();
    sort_pairs();
}

void Robot::Impl::choose_numbers(std::uint64_t k, std::vector<double>& numbers, std::vector<double>& spans) const
{
    constexpr std::uint64_t seed = 1;
    numbers.resize(tree.width()), spans.resize(tree.width());
    for (std::size_t j = 0; j < description.joints.size(); ++j)
        for (int n = 0; n < numbers_of(description.joints[j]); ++n) {
            const RobotJoint& joint = description.joints[j];
            const auto i = static_cast<std::size_t>(tree.first_number(static_cast<std::uint32_t>(j)) + n);
            const double low = std::max(joint.lower, -4.0), high = std::min(joint.upper, 4.0);
            const bool floats = joint.kind == JointKind::floating;
            numbers[i] = floats ? n == 6 : low + (high - low) * u01(seed, k, i);
            spans[i] = floats ? 0 : high - low;
        }
}

/// Chooses the link from which each pair is seen on edges: the one from which bounds on the motions of both sides are
/// least. For robots of many links, that would take long: most of their pairs get the link in the middle.
void Robot::Impl::choose_views()
{
    constexpr std::uint64_t samples = 4;
    constexpr std::size_t most_tests = 40'000; // steps over joints
    std::vector<double> numbers, spans, from, to;
    std::vector<Eigen::Isometry3d> poses(description.links.size(), Eigen::Isometry3d::Identity());
    struct Views {
        PartPair* pair;
        std::vector<std::uint32_t> links;
        std::vector<double> moved;
    };
    std::vector<Views> all;
    std::vector<Kinematics::Way> ways;
    std::size_t left = most_tests;
    std::uint32_t ways_of = static_cast<std::uint32_t>(description.links.size());
    for (PartPair& pair : pairs) {
        const std::uint32_t a = parts[pair.a].link, b = parts[pair.b].link;
        if (b != ways_of) tree.ways_from(ways_of = b, ways);
        pair.seen_from = ways[a].middle;
        const std::size_t tests = std::size_t{ways[a].links} * ways[a].links;
        if (tests > left) continue;
        left -= tests;
        all.push_back({&pair, tree.links_between(a, b), {}});
        all.back().moved.resize(all.back().links.size());
    }
    for (std::uint64_t k = 0; k < samples; ++k) {
        choose_numbers(k, numbers, spans);
        from = to = numbers;
        for (std::size_t i = 0; i < numbers.size(); ++i) from[i] -= 0.01 * spans[i], to[i] += 0.01 * spans[i];
        tree.link_poses(numbers.data(), base, poses.data());
        for (Views& views : all)
            for (std::size_t v = 0; v < views.links.size(); ++v)
                for (const std::uint32_t part : {views.pair->a, views.pair->b})
                    views.moved[v] += tree.travel(from.data(), to.data(), 0.5, poses.data(), parts[part].cover.whole,
                                                  parts[part].link, views.links[v])
                                          .moved;
    }
    for (const Views& views : all)
        views.pair->seen_from =
            views.links[static_cast<std::size_t>(std::ranges::min_element(views.moved) - views.moved.begin())];
}

/// Random configurations show which pairs come close. Any order gives the same verdicts.
void Robot::Impl::sort_pairs()
{
    constexpr std::uint64_t most_samples = 100, most_tests = 1'000'000;
    const std::uint64_t samples = std::min(most_samples, most_tests / std::max<std::uint64_t>(group_pairs.size(), 1));
    std::vector<double> numbers, spans;
    std::vector<Eigen::Isometry3d> poses(description.links.size(), Eigen::Isometry3d::Identity());
    SphereCull cull(*this, 0);
    for (std::uint64_t k = 0; k < samples; ++k) {
        choose_numbers(k, numbers, spans);
        tree.link_poses(numbers.data(), base, poses.data());
        cull.place(poses.data());
        for (GroupPair& pair : group_pairs) {
            bool near = false;
            if (cull.groups_near(pair.a, pair.b))
                for (std::uint32_t p = pair.first; p < pair.end && !near; ++p) near = cull.near(pairs[p].a, pairs[p].b);
            pair.near += near;
        }
    }
    std::ranges::stable_sort(group_pairs, std::greater{}, &GroupPair::near);
}

} // namespace oncollide

#include "study/narrow_poses.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/scenes/motion.hpp>

#include "cli/options.hpp"
#include "cli/progress.hpp"
#include "common/text.hpp"
#include "fcl/fcl_pair.hpp"

namespace oncollide::tools {
namespace {

/// A sequence of uniform random numbers.
class Dice {
public:
    Dice(std::uint64_t seed, std::uint64_t index) : seed_(seed), index_(index) {}

    double next() { return u01(seed_, index_, k_++); }
    std::size_t below(std::size_t count) { return std::min(std::size_t(next() * double(count)), count - 1); }

    Eigen::Vector3d direction()
    {
        const double z = 2 * next() - 1, angle = 2 * std::numbers::pi * next(), ring = std::sqrt(1 - z * z);
        return {ring * std::cos(angle), ring * std::sin(angle), z};
    }

    /// Uniform over all rotations: Shoemake, "Uniform random rotations", Graphics Gems III, 1992.
    Eigen::Quaterniond rotation()
    {
        const double u = next(), p = 2 * std::numbers::pi * next(), q = 2 * std::numbers::pi * next();
        const double s = std::sqrt(1 - u), t = std::sqrt(u);
        return Eigen::Quaterniond(t * std::cos(q), s * std::sin(p), s * std::cos(p), t * std::sin(q)).normalized();
    }

private:
    std::uint64_t seed_, index_, k_ = 0;
};

/// Rounds up to one digit.
double rounded_up(double value)
{
    if (!(value > 0)) return 0;
    const double unit = std::pow(10, std::floor(std::log10(value)));
    return std::ceil(value / unit) * unit;
}

Eigen::Vector3d centroid(const Mesh& mesh, std::size_t triangle)
{
    const Triangle& t = mesh.triangles[triangle];
    return (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3;
}

/// An orientation of b and a line along which it moves; at position 0 two triangles cross.
struct Approach {
    Eigen::Isometry3d start;
    Eigen::Vector3d direction;

    Eigen::Isometry3d at(double place) const
    {
        Eigen::Isometry3d pose = start;
        pose.translation() += place * direction;
        return pose;
    }
};

class PoseFinder {
public:
    PoseFinder(const Mesh& a, const Mesh& b, std::uint64_t seed)
        : a_(a), b_(b), seed_(seed), models_(a, b, FclNodes::obbrss), diagonal_(a.bounds.diagonal()),
          reach_(diagonal_ + b.bounds.diagonal())
    {
    }

    /// The approach of pose `i`.
    Approach approach(std::size_t i) const
    {
        constexpr std::uint64_t most_attempts = 50;
        for (std::uint64_t attempt = 0; attempt < most_attempts; ++attempt) {
            Dice dice(seed_ + attempt, i);
            Approach approach{Eigen::Isometry3d::Identity(), {}};
            approach.start.linear() = dice.rotation().toRotationMatrix();
            approach.direction = dice.direction();
            const Eigen::Vector3d of_a = centroid(a_, dice.below(a_.triangles.size())),
                                  of_b = centroid(b_, dice.below(b_.triangles.size()));
            approach.start.translation() = of_a - approach.start.linear() * of_b;
            if (models_.contacts(approach.start) && !models_.contacts(approach.at(1.01 * reach_))) return approach;
        }
        throw Error(ErrorKind::bad_data,
                    fmt::format("the meshes do not collide in any of {} poses in which two of their triangles cross",
                                most_attempts));
    }

    /// The position at which b touches a, to 1e-9 of the diagonal: in contact just before, apart just after.
    double touching(const Approach& approach) const
    {
        double in = 0, out = 1.01 * reach_;
        while (out - in > 1e-9 * diagonal_) {
            const double middle = 0.5 * (in + out);
            (models_.contacts(approach.at(middle)) ? in : out) = middle;
        }
        return out;
    }

    /// The position with this distance, to 1e-7 of the diagonal, at or after `low`, where the distance is not larger.
    /// Uses the Illinois method, a false position method that always converges.
    double apart(const Approach& approach, double distance, double low) const
    {
        double high = reach_ + distance; // at position 0 the AABBs overlap
        double low_error = error(approach, distance, low), high_error = error(approach, distance, high);
        if (low_error >= 0) return low;
        for (int step = 0, last = 0; step < 60; ++step) {
            const double place = low_error < high_error
                                     ? (low * high_error - high * low_error) / (high_error - low_error)
                                     : 0.5 * (low + high);
            const double here = error(approach, distance, place);
            if (std::abs(here) <= 1e-7 * diagonal_) return place;
            const int side = here < 0 ? -1 : 1;
            (side < 0 ? low : high) = place, (side < 0 ? low_error : high_error) = here;
            if (side == last) (side < 0 ? high_error : low_error) *= 0.5;
            last = side;
        }
        return high;
    }

    double diagonal() const { return diagonal_; }

private:
    double error(const Approach& approach, double distance, double place) const
    {
        return models_.distance(approach.at(place)) - distance;
    }

    const Mesh &a_, &b_;
    std::uint64_t seed_;
    FclPair models_;
    double diagonal_, reach_; ///< diagonal of a's AABB; beyond reach_ from position 0 nothing touches
};

} // namespace

std::vector<double> parse_distances(const std::string& list)
{
    std::vector<double> percents;
    for (const std::string& part : split(list)) {
        double value = 0;
        const char* const end = part.data() + part.size();
        const auto [rest, error] = std::from_chars(part.data(), end, value);
        if (error != std::errc{} || rest != end || !(value >= -50 && value <= 1000))
            usage(fmt::format("--distances {}: expected percentages of the first mesh's diagonal from -50 to 1000, "
                              "such as 0,0.1,1,5",
                              part));
        percents.push_back(value == 0 ? 0 : value); // no -0
    }
    std::sort(percents.begin(), percents.end());
    percents.erase(std::unique(percents.begin(), percents.end()), percents.end());
    return percents;
}

NarrowWorkload make_workload(const Mesh& a, const Mesh& b, std::span<const double> percents, std::size_t count,
                             std::uint64_t seed)
{
    const PoseFinder finder(a, b, seed);
    NarrowWorkload workload;
    for (double percent : percents) workload.groups.push_back(fmt::format("{:g} %", percent));
    workload.poses.resize(percents.size() * count);
    Progress progress("finding poses", count);
    for (std::size_t i = 0; i < count; ++i, progress.step()) {
        const Approach approach = finder.approach(i);
        const double touching = finder.touching(approach);
        double place = touching, reached = 0; // last position of b, and its distance there
        for (std::size_t group = 0; group < percents.size(); ++group) {
            NarrowPose& pose = workload.poses[group * count + i];
            const double distance = 0.01 * percents[group] * finder.diagonal();
            pose.group = group;
            if (percents[group] <= 0) {
                const double nudge = percents[group] == 0 ? (i % 2 ? -1e-6 : 1e-6) * finder.diagonal() : 0;
                pose.known.b = approach.at(touching + distance + nudge);
                continue;
            }
            // The distance grows no faster than b moves.
            place = finder.apart(approach, distance, place + distance - reached), reached = distance;
            pose.known.b = approach.at(place);
            pose.distance = distance;
        }
    }
    return workload;
}

NarrowWorkload workload_of(std::vector<KnownPose> poses)
{
    std::map<int, double> farthest; // by kind
    for (const KnownPose& pose : poses) farthest[pose.kind] = std::max(farthest[pose.kind], std::abs(pose.offset));
    NarrowWorkload workload;
    for (const auto& [kind, most] : farthest) {
        for (std::size_t i = 0; i < poses.size(); ++i)
            if (poses[i].kind == kind) workload.poses.push_back({poses[i], workload.groups.size(), i});
        workload.groups.push_back(fmt::format("within {:g} %", rounded_up(100 * most)));
    }
    return workload;
}

} // namespace oncollide::tools

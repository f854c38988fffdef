// oncollide bench poses: one pair of meshes in many poses; traversal of two sphere-trees against FCL's trees of OBBs.
#include "bench/bench.hpp"
#include "bench/narrow/pose_file.hpp"
#include "bench/narrow/tree_pair.hpp"
#include "peers/fcl_pair.hpp"

#include <algorithm>
#include <chrono>
#include <functional>

#include <oncollide/base/error.hpp>
#include <oncollide/base/output_file.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide::tools {
namespace {

template <class Work>
double milliseconds(Work work)
{
    const auto from = Clock::now();
    work();
    return milliseconds_since(from);
}

/// A method, and its times.
struct PoseContender {
    std::string name;
    std::function<bool(const KnownPose&)> answer; ///< true: not certified separate
    std::vector<double> us = {};                  ///< by pose, least of the repeats
    std::uint64_t false_positives = 0, missed = 0;
};

Settings at_depth(int depth)
{
    Settings settings;
    settings.depth = depth;
    return settings;
}

class PosesBench {
public:
    explicit PosesBench(const PosesOptions& options) : options_(options)
    {
        const PoseSet set = pose_set(data_folder(options.data));
        poses_ = read_poses(set.poses);
        read_expected(set.expected, poses_);
        if (options.poses > 0 && std::size_t(options.poses) < poses_.size()) poses_.resize(std::size_t(options.poses));
        for (const auto& path : {set.mesh_a, set.mesh_b}) {
            const std::string name = path.stem().string();
            scene_.add_body({.name = name, .geometry = scene_.add(name, load_mesh(path))});
        }
        const Mesh &bunny = std::get<Mesh>(scene_.geometries[0].data), &cow = std::get<Mesh>(scene_.geometries[1].data);
        obb_ms_ = milliseconds([&] { obb_ = std::make_unique<FclPair>(bunny, cow, FclNodes::obb); });
        rss_ms_ = milliseconds([&] { rss_ = std::make_unique<FclPair>(bunny, cow, FclNodes::obbrss); });
        for (int depth : parse_depths("--depths", options.depths))
            trees_.push_back(std::make_unique<TreePair>(scene_, at_depth(depth)));
        add_contenders();
    }

    int run()
    {
        say("poses      {} of a bunny (5,110 triangles) and a cow (5,144), {} colliding; least of {} runs of each "
            "query\n"
            "settings   trees already grown for these poses, no coherence, one thread\n{}\n",
            grouped(poses_.size()),
            std::count_if(poses_.begin(), poses_.end(), [](const KnownPose& p) { return *p.colliding; }),
            options_.repeats, describe_program(make_cpu_backend()->name()));
        for (PoseContender& who : contenders_) who.us.assign(poses_.size(), 1e300);
        grow();
        for (std::size_t i = 0; i < poses_.size(); ++i) measure(i);
        print_table();
        check_fcl();
        if (!options_.csv.empty()) write_csv();
        std::uint64_t missed = 0;
        for (const PoseContender& who : contenders_) missed += who.name.starts_with("FCL") ? 0 : who.missed;
        return missed ? int(ErrorKind::internal) : 0;
    }

private:
    void add_contenders()
    {
        contenders_.push_back({"FCL OBB", [this](const KnownPose& p) { return obb_->collides(p.b); }});
        contenders_.push_back({"FCL OBBRSS", [this](const KnownPose& p) { return rss_->collides(p.b); }});
        for (const auto& tree : trees_)
            contenders_.push_back({fmt::format("depth {}", tree->depth), [t = tree.get()](const KnownPose& p) {
                                       return t->walk(p.b).verdict != Verdict::separate;
                                   }});
        for (const auto& tree : trees_)
            contenders_.push_back(
                {fmt::format("depth {} + fcl", tree->depth), [this, t = tree.get()](const KnownPose& p) {
                     return t->walk(p.b).verdict != Verdict::separate && obb_->collides(p.b);
                 }});
    }

    /// Runs every pose once, so that all trees are grown.
    void grow()
    {
        for (const auto& tree : trees_) {
            const auto from = Clock::now();
            for (const KnownPose& pose : poses_) tree->walk(pose.b);
            growth_.push_back(milliseconds_since(from));
            tree->reset_counters();
            for (const KnownPose& pose : poses_) tree->walk(pose.b);
            cell_pairs_.push_back(double(tree->cell_pairs()) / double(poses_.size()));
        }
    }

    void measure(std::size_t i)
    {
        const KnownPose& pose = poses_[i];
        for (std::size_t k = 0; k < contenders_.size(); ++k) {
            PoseContender& who = contenders_[(i + k) % contenders_.size()]; // in alternation
            bool answer = false;
            for (int repeat = 0; repeat < options_.repeats; ++repeat) {
                const auto from = Clock::now();
                answer = who.answer(pose);
                who.us[i] = std::min(who.us[i], std::chrono::duration<double, std::micro>(Clock::now() - from).count());
            }
            who.false_positives += answer && !*pose.colliding;
            who.missed += !answer && *pose.colliding;
        }
    }

    void print_table() const
    {
        const auto part = [&](const PoseContender& who, bool colliding) {
            std::vector<double> us;
            for (std::size_t i = 0; i < poses_.size(); ++i)
                if (poses_[i].colliding == colliding) us.push_back(who.us[i]);
            return us;
        };
        const double fcl_median = median(contenders_[0].us), fcl_mean = mean(contenders_[0].us);
        say("{:<16}{:>10}{:>10}{:>12}{:>12}{:>12}{:>12}{:>10}{:>10}\n", "microseconds", "median", "mean", "mean, hits",
            "mean, misses", "OBB/median", "OBB/mean", "false", "missed");
        for (const PoseContender& who : contenders_)
            say("{:<16}{:>10.2f}{:>10.2f}{:>12.2f}{:>12.2f}{:>12.2f}{:>12.2f}{:>10}{:>10}\n", who.name, median(who.us),
                mean(who.us), mean(part(who, true)), mean(part(who, false)), fcl_median / median(who.us),
                fcl_mean / mean(who.us), who.false_positives, who.missed);
        say("\nFCL builds OBB in {:.2f} ms, OBBRSS in {:.2f} ms\n\n", obb_ms_, rss_ms_);
        say("{:<8}{:>14}{:>16}{:>18}{:>14}{:>20}{:>12}\n", "trees", "bound", "% of diagonal", "cell pairs/query",
            "cells", "growing, ms total", "MB");
        const double diagonal = bounds_of(scene_.geometries[0]).diagonal();
        for (std::size_t k = 0; k < trees_.size(); ++k) {
            double bound = 0;
            for (const KnownPose& pose : poses_)
                if (const Finding walk = trees_[k]->walk(pose.b); walk.verdict == Verdict::within)
                    bound = std::max(bound, walk.bound);
            const ModelStore& models = trees_[k]->models();
            say("{:<8}{:>14.6f}{:>16.2f}{:>18.1f}{:>14}{:>20.2f}{:>12.3f}\n", fmt::format("depth {}", trees_[k]->depth),
                bound, 100 * bound / diagonal, cell_pairs_[k], grouped(models.nodes()), growth_[k],
                double(models.bytes()) / 1e6);
        }
    }

    /// FCL counts all intersecting pairs of triangles; the expected numbers are exact.
    void check_fcl() const
    {
        std::uint64_t sum = 0, expected = 0, differing = 0, wrong = 0;
        for (const KnownPose& pose : poses_) {
            const std::size_t pairs = obb_->contacts(pose.b, 10'000'000);
            sum += pairs, expected += *pose.triangle_pairs;
            differing += pairs != *pose.triangle_pairs, wrong += (pairs > 0) != *pose.colliding;
        }
        say("\nexact results: {} triangle pairs expected, FCL finds {}; {} poses differ in number, {} in colliding or "
            "not\n",
            grouped(expected), grouped(sum), differing, wrong);
    }

    void write_csv() const
    {
        std::string header = "pose,colliding,triangle_pairs";
        for (const PoseContender& who : contenders_) header += fmt::format(",{} us", who.name);
        CsvFile csv(options_.csv, header);
        for (std::size_t i = 0; i < poses_.size(); ++i) {
            csv.rows().add(i, int(*poses_[i].colliding), *poses_[i].triangle_pairs);
            for (const PoseContender& who : contenders_) csv.rows().add(Fixed{who.us[i], 3});
            csv.rows().end_row();
        }
        csv.commit();
    }

    PosesOptions options_;
    std::vector<KnownPose> poses_;
    Scene scene_;
    std::unique_ptr<FclPair> obb_, rss_;
    double obb_ms_ = 0, rss_ms_ = 0; ///< time to build them
    std::vector<std::unique_ptr<TreePair>> trees_;
    std::vector<double> growth_, cell_pairs_; ///< by tree
    std::vector<PoseContender> contenders_;
};

} // namespace

int bench_poses(const PosesOptions& options)
{
    check_range("--repeats", options.repeats, 1, 1000);
    check_files({{"--csv", options.csv}});
    return PosesBench(options).run();
}

} // namespace oncollide::tools

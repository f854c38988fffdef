// One pair of meshes in many poses, a question at a time: the walk of two sphere-trees against FCL's trees of boxes.
#include "bench.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <sstream>

#include <fcl/fcl.h>

#include <oncollide/pipeline/forest.hpp>
#include <oncollide/scenes/error.hpp>
#include <oncollide/scenes/mesh_file.hpp>
#include <oncollide/scenes/output_file.hpp>

namespace oncollide::tools {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct Pose {
    Eigen::Isometry3d b; ///< of the second mesh; the first stays
    bool colliding = false;
    std::uint64_t triangle_pairs = 0; ///< that intersect
};

std::ifstream open(const fs::path& path)
{
    std::ifstream file(path);
    if (!file) throw Error(ErrorKind::no_input, fmt::format("{}: cannot be read", path.string()));
    return file;
}

/// Lines `kind offset R(9, row-major) T(3)`, numbers as hexadecimal floats.
std::vector<Pose> read_poses(const fs::path& path)
{
    std::ifstream file = open(path);
    std::vector<Pose> poses;
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::vector<double> numbers;
        for (std::string word; words >> word;) numbers.push_back(std::strtod(word.c_str(), nullptr));
        if (numbers.size() != 14)
            throw Error(ErrorKind::bad_data, fmt::format("{}:{}: has {} numbers, must have 14", path.string(),
                                                         poses.size() + 1, numbers.size()));
        Pose pose;
        pose.b = Eigen::Isometry3d::Identity();
        pose.b.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers.data() + 2);
        pose.b.translation() = Eigen::Map<const Eigen::Vector3d>(numbers.data() + 11);
        if (const std::string why = why_not_rigid(pose.b); !why.empty())
            throw Error(ErrorKind::bad_data, fmt::format("{}:{}: {}", path.string(), poses.size() + 1, why));
        poses.push_back(pose);
    }
    return poses;
}

/// Lines `index colliding pairs`.
void read_expected(const fs::path& path, std::vector<Pose>& poses)
{
    std::ifstream file = open(path);
    std::size_t index, count = 0;
    for (std::uint64_t colliding, pairs; file >> index >> colliding >> pairs; ++count) {
        if (index >= poses.size())
            throw Error(ErrorKind::bad_data,
                        fmt::format("{}: pose {}, but there are {}", path.string(), index, poses.size()));
        poses[index].colliding = colliding, poses[index].triangle_pairs = pairs;
    }
    if (count != poses.size())
        throw Error(ErrorKind::bad_data,
                    fmt::format("{}: {} answers for {} poses", path.string(), count, poses.size()));
}

/// FCL's answer for one pair of models.
template <class Volume>
class FclPair {
public:
    FclPair(const Mesh& a, const Mesh& b)
    {
        const auto from = Clock::now();
        for (const auto& [mesh, model] : {std::pair(&a, &a_), std::pair(&b, &b_)}) {
            std::vector<fcl::Triangle> triangles;
            for (const Triangle& t : mesh->triangles) triangles.emplace_back(t[0], t[1], t[2]);
            model->beginModel(int(triangles.size()), int(mesh->vertices.size()));
            model->addSubModel(mesh->vertices, triangles);
            model->endModel();
        }
        build_ms = std::chrono::duration<double, std::milli>(Clock::now() - from).count();
    }

    /// The number of intersecting triangle pairs, counted up to `most`.
    std::size_t collide(const Eigen::Isometry3d& b, std::size_t most = 1) const
    {
        const fcl::CollisionRequestd request(most, false);
        fcl::CollisionResultd result;
        fcl::collide(&a_, Eigen::Isometry3d::Identity(), &b_, b, request, result);
        return result.numContacts();
    }

    double build_ms = 0;

private:
    fcl::BVHModel<Volume> a_, b_;
};

/// The walk of one pair of trees of some depth, driven as the pipeline's stage drives it.
class TreePair {
public:
    /// @param scene  two bodies; the second is moved
    TreePair(Scene& scene, int d) : depth(d), scene_(scene), forest_(scene, at_depth(d), make_cpu_backend()) {}

    WalkResult walk(const Eigen::Isometry3d& b)
    {
        scene_.poses[1] = b;
        const WalkPair pair = forest_.walk_pair(scene_, 0, 1);
        ParkedWork parked;
        Walker *walker = &walkers_[0], *last = &walkers_[1];
        walker->clear();
        WalkResult result = walker->start(pair, 0, forest_.backend(), parked);
        for (int round = 1; result.status == WalkStatus::parked; ++round) {
            requests_.clear();
            walker->requests(pair, parked, requests_);
            std::sort(requests_.begin(), requests_.end());
            requests_.erase(std::unique(requests_.begin(), requests_.end()), requests_.end());
            forest_.submit(requests_, 1);
            forest_.grow(0);
            std::swap(walker, last);
            walker->clear();
            result = walker->resume(pair, 0, forest_.backend(), *last, result, round, false, parked);
        }
        return result;
    }

    const Forest& forest() const { return forest_; }
    std::uint64_t cell_pairs() const { return walkers_[0].node_pairs() + walkers_[1].node_pairs(); }
    void reset_counters() { walkers_[0].reset_counters(), walkers_[1].reset_counters(); }

    const int depth;

private:
    static Settings at_depth(int depth)
    {
        Settings settings;
        settings.depth = depth;
        return settings;
    }

    Scene& scene_;
    Forest forest_;
    Walker walkers_[2]; ///< the one at work, and the one that parked last
    std::vector<CellRequest> requests_;
};

/// One way to answer, and what it took.
struct Contender {
    std::string name;
    std::function<bool(const Pose&)> answer; ///< true: not known to be separate
    std::vector<double> us = {};             ///< by pose, the least of the repeats
    std::uint64_t false_alarms = 0, missed = 0;
};

class PosesBench {
public:
    explicit PosesBench(const PosesOptions& options) : options_(options)
    {
        const fs::path folder = data_folder(options.data) / "poses";
        poses_ = read_poses(folder / "bunny5110_cow5144.txt");
        read_expected(folder / "bunny5110_cow5144_expected.txt", poses_);
        if (options.poses > 0 && std::size_t(options.poses) < poses_.size()) poses_.resize(std::size_t(options.poses));
        for (const char* name : {"bunny_5110", "cow_5144"})
            scene_.add_body(
                {.name = name, .geometry = scene_.add(name, load_mesh(folder / (std::string(name) + ".obj")))});
        const Mesh &bunny = std::get<Mesh>(scene_.geometries[0].data), &cow = std::get<Mesh>(scene_.geometries[1].data);
        obb_ = std::make_unique<FclPair<fcl::OBBd>>(bunny, cow);
        rss_ = std::make_unique<FclPair<fcl::OBBRSSd>>(bunny, cow);
        for (int depth : parse_depths("--depths", options.depths))
            trees_.push_back(std::make_unique<TreePair>(scene_, depth));
        add_contenders();
    }

    int run()
    {
        say("poses      {} of a bunny (5,110 triangles) and a cow (5,144), {} colliding; least of {} repeats of each "
            "query\n"
            "settings   trees grown by the same poses before, no coherence, one thread\n{}\n",
            grouped(poses_.size()),
            std::count_if(poses_.begin(), poses_.end(), [](const Pose& p) { return p.colliding; }), options_.repeats,
            describe_program(make_cpu_backend()->name()));
        for (Contender& who : contenders_) who.us.assign(poses_.size(), 1e300);
        grow();
        for (std::size_t i = 0; i < poses_.size(); ++i) measure(i);
        print_table();
        check_fcl();
        if (!options_.csv.empty()) write_csv();
        std::uint64_t missed = 0;
        for (const Contender& who : contenders_) missed += who.name.starts_with("FCL") ? 0 : who.missed;
        return missed ? int(ErrorKind::internal) : 0;
    }

private:
    void add_contenders()
    {
        contenders_.push_back({"FCL OBB", [this](const Pose& p) { return obb_->collide(p.b) > 0; }});
        contenders_.push_back({"FCL OBBRSS", [this](const Pose& p) { return rss_->collide(p.b) > 0; }});
        for (const auto& tree : trees_)
            contenders_.push_back({fmt::format("depth {}", tree->depth), [t = tree.get()](const Pose& p) {
                                       return t->walk(p.b).status != WalkStatus::separate;
                                   }});
        for (const auto& tree : trees_)
            contenders_.push_back({fmt::format("depth {} + fcl", tree->depth), [this, t = tree.get()](const Pose& p) {
                                       return t->walk(p.b).status != WalkStatus::separate && obb_->collide(p.b) > 0;
                                   }});
    }

    /// Lets every tree meet every pose once.
    void grow()
    {
        for (const auto& tree : trees_) {
            const auto from = Clock::now();
            for (const Pose& pose : poses_) tree->walk(pose.b);
            growth_.push_back(std::chrono::duration<double, std::milli>(Clock::now() - from).count());
            tree->reset_counters();
            for (const Pose& pose : poses_) tree->walk(pose.b);
            cell_pairs_.push_back(double(tree->cell_pairs()) / double(poses_.size()));
        }
    }

    void measure(std::size_t i)
    {
        const Pose& pose = poses_[i];
        for (std::size_t k = 0; k < contenders_.size(); ++k) {
            Contender& who = contenders_[(i + k) % contenders_.size()]; // turn about
            bool answer = false;
            for (int repeat = 0; repeat < options_.repeats; ++repeat) {
                const auto from = Clock::now();
                answer = who.answer(pose);
                who.us[i] = std::min(who.us[i], std::chrono::duration<double, std::micro>(Clock::now() - from).count());
            }
            who.false_alarms += answer && !pose.colliding;
            who.missed += !answer && pose.colliding;
        }
    }

    void print_table() const
    {
        const auto part = [&](const Contender& who, bool colliding) {
            std::vector<double> us;
            for (std::size_t i = 0; i < poses_.size(); ++i)
                if (poses_[i].colliding == colliding) us.push_back(who.us[i]);
            return us;
        };
        const double fcl_median = median(contenders_[0].us), fcl_mean = mean(contenders_[0].us);
        say("{:<16}{:>10}{:>10}{:>12}{:>12}{:>12}{:>12}{:>10}{:>10}\n", "microseconds", "median", "mean", "mean, hits",
            "mean, misses", "OBB/median", "OBB/mean", "false", "missed");
        for (const Contender& who : contenders_)
            say("{:<16}{:>10.2f}{:>10.2f}{:>12.2f}{:>12.2f}{:>12.2f}{:>12.2f}{:>10}{:>10}\n", who.name, median(who.us),
                mean(who.us), mean(part(who, true)), mean(part(who, false)), fcl_median / median(who.us),
                fcl_mean / mean(who.us), who.false_alarms, who.missed);
        say("\nFCL builds OBB in {:.2f} ms, OBBRSS in {:.2f} ms\n\n", obb_->build_ms, rss_->build_ms);
        say("{:<8}{:>14}{:>16}{:>18}{:>14}{:>20}{:>12}\n", "trees", "bound", "% of diagonal", "cell pairs/query",
            "cells", "growing, ms in all", "MB");
        const double diagonal = bounds_of(scene_.geometries[0]).diagonal();
        for (std::size_t k = 0; k < trees_.size(); ++k) {
            double bound = 0;
            for (const Pose& pose : poses_)
                if (const WalkResult walk = trees_[k]->walk(pose.b); walk.status == WalkStatus::touching)
                    bound = std::max(bound, walk.bound);
            const Forest& forest = trees_[k]->forest();
            say("{:<8}{:>14.6f}{:>16.2f}{:>18.1f}{:>14}{:>20.2f}{:>12.3f}\n", fmt::format("depth {}", trees_[k]->depth),
                bound, 100 * bound / diagonal, cell_pairs_[k], grouped(forest.nodes()), growth_[k],
                double(forest.bytes()) / 1e6);
        }
    }

    /// FCL counts every intersecting pair of triangles; the expected numbers are exact.
    void check_fcl() const
    {
        std::uint64_t sum = 0, expected = 0, differing = 0, wrong = 0;
        for (const Pose& pose : poses_) {
            const std::size_t pairs = obb_->collide(pose.b, 10'000'000);
            sum += pairs, expected += pose.triangle_pairs;
            differing += pairs != pose.triangle_pairs, wrong += (pairs > 0) != pose.colliding;
        }
        say("\nexact answers: {} triangle pairs expected, FCL finds {}; {} poses differ in number, {} in colliding or "
            "not\n",
            grouped(expected), grouped(sum), differing, wrong);
    }

    void write_csv() const
    {
        OutputFile file(options_.csv);
        file.print("pose,colliding,triangle_pairs");
        for (const Contender& who : contenders_) file.print(",{} us", who.name);
        file.print("\n");
        for (std::size_t i = 0; i < poses_.size(); ++i) {
            file.print("{},{},{}", i, int(poses_[i].colliding), poses_[i].triangle_pairs);
            for (const Contender& who : contenders_) file.print(",{:.3f}", who.us[i]);
            file.print("\n");
        }
        file.commit();
    }

    PosesOptions options_;
    std::vector<Pose> poses_;
    Scene scene_;
    std::unique_ptr<FclPair<fcl::OBBd>> obb_;
    std::unique_ptr<FclPair<fcl::OBBRSSd>> rss_;
    std::vector<std::unique_ptr<TreePair>> trees_;
    std::vector<double> growth_, cell_pairs_; ///< by tree
    std::vector<Contender> contenders_;
};

} // namespace

int bench_poses(const PosesOptions& options)
{
    if (options.repeats < 1 || options.repeats > 1000)
        throw Error(ErrorKind::usage, fmt::format("--repeats {}: must be from 1 to 1000", options.repeats));
    if (!options.csv.empty()) check_writable(options.csv);
    return PosesBench(options).run();
}

} // namespace oncollide::tools

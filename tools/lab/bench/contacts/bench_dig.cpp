// oncollide-lab bench dig: a terrain that a digger changes, with bodies on it.
#include "bench/common/benchmark.hpp"
#include "peers/peers.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::tools {
namespace {

struct DigOptions : SharedOptions {
    int side = 1000, bodies = 300, frames = 40;
};

/// In each frame the digger takes a heap from a square of a tenth of the side, 1 % of the terrain, and goes on.
class DigScene {
public:
    explicit DigScene(const DigOptions& options)
    {
        const auto side = static_cast<std::uint32_t>(options.side), part = std::max(side / 10, 1u);
        grid_.columns = grid_.rows = side;
        const Terrain hills = make_hills(side - 1, side - 1, 1, 10, 1);
        for (std::uint32_t row = 0; row < side; ++row)
            for (std::uint32_t column = 0; column < side; ++column) heights_.push_back(hills.height(column, row));
        heights_.back() = -2.0 * options.frames; // so that Bullet's height field has room below
        first_ = heights_;
        ground_ = std::make_unique<Geometry>(Geometry{"ground", make_terrain("ground", grid_, heights_), {}});
        place_bodies(options.bodies);
        for (int frame = 0; frame <= options.frames; ++frame) {
            const std::uint32_t at = side > part ? std::uint32_t(frame) * (part / 5 + 1) % (side - part) : 0;
            digs_.push_back({{at, at, part, part}, {}});
            for (std::uint32_t y = 0; y < part; ++y)
                for (std::uint32_t x = 0; x < part; ++x) {
                    double& height = heights_[std::size_t(at + y) * side + at + x];
                    height -= 0.5 * std::sin(3.14 * x / part) * std::sin(3.14 * y / part);
                    digs_.back().heights.push_back(height);
                }
        }
    }

    struct Dig {
        TerrainRectangle where;
        std::vector<double> heights;
    };
    const std::vector<Dig>& digs() const { return digs_; }
    std::span<const ContactPeerBody> bodies() const { return bodies_; } ///< the first one is the terrain
    const TerrainGrid& grid() const { return grid_; }
    const std::vector<double>& first() const { return first_; } ///< heights before the first frame

private:
    /// Bodies that touch the ground, half of them on the digger's way.
    void place_bodies(int count)
    {
        shapes_.push_back(std::make_unique<Geometry>(Geometry{"ball", Shape(Sphere{0.5}), {}}));
        shapes_.push_back(std::make_unique<Geometry>(Geometry{"box", Shape(Box{{0.5, 0.75, 0.5}}), {}}));
        shapes_.push_back(std::make_unique<Geometry>(Geometry{"capsule", Shape(Capsule{0.25, 1}), {}}));
        const auto& ground = std::get<Terrain>(ground_->data);
        bodies_.push_back({ground_.get(), true, Eigen::Isometry3d::Identity()});
        for (int i = 0; i < count; ++i) {
            const auto place = [&](std::uint64_t axis) {
                return static_cast<std::uint32_t>(u01(2, std::uint64_t(i), axis) * (grid_.columns - 2) + 0.5);
            };
            const std::uint32_t x = place(0), y = i % 2 ? x : place(1);
            Eigen::Isometry3d pose(Eigen::Translation3d(ground.point(x, y) + Eigen::Vector3d(0, 0, 0.45)));
            bodies_.push_back({shapes_[std::size_t(i) % shapes_.size()].get(), false, pose});
        }
    }

    TerrainGrid grid_;
    std::vector<double> heights_, first_;
    std::unique_ptr<Geometry> ground_;
    std::vector<std::unique_ptr<Geometry>> shapes_;
    std::vector<ContactPeerBody> bodies_;
    std::vector<Dig> digs_;
};

/// A World, whose terrain changes by set_heights(), or is replaced.
class DugWorld final : public ContactPeer {
public:
    DugWorld(const DigScene& scene, bool replace) : scene_(scene), replace_(replace), heights_(scene.first())
    {
        const auto unowned = [](const Geometry* geometry) {
            return std::shared_ptr<const Geometry>(std::shared_ptr<const Geometry>(), geometry);
        };
        for (const ContactPeerBody& body : scene.bodies()) {
            auto& [geometry, model] = models_.emplace_back(body.geometry, ModelId{});
            const auto same = std::ranges::find(models_, geometry, &std::pair<const Geometry*, ModelId>::first);
            model = same->second ? same->second : world_.models().add(unowned(geometry));
            world_.bodies().add({.model = model, .pose = body.pose, .is_static = body.is_static});
        }
    }
    void place(std::span<const Eigen::Isometry3d>) override {}
    bool set_heights(std::size_t body, const TerrainRectangle& where, std::span<const double> heights) override
    {
        const ModelId ground = models_[body].second;
        if (!replace_) return world_.models().set_heights(ground, where, heights), true;
        for (std::uint32_t row = 0; row < where.rows; ++row)
            std::ranges::copy(heights.subspan(std::size_t(row) * where.columns, where.columns),
                              heights_.begin() + std::ptrdiff_t(where.row + row) * scene_.grid().columns +
                                  where.column);
        world_.models().replace(ground, make_terrain("ground", scene_.grid(), heights_));
        return true;
    }
    std::size_t contacts() override
    {
        world_.step();
        return world_.manifolds().points.size();
    }
    std::size_t contacts_of(std::span<const BodyPair>) override { return 0; }

private:
    const DigScene& scene_;
    bool replace_;
    std::vector<double> heights_;
    World world_;
    std::vector<std::pair<const Geometry*, ModelId>> models_; ///< by body
};

struct DigResult {
    double update_ms = 0, contacts_ms = 0; ///< per frame
    std::vector<std::size_t> contacts;     ///< by frame
};

/// Plays the frames once; the first frame is not timed. Empty: the peer's terrains do not change.
std::optional<DigResult> play(ContactPeer& peer, const DigScene& scene)
{
    DigResult result;
    for (const DigScene::Dig& dig : scene.digs()) {
        const double begin = processor_ms();
        if (!peer.set_heights(0, dig.where, dig.heights)) return std::nullopt;
        const double updated = processor_ms();
        const std::size_t contacts = peer.contacts();
        const double end = processor_ms();
        if (!result.contacts.empty()) result.update_ms += updated - begin, result.contacts_ms += end - updated;
        result.contacts.push_back(contacts);
    }
    const auto timed = double(scene.digs().size() - 1);
    result.update_ms /= timed, result.contacts_ms /= timed;
    return result;
}

/// Milliseconds of a copy of the heights that change in a frame.
double copy_ms(const DigScene& scene)
{
    std::vector<double> to(scene.digs()[0].heights.size());
    const double begin = processor_ms();
    for (const DigScene::Dig& dig : scene.digs()) {
        std::memcpy(to.data(), dig.heights.data(), to.size() * sizeof(double));
        asm volatile("" : : "r"(to.data()) : "memory"); // the copy is used
    }
    return (processor_ms() - begin) / double(scene.digs().size());
}

/// Returns the exit code: 70 if the results of a World depend on how its terrain changed.
int bench_dig(const DigOptions& options)
{
    const DigScene scene(options);
    struct Racer {
        std::string name;
        std::function<std::unique_ptr<ContactPeer>()> make;
        DigResult least{};
    };
    std::vector<Racer> racers;
    racers.push_back({"oncollide", [&] { return std::make_unique<DugWorld>(scene, false); }});
    racers.push_back({"oncollide-replace", [&] { return std::make_unique<DugWorld>(scene, true); }});
    const ContactContenders others = all_contenders().contacts;
    for (const ContactContender& other : others.all)
        racers.push_back({other.name, [&] { return other.make(scene.bodies()); }});
    say("{}", describe_program("cpu"));
    print_missing(others.missing);
    say("one thread, processor time per frame; least of {} runs of {} frames, of which the first is not timed.\n",
        options.repeats, options.frames + 1);
    double copy = 0;
    for (int run = 0; run < options.repeats; ++run) {
        copy = run ? std::min(copy, copy_ms(scene)) : copy_ms(scene);
        std::erase_if(racers, [&](Racer& racer) {
            const std::optional<DigResult> now = play(*racer.make(), scene);
            if (!now) return true;
            const auto ms = [](const DigResult& r) { return r.update_ms + r.contacts_ms; };
            if (run == 0 || ms(*now) < ms(racer.least)) racer.least = *now;
            return false;
        });
    }
    ResultTable table(options.csv, {17});
    for (const Racer& racer : racers) {
        const DigResult &r = racer.least, &first = racers[0].least;
        const double ms = r.update_ms + r.contacts_ms;
        std::size_t contacts = 0;
        for (const std::size_t of_frame : r.contacts) contacts += of_frame;
        table.row(figures("contender", racer.name, "update_ms", r.update_ms, "contacts_ms", r.contacts_ms, "ms", ms,
                          "ratio", ms / (first.update_ms + first.contacts_ms), "copies", r.update_ms / copy, "contacts",
                          contacts));
    }
    table.commit();
    return code_of(racers[0].least.contacts != racers[1].least.contacts);
}

} // namespace

void add_dig(Arguments bench)
{
    Benchmark<DigOptions> b(bench, "dig", "A terrain that changes in every frame, with bodies on it", bench_dig);
    b.whole("--side N", b->side, "heights of the terrain along x and along y", {20, 20'000});
    b.whole("--bodies N", b->bodies, "balls, boxes and capsules that lie on it", {1, 1'000'000});
    b.whole("--frames N", b->frames, "frames that are timed", {1, 10'000});
    b.repeats(), b.csv("contender");
    b.footer("In every frame 1 % of the heights change, and the contacts of all bodies with the terrain are found. "
             "'oncollide-replace': each frame replaces the model by a new terrain. Bullet changes the heights of its "
             "height field in place; it counts points up to 20 mm apart, too. 'ratio': to the time of the first "
             "contender. 'copies': the update, as a multiple of a copy of the heights that change. Exit code 70: the "
             "two of oncollide find different contacts.");
}

} // namespace oncollide::tools

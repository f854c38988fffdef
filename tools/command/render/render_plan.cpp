#include "render/render_plan.hpp"

#include <algorithm>
#include <charconv>
#include <tuple>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>

#include "common/numbers.hpp"

namespace oncollide::tools {

namespace {

constexpr int least_side = 16, most_side = 4096; ///< pixels

std::pair<int, int> size_from(const std::string& text)
{
    int width = 0, height = 0;
    const char* end = text.data() + text.size();
    const auto [middle, error] = std::from_chars(text.data(), end, width);
    if (error == std::errc{} && middle != end && *middle == 'x') {
        const auto [rest, second] = std::from_chars(middle + 1, end, height);
        if (second == std::errc{} && rest == end && std::min(width, height) >= least_side &&
            std::max(width, height) <= most_side)
            return {width, height};
    }
    usage(fmt::format("--size {}: expected WIDTHxHEIGHT, {} to {} pixels each", text, least_side, most_side));
}

void check_frames(const std::vector<int>& frames, const Scene& scene)
{
    for (std::size_t i = 0; i < frames.size(); ++i) {
        if (frames[i] < 0 || frames[i] >= scene.frames)
            usage(fmt::format("--frame {}: '{}' has the frames 0 to {} (--frames N extends it)", frames[i], scene.name,
                              scene.frames - 1));
        if (i && frames[i] <= frames[i - 1])
            usage(fmt::format("--frame {}: follows {}; frames must ascend", frames[i], frames[i - 1]));
    }
}

/// x.png -> x-0040.png; as many digits as the last frame needs, so that names sort by frame.
std::string numbered(const std::string& file, int frame, int last)
{
    const std::filesystem::path path(file);
    const std::size_t digits = std::max<std::size_t>(4, std::to_string(last).size());
    const std::string name = fmt::format("{}-{:0{}}{}", path.stem().string(), frame, digits, path.extension().string());
    return (path.parent_path() / name).string();
}

std::vector<ImagePlan> images_from(const RenderOptions& o, const Scene& scene)
{
    if (o.out.empty()) usage("--out: the file name is empty");
    check_frames(o.frames, scene);
    const std::vector<int> frames = o.frames.empty() ? std::vector<int>{scene.frames - 1} : o.frames;
    if (!o.every) return {{o.out, frames}};
    check_range("--every", *o.every, 1);
    if (frames.size() > 1) usage("--every: needs a single --frame, up to which to draw");
    if (o.out == "-") usage("--every: several pictures cannot go to standard output");
    std::vector<ImagePlan> images;
    for (std::int64_t frame = 0; frame <= frames.front(); frame += *o.every)
        images.push_back({numbered(o.out, int(frame), frames.front()), {int(frame)}});
    return images;
}

/// Finds a body by its name, or by its label: "body 3".
SceneBodyId body_of(const Scene& scene, const std::string& name)
{
    if (const std::optional<SceneBodyId> body = scene.find(name)) return *body;
    std::vector<std::string> labels;
    for (std::uint32_t body = 0; body < scene.size(); ++body) {
        if (scene.names[body].empty() && scene.label(SceneBodyId{body}) == name) return SceneBodyId{body};
        if (body < 20) labels.push_back(scene.label(SceneBodyId{body}));
    }
    usage(fmt::format("--body {}: no body has this name; '{}' has: {}{}", name, scene.name, fmt::join(labels, ", "),
                      labels.size() < scene.size() ? fmt::format(" and {} more", scene.size() - labels.size()) : ""));
}

} // namespace

RenderPlan plan_from(const RenderOptions& o, const Settings& settings, const Scene& scene)
{
    RenderPlan plan;
    std::tie(plan.width, plan.height) = size_from(o.size);
    plan.images = images_from(o, scene);
    const int last = o.whole || settings.max_error ? deepest_level : settings.depth.value_or(6);
    for (int level : o.levels) {
        if (level < 0 || level > last)
            usage(fmt::format("--level {}: must be 0 to {}{}", level, last,
                              last < deepest_level ? ", the depth of the trees (--depth)" : ""));
        plan.levels.push_back(level);
        plan.deepest = std::max(plan.deepest, level);
    }
    if (o.rays && (o.whole || !o.levels.empty() || o.show == "spheres"))
        usage("--rays: draws surfaces, no spheres; leave out --level, --whole and --show spheres");
    if (o.whole && o.levels.empty()) usage("--whole: needs --level, the depth to which trees are grown");
    if (plan.levels.empty()) plan.levels.push_back(std::nullopt);
    if (plan.width / plan.panels() < least_side)
        usage(fmt::format("--size {}: too narrow for {} pictures side by side", o.size, plan.panels()));
    return plan;
}

ScenePictures::Shown shown_from(const RenderOptions& o, const Settings& settings, const Scene& scene)
{
    if (o.show != "meshes" && o.show != "spheres" && o.show != "both")
        usage(fmt::format("--show {}: expected meshes, spheres or both", o.show));
    ScenePictures::Shown shown{.meshes = o.show != "spheres",
                               .spheres = o.show != "meshes",
                               .bodies = std::vector<std::uint8_t>(scene.size(), o.bodies.empty()),
                               .clearance = settings.clearance,
                               .meeting = exact_level(settings) == ExactLevel::predicates};
    for (const std::string& name : o.bodies) shown.bodies[index(body_of(scene, name))] = 1;
    return shown;
}

View::View(const RenderOptions& o)
{
    const auto point = [](const char* option, const std::string& text) -> std::optional<Eigen::Vector3d> {
        if (text.empty()) return std::nullopt;
        const std::vector<double> numbers = parse_numbers(option, text, 3, "x y z");
        return Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
    };
    eye_ = point("--eye", o.eye), look_at_ = point("--look-at", o.look_at);
    if (eye_ && look_at_ && *eye_ == *look_at_) usage("--eye and --look-at are the same point");
}

Camera View::camera(const Framing& framing) const
{
    Camera camera = framing.camera();
    // The camera keeps the side from which it looks.
    if (look_at_) camera.eye += *look_at_ - camera.look_at, camera.look_at = *look_at_;
    if (eye_) camera.eye = *eye_;
    if (eye_ && !look_at_ && !framing.bounds().empty()) camera.look_at = framing.bounds().centre();
    if (camera.eye == camera.look_at) camera.look_at.y() += 1;
    return camera;
}

} // namespace oncollide::tools

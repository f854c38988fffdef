#include "study/pictures.hpp"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/pipeline/two_geometries.hpp>
#include <oncollide/pipeline/world/world_access.hpp>

#include "cli/progress.hpp"
#include "render/framing.hpp"
#include "render/png.hpp"
#include "render/render_scene.hpp"

namespace oncollide::tools {
namespace {

constexpr int study_panel_side = 360; ///< pixels, of each of the two panels
constexpr std::size_t most_misses = 4;

struct Scenario {
    const StudyRow* row;
    Sighting at;
    bool miss;
};

/// Missed collisions first; then, for each series, the rows with the largest and the smallest error that have a false
/// positive.
std::vector<Scenario> choose(const Study& study)
{
    std::vector<Scenario> chosen;
    for (const StudyRow& row : study.rows)
        if (row.first_miss && chosen.size() < most_misses) chosen.push_back({&row, *row.first_miss, true});
    std::set<std::string> series;
    for (const StudyRow& row : study.rows) {
        if (!row.variant.certified() || !series.insert(row.variant.series).second) continue;
        std::vector<const StudyRow*> rows;
        for (const StudyRow& other : study.rows)
            if (other.variant.series == row.variant.series && other.worst_false_positive) rows.push_back(&other);
        if (rows.empty()) continue;
        const auto [narrow, wide] = std::ranges::minmax_element(rows, {}, &StudyRow::error);
        chosen.push_back({*wide, *(*wide)->worst_false_positive, false});
        if (narrow != wide) chosen.push_back({*narrow, *(*narrow)->worst_false_positive, false});
    }
    return chosen;
}

/// The point midway between the two nearest triangles; empty unless both bodies are meshes.
std::optional<Eigen::Vector3d> nearest_place(const Scene& scene, BodyPair pair)
{
    const auto mesh = [&](std::uint32_t body) {
        return std::get_if<Mesh>(&scene.geometries[index(scene.geometry[body])].data);
    };
    if (!mesh(pair.a) || !mesh(pair.b)) return std::nullopt;
    const Distance found = distance(*mesh(pair.a), scene.poses[pair.a], *mesh(pair.b), scene.poses[pair.b]);
    const auto centre = [&](std::uint32_t body, std::uint32_t triangle) {
        const Triangle& t = mesh(body)->triangles[triangle];
        const auto& v = mesh(body)->vertices;
        return Eigen::Vector3d(scene.poses[body] * ((v[t[0]] + v[t[1]] + v[t[2]]) / 3));
    };
    return 0.5 * (centre(pair.a, found.a.triangle) + centre(pair.b, found.b.triangle));
}

PagePicture draw(StudyWorkload& workload, const Scenario& scenario, PainterProcess& painter)
{
    const Settings& settings = scenario.row->variant.settings;
    const BodyPair pair = scenario.at.pair;
    Scene& scene = workload.scene;
    workload.move(0);
    Pipeline pipeline(scene, settings);
    std::vector<PairResult> pairs;
    for (int frame = 0; frame <= scenario.at.frame; ++frame) {
        workload.move(frame);
        const FrameView view = pipeline.step(scene);
        pairs.clear();
        for (const PairResult& p : view.pairs)
            if (index(p.a) == pair.a && index(p.b) == pair.b) pairs.push_back(p);
    }
    // OBBs are not drawn: the spheres of their bodies would belong to other pairs.
    ScenePictures::Shown shown{.spheres = !wants_obbs(settings),
                               .bodies = std::vector<std::uint8_t>(scene.size()),
                               .clearance = settings.clearance};
    shown.bodies[pair.a] = shown.bodies[pair.b] = 1;
    ScenePictures pictures(scene, shown);
    ScenePicture picture = pictures.make(
        pipeline.world(), [&](GeometryId id) { return WorldAccess::tree(pipeline.world(), pipeline.model(id)); }, pairs,
        std::nullopt);
    picture.width = picture.height = study_panel_side;
    Framing framing(study_panel_side, study_panel_side);
    framing.add(picture);
    picture.camera = framing.camera();
    Image image = blank(2 * study_panel_side, study_panel_side);
    paste(painter.draw(picture), study_panel_side, image, 0);
    if (const auto place = nearest_place(scene, pair)) {
        const Eigen::Vector3d back = (picture.camera.eye - picture.camera.look_at).normalized();
        const double size = std::max(4 * scenario.at.bound, 0.15 * framing.bounds().diagonal());
        picture.camera.look_at = *place, picture.camera.eye = *place + 2 * size * back;
        paste(painter.draw(picture), study_panel_side, image, study_panel_side);
    }
    const std::string what = scenario.miss ? "missed: they collide, but were reported separate"
                                           : fmt::format("false positive: {:.3g} m apart, certified within {:.3g} m",
                                                         scenario.at.distance, scenario.at.bound);
    return {fmt::format("{}, frame {}: {} and {}; {}.", scenario.row->variant.name, workload.number(scenario.at.frame),
                        scene.label(SceneBodyId{pair.a}), scene.label(SceneBodyId{pair.b}), what),
            packed_png(image)};
}

} // namespace

StudyPictures draw_study_pictures(StudyWorkload& workload, const Study& study, PainterProcess& painter)
{
    StudyPictures result;
    const std::vector<Scenario> chosen = choose(study);
    if (chosen.empty()) return result;
    try {
        painter.open();
        Progress progress("picture", chosen.size());
        for (const Scenario& scenario : chosen)
            result.all.push_back(draw(workload, scenario, painter)), progress.step();
    } catch (const Error& error) {
        if (error.kind() != ErrorKind::no_gpu) throw;
        result.missing = fmt::format("{}ictures: {}", result.all.empty() ? "No p" : "Not all p", error.what());
    }
    return result;
}

} // namespace oncollide::tools

#include "view/view_page.hpp"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/text/number_text.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/base/text/svg.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/runs/report.hpp>

#include "common/base64.hpp"
#include "view/page_about.hpp"
#include "view/page_file.hpp"
#include "view/page_model.hpp"
#include "view/page_text.hpp"
#include "view/page_trees.hpp"

namespace oncollide::tools {
namespace {

using nlohmann::json;

constexpr std::size_t bytes_of_body = 25, bytes_of_triangle = 16;
/// Sizes as JSON, with the coarsest meshes.
constexpr std::size_t bytes_of_header = 800, bytes_of_geometry = 600;
constexpr std::uint64_t most_triangles = 1'500'000, most_of_model = 250'000; ///< browsers draw this many easily
constexpr std::size_t least_frames = 32;    ///< that fit, with meshes that deform: these are simplified until they do
constexpr std::size_t most_of_level = 3000; ///< volumes of trees
/// Bytes of the trees of one geometry.
constexpr std::size_t most_bytes_of_trees = 12 * most_of_level * 4 / 3 + 32 * most_of_level * 8 / 7;

json columns_of(const Eigen::Vector3d& v)
{
    return {v.x(), v.y(), v.z()};
}

/// The largest limit per geometry such that all geometries together have at most `most`.
std::uint64_t cap_for(std::vector<std::uint64_t> counts, std::uint64_t most)
{
    std::sort(counts.begin(), counts.end());
    for (std::size_t k = 0; k < counts.size(); ++k) {
        const std::uint64_t share = most / (counts.size() - k);
        if (counts[k] > share) return share;
        most -= counts[k];
    }
    return std::numeric_limits<std::uint64_t>::max();
}

} // namespace

Option add_view_limit(Arguments command, int& limit)
{
    return command.add_option("--view-limit MB", limit,
                              "size limit of the page in MB (default 40); to keep it, frames are dropped and meshes "
                              "simplified, and the page says so");
}

void check_view(const char* option, const std::string& file, int limit, const OutputOptions& outputs,
                const std::vector<std::string>& inputs)
{
    if (file.empty()) return;
    check_range("--view-limit", limit, 2, 1000);
    if (file == "-") usage(fmt::format("{}: needs a file; a page cannot go to standard output", option));
    check_files({{option, file},
                 {"--json", outputs.json},
                 {"--csv", outputs.csv},
                 {"--trace", outputs.trace},
                 {"--picture", outputs.picture}},
                inputs);
    read_three_js();
}

/// Geometries and trees of a page.
struct ViewPage::Shown {
    json geometries = json::array(), notes = json::array();
    std::vector<std::pair<std::string, std::string>> blocks; ///< by name, base64
    std::uint64_t simplified = 0, triangles = 0, shown_triangles = 0, without_trees = 0;
    std::size_t taken = 0; ///< bytes of the blocks

    void add(std::string name, const PageBlock& block)
    {
        blocks.emplace_back(std::move(name), base64(block.bytes()));
        taken += blocks.back().second.size() + 64;
    }
};

ViewPage::ViewPage(const Scene& scene, const Pipeline& pipeline, const Options& options)
    : scene_(scene), pipeline_(pipeline), options_(options), three_(read_three_js()),
      deforming_(scene, std::min<std::uint64_t>(options.most_bytes / encoded_size(6 * least_frames), most_triangles))
{
    using namespace page;
    std::size_t fixed = three_.library.size() + three_.controls.size() + 16'384;
    for (const std::string_view text :
         {page_html, style_css, columns_js, data_js, bodies_js, sprites_js, overlay_js, trees_js, panel_js, main_js})
        fixed += text.size();
    frames_ = std::make_unique<PageFrames>(scene, pipeline, deforming_, options.separate, 0);
    const std::size_t bodies = encoded_size(bytes_of_body * scene.size()) + bytes_of_geometry * scene.geometries.size();
    const std::size_t least = fixed + bodies + 2 * encoded_size(frames_->least_bytes()) + 500'000;
    if (least > options.most_bytes)
        throw Error(ErrorKind::usage,
                    fmt::format("--view-limit: a page of {} bodies needs at least {}; set --view-limit to {} or more",
                                grouped(scene.size()), megabytes(least), (least + 999'999) / 1'000'000));
    room_ = options.most_bytes - fixed - bodies;
    std::size_t names = 0;
    for (std::size_t body = 0; body < scene.size(); ++body) names += scene.names[body].size() + 3;
    names_ = names < room_ / 5;
    if (names_) room_ -= names;
    frames_room_ = room_ - std::min(room_ / 5 * 2, room_for_geometries());
    const std::size_t without_pairs =
        encoded_size(frames_->least_bytes() + PageFrames::bytes_of_rest) + bytes_of_header;
    const std::size_t of_frame = frames_room_ / (options.frames == 1 ? 1 : 2);
    const std::size_t most_pairs = (std::max(of_frame, without_pairs) - without_pairs) * 3 / 4;
    frames_ = std::make_unique<PageFrames>(scene, pipeline, deforming_, options.separate,
                                           most_pairs / frames_->bytes_of_pair());
}

void ViewPage::add(const FrameView& frame)
{
    if (seen_++ % step_) return;
    PageFrame made = frames_->make(frame);
    kept_.push_back({std::move(made.header), base64(made.block.bytes())});
    kept_bytes_ += kept_.back().block.size() + bytes_of_header;
    while (kept_bytes_ > frames_room_ && kept_.size() > 1) thin_out();
}

/// Drops every second of the kept frames.
void ViewPage::thin_out()
{
    step_ *= 2;
    std::size_t to = 0;
    kept_bytes_ = 0;
    for (std::size_t k = 0; k < kept_.size(); k += 2) {
        if (to != k) kept_[to] = std::move(kept_[k]);
        kept_bytes_ += kept_[to++].block.size() + bytes_of_header;
    }
    kept_.resize(to);
}

/// Bytes of all meshes and trees, at most.
std::size_t ViewPage::room_for_geometries() const
{
    std::uint64_t triangles = 0;
    for (const Geometry& geometry : scene_.geometries) triangles += std::min(page_triangles(geometry), most_of_model);
    // Coarser meshes take three sevenths more.
    return encoded_size(std::min(triangles, most_triangles) * bytes_of_triangle) * 10 / 7 +
           encoded_size(most_bytes_of_trees) * scene_.geometries.size();
}

ViewPage::LeftOut ViewPage::most_left_out() const
{
    LeftOut most;
    for (const Kept& kept : kept_)
        if (const std::uint64_t pairs = kept.header.at("left_out"); pairs > most.pairs)
            most = {kept.header.at("frame"), pairs, pairs + kept.header.at("pairs").get<std::uint64_t>()};
    return most;
}

std::size_t ViewPage::room_left() const
{
    return room_ - std::min(room_, kept_bytes_);
}

ViewPage::Shown ViewPage::shown() const
{
    Shown shown;
    std::vector<std::uint8_t> used(scene_.geometries.size());
    for (const GeometryId id : scene_.geometry) used[index(id)] = 1;
    std::vector<std::uint64_t> counts;
    for (std::size_t g = 0; g < used.size(); ++g)
        if (used[g]) counts.push_back(page_triangles(scene_.geometries[g]));
    const std::uint64_t room_for =
        std::min<std::uint64_t>(room_left() * 3 / 4 * 7 / 10 / bytes_of_triangle, most_triangles);
    const std::uint64_t cap = std::max<std::uint64_t>(std::min(cap_for(counts, room_for), most_of_model), 12);
    for (std::uint32_t g = 0; g < used.size(); ++g) {
        shown.geometries.push_back({{"name", names_ ? printable(scene_.geometries[g].name) : ""}});
        if (used[g]) add_model(shown, g, cap);
    }
    add_all_trees(shown);
    return shown;
}

/// @param cap  largest number of triangles
void ViewPage::add_model(Shown& shown, std::uint32_t g, std::uint64_t cap) const
{
    const PageModel* const deforming = deforming_.of(g);
    const PageModel model = deforming ? *deforming : make_page_model(scene_, GeometryId{g}, cap);
    json& entry = shown.geometries[g];
    if (deforming) entry["deforms"] = true;
    entry["kind"] = model.kind, entry["triangles"] = model.triangles;
    entry["low"] = columns_of(model.box.min), entry["high"] = columns_of(model.box.max);
    entry["meshes"] = json::array();
    for (std::size_t k = 0; k < model.meshes.size(); ++k) {
        entry["meshes"].push_back({model.meshes[k].vertices.size(), model.meshes[k].triangles()});
        shown.add(fmt::format("m{}.{}", g, k), model.meshes[k].block());
    }
    if (!model.simplified) return;
    ++shown.simplified, shown.triangles += page_triangles(scene_.geometries[g]);
    shown.shown_triangles += model.meshes[0].triangles();
}

/// Adds the trees of the rigid geometries that were in pairs, the most frequent first, while there is room.
void ViewPage::add_all_trees(Shown& shown) const
{
    std::vector<std::uint32_t> order;
    for (std::uint32_t g = 0; g < scene_.geometries.size(); ++g)
        if (frames_->touched()[g] && !scene_.geometries.deforms(g)) order.push_back(g);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t x, std::uint32_t y) { return frames_->touched()[x] > frames_->touched()[y]; });
    for (const std::uint32_t g : order) {
        if (shown.taken + encoded_size(most_bytes_of_trees) > room_left()) {
            ++shown.without_trees;
            continue;
        }
        const PageTrees trees = make_page_trees(scene_.geometries.share(g), most_of_level, options_.threads);
        if (!trees.spheres.empty()) add_levels(shown, g, "spheres", trees.spheres);
        if (!trees.boxes.empty()) add_levels(shown, g, "boxes", trees.boxes);
    }
}

/// @param name  "spheres" or "boxes"
void ViewPage::add_levels(Shown& shown, std::uint32_t g, std::string_view name,
                          const std::vector<PageTrees::Level>& levels)
{
    const bool balls = name == "spheres";
    json list = json::array();
    std::vector<float> centres, halves;
    std::vector<std::int16_t> turns;
    for (const PageTrees::Level& level : levels) {
        list.push_back({level.volumes.size(), level.error, level.volumes.empty() ? 0 : level.volumes[0].radius()});
        for (const CoveringVolume& v : level.volumes) {
            append(centres, v.centre);
            if (balls) continue;
            append(halves, v.half);
            Eigen::Matrix3d axes = v.axes;
            if (axes.determinant() < 0) axes.col(2) *= -1; // the box stays the same
            append(turns, Eigen::Quaterniond(axes).normalized());
        }
    }
    shown.geometries[g][std::string(name)] = std::move(list);
    PageBlock block;
    block.add(centres), block.add(halves), block.add(turns);
    shown.add(fmt::format("{}{}", name[0], g), block);
}

void ViewPage::summarize(const Shown& shown, std::size_t size)
{
    summary_ = fmt::format("{}: {}, ", printable(options_.file), megabytes(size));
    summary_ += step_ == 1 ? fmt::format("{} frame{}", kept_.size(), kept_.size() == 1 ? "" : "s")
                           : fmt::format("{} of {} frames (one in {})", kept_.size(), seen_, step_);
    if (shown.simplified)
        summary_ +=
            fmt::format("; {} geometr{} shown simplified, {} of {} triangles", shown.simplified,
                        shown.simplified == 1 ? "y" : "ies", grouped(shown.shown_triangles), grouped(shown.triangles));
    const LeftOut lacks = most_left_out();
    if (lacks.pairs)
        summary_ += fmt::format("; {} of {} pairs of frame {} are left out", grouped(lacks.pairs), grouped(lacks.of),
                                lacks.frame);
    if (!names_) summary_ += "; bodies by number, without names";
    if (shown.without_trees) summary_ += fmt::format("; without the trees of {} geometries", shown.without_trees);
    if (step_ > 1 || lacks.pairs || !names_ || shown.without_trees)
        summary_ += fmt::format("; --view-limit allows {}", megabytes(options_.most_bytes));
}

/// Adds notes about frames, pairs, trees, triangles and names that the page lacks.
void ViewPage::add_notes(Shown& made) const
{
    if (step_ > 1)
        made.notes.push_back(fmt::format("The page shows one frame in {}, {} of {}, to stay below {}.", step_,
                                         kept_.size(), grouped(seen_), megabytes(options_.most_bytes)));
    if (const LeftOut lacks = most_left_out(); lacks.pairs)
        made.notes.push_back(
            fmt::format("{} of {} pairs of frame {} are left out, to stay below {}. Their bodies have the colours of "
                        "all pairs.",
                        grouped(lacks.pairs), grouped(lacks.of), lacks.frame, megabytes(options_.most_bytes)));
    if (made.without_trees)
        made.notes.push_back(fmt::format("There was no room for the trees of {} geometries.", made.without_trees));
    if (made.simplified)
        made.notes.push_back(
            fmt::format("{} geometr{} shown simplified, with {} of {} triangles. Results refer to the full "
                        "geometries.",
                        made.simplified, made.simplified == 1 ? "y is" : "ies are", grouped(made.shown_triangles),
                        grouped(made.triangles)));
    if (!names_) made.notes.push_back("Bodies are shown by number: there was no room for their names.");
}

json ViewPage::header_of(Shown& made) const
{
    json header = {{"scene", printable(scene_.name)},
                   {"frames_of_scene", scene_.frames},
                   {"frames_run", seen_},
                   {"bodies", scene_.size()},
                   {"moving", frames_->moving().size()},
                   {"origin", columns_of(frames_->origin())},
                   {"stages", pipeline_.stages()},
                   {"exact", exact_level(pipeline_.settings()) != ExactLevel::off},
                   {"refined", wants_obbs(pipeline_.settings()) ? "boxes" : "spheres"},
                   {"separate", options_.separate},
                   {"clearance", pipeline_.settings().clearance},
                   {"metres", options_.metres},
                   {"geometries", std::move(made.geometries)},
                   {"notes", made.notes},
                   {"about", page_about(pipeline_, options_.metres, options_.results)}};
    header["frames"] = json::array();
    for (const Kept& frame : kept_) header["frames"].push_back(frame.header);
    if (names_) {
        json names = json::array();
        for (std::size_t body = 0; body < scene_.size(); ++body) names.push_back(printable(scene_.names[body]));
        header["names"] = std::move(names);
    }
    return header;
}

/// The bodies and their poses at the start.
PageBlock ViewPage::bodies() const
{
    std::vector<std::uint32_t> geometry;
    std::vector<float> positions;
    std::vector<std::int16_t> turns;
    for (std::uint32_t body = 0; body < scene_.size(); ++body) {
        geometry.push_back(std::uint32_t(index(scene_.geometry[body])));
        const Eigen::Isometry3d start = scene_.start_pose(body);
        append(positions, start.translation() - frames_->origin());
        append(turns, Eigen::Quaterniond(start.linear()).normalized());
    }
    PageBlock block;
    block.add(geometry), block.add(frames_->moving()), block.add(positions), block.add(turns);
    block.add(std::span(scene_.is_static.data(), scene_.is_static.size()));
    return block;
}

void ViewPage::close()
{
    if (kept_.empty()) return;
    Shown made = shown();
    add_notes(made);
    const json header = header_of(made);

    using namespace page;
    OutputFile file(options_.file);
    PageFile out(file, page_html);
    out.until("{{title}}"), out.write(xml_escaped(scene_.name));
    out.until("{{style}}"), out.write(style_css);
    out.until("{{data}}"), out.add_json("header", header);
    out.add_block("bodies", base64(bodies().bytes()));
    for (const auto& [name, block] : made.blocks) out.add_block(name, block);
    for (std::size_t k = 0; k < kept_.size(); ++k) out.add_block(fmt::format("f{}", k), kept_[k].block);
    out.until("{{three}}"), out.write(three_.library), out.write("\n"), out.write(three_.controls);
    out.until("{{script}}"), out.write("(() => {\n");
    for (const std::string_view script :
         {columns_js, data_js, bodies_js, sprites_js, overlay_js, trees_js, panel_js, main_js})
        out.write(script);
    out.write("})();\n"), out.finish();
    file.commit();
    std::error_code error;
    summarize(made, std::filesystem::file_size(options_.file, error));
}

} // namespace oncollide::tools

#include "clash/clash_view.hpp"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/text/number_text.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/base/text/svg.hpp>
#include <oncollide/base/threads/parallel.hpp>

#include "clash/scenery.hpp"
#include "clash/view/clash_page_text.hpp"
#include "clash/view/overlap_surface.hpp"
#include "common/base64.hpp"
#include "view/page_file.hpp"
#include "view/page_model.hpp"
#include "view/page_text.hpp"
#include "view/three_js.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;
using nlohmann::json;

constexpr std::size_t most_drawn_triangles = 3'000'000; ///< browsers draw this many easily
constexpr std::size_t bytes_of_triangle = 15;           ///< indices, and half a vertex
constexpr std::size_t most_of_clash = 30'000;           ///< triangles, and lines, of its common part

json numbers_of(const Vector3d& v)
{
    return {v.x(), v.y(), v.z()};
}

const Mesh& mesh_of(const PartList& list, std::uint32_t mesh)
{
    return std::get<Mesh>(list.meshes[mesh]->data);
}

/// All meshes of parts: vertices relative to the middle of the mesh's AABB.
struct PageMeshes {
    json counts = json::array(); ///< for each mesh its vertices and triangles
    std::vector<float> positions;
    std::vector<std::uint32_t> wide; ///< indices of meshes with more than 65,536 vertices
    std::vector<std::uint16_t> narrow;
    std::uint64_t simplified = 0, triangles = 0, shown_triangles = 0;

    void add(const Vector3d& middle, std::span<const Vector3d> vertices, std::span<const Triangle> faces)
    {
        counts.push_back({vertices.size(), faces.size()});
        for (const Vector3d& v : vertices) append(positions, v - middle);
        const bool is_wide = vertices.size() > 65'536;
        for (const Triangle& t : faces)
            for (const std::uint32_t v : t)
                if (is_wide)
                    wide.push_back(v);
                else
                    narrow.push_back(std::uint16_t(v));
    }
};

/// @param most  limit on the triangles of all meshes; larger meshes are simplified first
PageMeshes meshes_of(const PartList& list, std::uint64_t most)
{
    std::uint64_t cap = ~0ull, kept = 0;
    std::vector<std::uint64_t> sizes;
    for (const auto& geometry : list.meshes)
        if (geometry) sizes.push_back(std::get<Mesh>(geometry->data).triangles.size());
    std::ranges::sort(sizes);
    for (std::size_t k = 0; k < sizes.size() && cap == ~0ull; kept += sizes[k++])
        if (kept + sizes[k] * (sizes.size() - k) > most)
            cap = std::max<std::uint64_t>((most - kept) / (sizes.size() - k), 12);
    PageMeshes page;
    for (std::uint32_t m = 0; m < list.meshes.size(); ++m) {
        if (!list.meshes[m]) {
            page.counts.push_back({0, 0});
            continue;
        }
        const Mesh& mesh = mesh_of(list, m);
        if (mesh.triangles.size() <= cap) {
            page.add(mesh.bounds.centre(), mesh.vertices, mesh.triangles);
            continue;
        }
        Scene scene;
        const GeometryId id = scene.add("mesh", list.meshes[m]->data);
        std::vector<std::uint32_t> source;
        const PageModel model = make_page_model(scene, id, cap, source);
        const PageModel::Mesh& coarse = model.meshes[0];
        std::vector<Vector3d> vertices;
        for (const std::uint32_t vertex : source) vertices.push_back(mesh.vertices[vertex]);
        std::vector<Triangle> faces(coarse.triangles());
        for (std::size_t k = 0; k < coarse.indices.size(); ++k) faces[k / 3][k % 3] = coarse.indices[k];
        page.add(mesh.bounds.centre(), vertices, faces);
        ++page.simplified, page.triangles += mesh.triangles.size(), page.shown_triangles += faces.size();
    }
    return page;
}

/// The red lines and faces of a clash, relative to Clash::where.
struct Shown {
    ClashView view;
    std::vector<float> triangles, lines;   ///< 9 and 6 numbers each
    bool whole_a = false, whole_b = false; ///< all of this part is common

    std::size_t bytes() const { return 4 * (triangles.size() + lines.size()); }
};

Shown shown_of(const ClashReport& r, const Clash& clash)
{
    const std::vector<Contact> contacts = contacts_of(r.found, clash);
    ClashScenery scenery = scenery_of(r.parts, clash, contacts);
    Shown shown;
    shown.view = scenery.view;
    for (std::size_t k = 0; k < scenery.lines.size(); k += 1 + scenery.lines.size() / most_of_clash)
        for (const Vector3d& end : scenery.lines[k]) append(shown.lines, end - clash.where);
    const auto size = [](const Aabb& box) { return box.diagonal(); };
    shown.whole_a = clash.kind == ClashKind::duplicate ||
                    (clash.kind == ClashKind::enclosed && size(scenery.box_a) <= size(scenery.box_b));
    shown.whole_b = clash.kind == ClashKind::enclosed && !shown.whole_a;
    if (!clash.has_ball || contacts.empty()) return shown;
    const auto placed = [&](std::uint32_t part) {
        Eigen::Isometry3d pose = r.parts.parts[part].pose;
        pose.translation() -= clash.where;
        return PlacedMesh{mesh_of(r.parts, r.parts.parts[part].mesh), pose};
    };
    std::vector<Contact> moved = contacts;
    for (Contact& contact : moved)
        for (Vector3d& end : contact.ends) end -= clash.where;
    for (const auto& triangle :
         overlap_surface(placed(clash.a), placed(clash.b), moved, clash.ball_lower(), most_of_clash))
        for (const Vector3d& corner : triangle) append(shown.triangles, corner);
    return shown;
}

class Writer {
public:
    Writer(const ClashReport& report, std::size_t most_bytes)
        : r_(report), most_bytes_(most_bytes), origin_(report.parts.bounds.centre())
    {
    }

    json header, rows = json::array(), notes = json::array();
    PageBlock parts, red;
    PageMeshes meshes;

    void make(std::size_t fixed)
    {
        add_parts();
        const std::size_t least = fixed + script_json(header).size() + encoded_size(parts.bytes().size()) +
                                  encoded_size(400 * r_.parts.meshes.size()) + 100'000;
        if (least > most_bytes_)
            throw Error(ErrorKind::usage,
                        fmt::format("--view-limit: a page of {} parts needs at least {}; set --view-limit to {} or "
                                    "more",
                                    grouped(r_.parts.parts.size()), megabytes(least), (least + 999'999) / 1'000'000));
        std::size_t room = most_bytes_ - least;
        meshes = meshes_of(r_.parts, std::min(room / 10 * 7 * 3 / 4 / bytes_of_triangle, most_drawn_triangles));
        room -= std::min(room,
                         encoded_size(4 * meshes.positions.size() + 4 * meshes.wide.size() + 2 * meshes.narrow.size()));
        add_clashes(room);
        add_notes();
        header["meshes"] = std::move(meshes.counts);
        header["clashes"] = std::move(rows), header["notes"] = notes;
    }

    std::string left_out() const
    {
        std::string text;
        for (const json& note : notes) text += "; " + note.get<std::string>();
        return text;
    }

private:
    void add_parts()
    {
        const PartList& list = r_.parts;
        std::vector<double> positions;
        std::vector<float> turns;
        std::vector<std::uint32_t> numbers;
        json labels = json::array(), names = json::array(), details = json::array();
        for (const Part& part : list.parts) {
            const Vector3d middle =
                list.meshes[part.mesh] ? mesh_of(list, part.mesh).bounds.centre() : Vector3d::Zero();
            const Vector3d at = part.pose * middle - origin_;
            positions.insert(positions.end(), at.data(), at.data() + 3);
            const Eigen::Quaterniond q(part.pose.linear());
            for (const double x : {q.x(), q.y(), q.z(), q.w()}) turns.push_back(float(x));
            numbers.push_back(part.mesh);
            labels.push_back(printable(part.label));
            json known = json::object();
            const auto add = [&](const char* name, const std::string& value) {
                if (!value.empty()) known[name] = printable(value);
            };
            add("class", class_text(part.details.part_class)), add("type", part.details.type);
            add("storey", part.details.storey), add("discipline", part.details.discipline);
            add("GlobalId", part.details.guid);
            details.push_back(std::move(known));
        }
        parts.add(positions), parts.add(turns), parts.add(numbers);
        header = {{"title", title()},
                  {"unit", r_.unit.name},
                  {"metres", 1e-3 * r_.unit.millimetres},
                  {"origin", numbers_of(origin_)},
                  {"labels", std::move(labels)},
                  {"details", std::move(details)}};
    }

    std::string title() const
    {
        const auto& files = r_.rules.inputs.empty() ? r_.parts.files : r_.rules.inputs;
        const std::string first = files.empty() ? "" : std::filesystem::path(files[0]).filename().string();
        return printable("Clashes of " +
                         (files.size() > 1 ? fmt::format("{} and {} more", first, files.size() - 1) : first));
    }

    json row_of(const Clash& c) const
    {
        json row = {{"id", c.id},
                    {"a", c.a},
                    {"b", c.b},
                    {"kind", name_of(c.kind)},
                    {"status", printable(std::string(c.status_text()))},
                    {"size", measure_text(r_, c)},
                    {"where", r_.position(c.where)},
                    {"at", numbers_of(c.where - origin_)}};
        if (!c.comment.empty()) row["comment"] = printable(c.comment);
        if (c.has_ball && c.ball.radius_lower > 0)
            row["ball"] = {numbers_of(c.ball.centre - c.where), c.ball.radius_lower};
        return row;
    }

    /// Clashes in the order of the report, the worst first, in at most half of the room; their common parts in the
    /// rest.
    void add_clashes(std::size_t room)
    {
        const std::vector<std::size_t> open = r_.open_clashes();
        std::size_t listed = 0, used = 0;
        for (; listed < open.size(); ++listed) {
            const std::size_t size = script_json(row_of(r_.found.list[open[listed]])).size() + 200;
            if (used + size > room / 2) break;
            used += size;
        }
        constexpr std::size_t batch = 64;
        std::vector<float> columns;
        for (std::size_t begin = 0; begin < listed; begin += batch) {
            const std::size_t count = std::min(batch, listed - begin);
            std::vector<Shown> shown(count);
            parallel_chunks(count, 1, thread_count(r_.found.world->settings()),
                            [&](std::size_t from, std::size_t to, int) {
                                for (std::size_t k = from; k < to; ++k)
                                    shown[k] = shown_of(r_, r_.found.list[open[begin + k]]);
                            });
            for (std::size_t k = 0; k < count; ++k) {
                Shown& s = shown[k];
                if (encoded_size(4 * columns.size() + s.bytes()) > room - used)
                    s.triangles.clear(), s.lines.clear(), ++bare_;
                json row = row_of(r_.found.list[open[begin + k]]);
                row["view"] = {numbers_of(s.view.middle - origin_), s.view.radius, numbers_of(s.view.from)};
                row["red"] = {s.triangles.size() / 9, s.lines.size() / 6};
                if (s.whole_a || s.whole_b) row["whole"] = s.whole_a ? "a" : "b";
                rows.push_back(std::move(row));
                for (const auto* column : {&s.triangles, &s.lines})
                    columns.insert(columns.end(), column->begin(), column->end());
            }
        }
        red.add(columns);
        clashes_ = listed, of_ = open.size();
    }

    void add_notes()
    {
        if (meshes.simplified)
            notes.push_back(fmt::format("{} mesh{} shown simplified, {} of {} triangles", grouped(meshes.simplified),
                                        meshes.simplified == 1 ? " is" : "es are", grouped(meshes.shown_triangles),
                                        grouped(meshes.triangles)));
        if (clashes_ < of_)
            notes.push_back(
                fmt::format("{} of {} clashes are listed, the worst first", grouped(clashes_), grouped(of_)));
        if (bare_) notes.push_back(fmt::format("{} clashes are shown without their common part", grouped(bare_)));
        if (!notes.empty()) notes.push_back(fmt::format("--view-limit allows {}", megabytes(most_bytes_)));
    }

    const ClashReport& r_;
    std::size_t most_bytes_, clashes_ = 0, of_ = 0, bare_ = 0;
    Vector3d origin_;
};

} // namespace

std::string write_clash_view(const std::string& file, const ClashReport& report, std::size_t most_bytes)
{
    using namespace clash_page;
    const ThreeJs three = read_three_js();
    const std::array<std::string_view, 4> scripts{page::columns_js, model_js, list_js, clashes_js};
    std::size_t fixed = three.library.size() + three.controls.size() + clashes_html.size() + page::style_css.size() +
                        clashes_css.size();
    for (const std::string_view script : scripts) fixed += script.size();
    Writer page(report, most_bytes);
    page.make(fixed);

    OutputFile output(file);
    PageFile out(output, clashes_html);
    out.until("{{title}}"), out.write(xml_escaped(page.header["title"].get<std::string>()));
    out.until("{{style}}"), out.write(page::style_css), out.write(clashes_css);
    out.until("{{data}}"), out.add_json("header", page.header);
    out.add_block("parts", base64(page.parts.bytes())), out.add_block("red", base64(page.red.bytes()));
    const auto add = [&](std::string_view name, const auto& column) {
        PageBlock block;
        block.add(column);
        out.add_block(name, base64(block.bytes()));
    };
    add("positions", page.meshes.positions), add("wide", page.meshes.wide), add("narrow", page.meshes.narrow);
    out.until("{{three}}"), out.write(three.library), out.write("\n"), out.write(three.controls);
    out.until("{{script}}"), out.write("(() => {\n");
    for (const std::string_view script : scripts) out.write(script);
    out.write("})();\n"), out.finish();
    output.commit();
    std::error_code error;
    const std::size_t parts = report.parts.parts.size(), clashes = page.header["clashes"].size();
    return fmt::format("{}: {}, {} part{}, {} clash{}{}", printable(file),
                       megabytes(std::filesystem::file_size(file, error)), grouped(parts), parts == 1 ? "" : "s",
                       grouped(clashes), clashes == 1 ? "" : "es", page.left_out());
}

} // namespace oncollide::tools

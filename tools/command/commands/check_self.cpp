// oncollide check --self: the triangles of a mesh that meet each other.
#include "commands/check_self.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/files/paths.hpp>
#include <oncollide/base/text/csv_writer.hpp>
#include <oncollide/base/text/json_writer.hpp>
#include <oncollide/base/text/plain_number.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

#include "clash/parts/part_list.hpp"
#include "cli/command.hpp"
#include "cli/log.hpp"
#include "cli/outputs.hpp"
#include "cli/progress.hpp"
#include "cli/standard_output.hpp"
#include "cli/system.hpp"
#include "common/numbers.hpp"

namespace oncollide::tools {
namespace {

using TrianglesThatMeet = PairOf<std::uint32_t>;

constexpr std::size_t most_printed = 10; ///< places of a mesh

std::string counted(std::size_t count, const char* one, const char* many)
{
    return fmt::format("{} {}", count, count == 1 ? one : many);
}

/// Pairs that triangles with common vertices connect.
struct Place {
    std::size_t pairs = 0;
    TrianglesThatMeet first; ///< one of them
    Aabb box;                ///< around the common points of its triangles
};

struct CheckedMesh {
    std::string file;
    std::size_t triangles;
    std::vector<TrianglesThatMeet> pairs;
    std::vector<Place> places; ///< of the most pairs first
};

/// The mesh in a file; none: the geometry in it is of a kind that does not meet itself.
std::optional<Mesh> mesh_in(const std::string& file)
{
    const std::shared_ptr<Geometry> geometry = load_geometry(file);
    if (Mesh* mesh = std::get_if<Mesh>(&geometry->data)) return std::move(*mesh);
    if (const auto* cooked = std::get_if<std::shared_ptr<const CookedMesh>>(&geometry->data)) return (*cooked)->whole();
    return std::nullopt;
}

TrianglePoints points_of(const Mesh& mesh, std::uint32_t triangle)
{
    const auto& [a, b, c] = mesh.triangles[triangle];
    return {mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]};
}

CommonSegment segment_of(const Mesh& mesh, TrianglesThatMeet pair)
{
    return common_segment(points_of(mesh, pair.a), points_of(mesh, pair.b));
}

std::vector<Place> places_of(const Mesh& mesh, const std::vector<TrianglesThatMeet>& pairs)
{
    std::vector<std::uint32_t> above(mesh.vertices.size()); // a forest of vertices, one tree for each place
    std::iota(above.begin(), above.end(), 0u);
    const auto root = [&](std::uint32_t v) {
        while (above[v] != v) v = above[v] = above[above[v]];
        return v;
    };
    for (const TrianglesThatMeet& pair : pairs)
        for (const std::uint32_t triangle : {pair.a, pair.b})
            for (const std::uint32_t v : mesh.triangles[triangle]) above[root(v)] = root(mesh.triangles[pair.a][0]);
    std::map<std::uint32_t, Place> by_root;
    for (const TrianglesThatMeet& pair : pairs) {
        Place& place = by_root[root(mesh.triangles[pair.a][0])];
        if (place.pairs++ == 0) place.first = pair;
        for (const Eigen::Vector3d& end : segment_of(mesh, pair).ends) place.box.add(end);
    }
    std::vector<Place> places;
    for (const auto& [vertex, place] : by_root) places.push_back(place);
    std::ranges::sort(places, [](const Place& a, const Place& b) {
        return a.pairs != b.pairs ? a.pairs > b.pairs : a.first < b.first;
    });
    return places;
}

std::string text_of(const Eigen::Vector3d& v)
{
    return fmt::format("({}, {}, {})", plain_number(v.x(), 6), plain_number(v.y(), 6), plain_number(v.z(), 6));
}

void print(const CheckedMesh& mesh, bool on_stderr)
{
    const bool meets = !mesh.pairs.empty(), colours = on_stderr ? stderr_is_terminal() : stdout_is_terminal();
    std::string text = tinted(meets ? Tint::red : Tint::green, meets ? "colliding" : "separate", colours);
    const std::string name = printable(mesh.file);
    if (meets)
        text +=
            fmt::format(": '{}' meets itself: {} of triangles, in {}.\n", name,
                        counted(mesh.pairs.size(), "pair", "pairs"), counted(mesh.places.size(), "place", "places"));
    else
        text += fmt::format(": '{}' does not meet itself.\n", name);
    for (std::size_t i = 0; i < std::min(mesh.places.size(), most_printed); ++i) {
        const Place& place = mesh.places[i];
        const Eigen::Vector3d size = place.box.max - place.box.min;
        text +=
            fmt::format("  {} around {}, in a box of {} x {} x {} m, such as triangles {} and {}\n",
                        counted(place.pairs, "pair", "pairs"), text_of(place.box.centre()), plain_measure(size.x(), 3),
                        plain_measure(size.y(), 3), plain_measure(size.z(), 3), place.first.a, place.first.b);
    }
    if (mesh.places.size() > most_printed)
        text += fmt::format("  and {} more, with fewer pairs\n",
                            counted(mesh.places.size() - most_printed, "place", "places"));
    write_to_stdout(text, on_stderr);
}

void write_json(const std::vector<CheckedMesh>& meshes, const std::string& file)
{
    OutputFile out(file);
    JsonWriter json(out);
    const auto point = [&](const Eigen::Vector3d& p) { json.array(p.x(), p.y(), p.z()); };
    json.begin_object(), json.key("meshes"), json.begin_array();
    for (const CheckedMesh& mesh : meshes) {
        json.line(1), json.begin_object();
        json.members("file", mesh.file, "triangles", mesh.triangles, "pairs", mesh.pairs.size());
        json.key("places"), json.begin_array();
        for (const Place& place : mesh.places) {
            json.line(2), json.begin_object();
            json.members(
                "pairs", place.pairs, "triangles", [&] { json.array(place.first.a, place.first.b); }, "min",
                [&] { point(place.box.min); }, "max", [&] { point(place.box.max); });
            json.end_object();
        }
        json.end_array(), json.end_object();
    }
    json.line(), json.end_array(), json.end_object();
    out.write("\n");
    out.commit();
}

/// One row per pair of triangles that meet, with the columns of --contacts for two bodies.
void write_contacts(const std::vector<TrianglesThatMeet>& pairs, const Mesh& mesh, OutputFile& file)
{
    CsvWriter csv(file, "part_a,part_b,kind,x0,y0,z0,x1,y1,z1,normal_a_x,normal_a_y,normal_a_z,normal_b_x,normal_b_y,"
                        "normal_b_z");
    for (const TrianglesThatMeet& pair : pairs) {
        const CommonSegment common = segment_of(mesh, pair);
        const TrianglePoints a = points_of(mesh, pair.a), b = points_of(mesh, pair.b);
        csv.add(pair.a, pair.b,
                name_of(common.kind == TriangleContact::crossing ? ContactKind::crossing : ContactKind::touching));
        for (const Eigen::Vector3d& v :
             {common.ends[0], common.ends[1], unit_normal(a[0], a[1], a[2]), unit_normal(b[0], b[1], b[2])})
            for (const double x : v) csv.add(Digits{x, 17});
        csv.end_row();
    }
    file.commit();
}

} // namespace

int check_self(const SelfCheckOptions& options)
{
    std::vector<std::string> warnings;
    const std::vector<std::string> files =
        is_folder(options.input) ? files_of({options.input}, &warnings) : std::vector{options.input};
    if (!options.contacts.empty() && files.size() > 1)
        usage(fmt::format("--contacts: lists the triangles of one mesh, and {} has {}", options.input, files.size()));
    check_files({{"--json", options.json}, {"--contacts", options.contacts}}, files);
    std::optional<OutputFile> contacts;
    if (!options.contacts.empty()) contacts.emplace(options.contacts);
    if (!options.quiet)
        for (const std::string& warning : warnings) log(LogLevel::warning, warning);
    show_reading(options.quiet);
    const bool taken = options.json == "-" || options.contacts == "-";
    std::vector<CheckedMesh> checked;
    std::size_t meeting = 0;
    for (const std::string& file : files) {
        std::optional<Mesh> mesh = mesh_in(file);
        CheckedMesh& result = checked.emplace_back(CheckedMesh{file, mesh ? mesh->triangles.size() : 0, {}, {}});
        if (mesh) {
            World world({.threads = 0});
            const ModelId model = world.models().add(std::move(*mesh));
            const Mesh& kept = std::get<Mesh>(world.models().geometry(model).data);
            result.pairs = world.models().self_contacts(model);
            result.places = places_of(kept, result.pairs);
            if (contacts) write_contacts(result.pairs, kept, *contacts);
        } else if (contacts) {
            write_contacts({}, {}, *contacts);
        }
        meeting += !result.pairs.empty();
        if (!options.quiet) print(result, taken);
    }
    if (!options.quiet && files.size() > 1)
        write_to_stdout(fmt::format("{} of {} meet themselves.\n", meeting, counted(files.size(), "mesh", "meshes")),
                        taken);
    if (!options.json.empty()) write_json(checked, options.json);
    return meeting ? 1 : 0;
}

} // namespace oncollide::tools

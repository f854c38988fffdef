// oncollide check --self: the triangles of a mesh that meet each other.
#include "self/check_self.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/files/paths.hpp>
#include <oncollide/base/text/csv_writer.hpp>
#include <oncollide/base/text/json_writer.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

#include "clash/parts/file_list.hpp"
#include "cli/command.hpp"
#include "cli/log.hpp"
#include "cli/outputs.hpp"
#include "cli/progress.hpp"
#include "cli/standard_output.hpp"
#include "cli/system.hpp"
#include "self/self_pictures.hpp"
#include "view/view_page.hpp"

namespace oncollide::tools {
namespace {

constexpr std::size_t most_printed = 10; ///< places of a mesh

std::string counted(std::size_t count, const char* one, const char* many)
{
    return fmt::format("{} {}", count, count == 1 ? one : many);
}

struct CheckedMesh {
    std::string file;
    Aabb bounds;
    std::size_t triangles = 0;
    std::vector<TrianglesThatMeet> pairs{};
    std::vector<SelfPlace> places{};
};

/// The mesh in a file; none: the geometry in it is of a kind that does not meet itself.
std::optional<Mesh> mesh_in(const std::string& file)
{
    const std::shared_ptr<Geometry> geometry = load_geometry(file);
    if (Mesh* mesh = std::get_if<Mesh>(&geometry->data)) return std::move(*mesh);
    if (const auto* cooked = std::get_if<std::shared_ptr<const CookedMesh>>(&geometry->data)) return (*cooked)->whole();
    return std::nullopt;
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
    for (std::size_t i = 0; i < std::min(mesh.places.size(), most_printed); ++i)
        text += fmt::format("  {}\n", place_text(mesh.places[i], mesh.bounds, "m"));
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
        for (const SelfPlace& place : mesh.places) {
            json.line(2), json.begin_object();
            json.members(
                "pairs", place.pairs.size(), "triangles", [&] { json.array(place.pairs[0].a, place.pairs[0].b); },
                "min", [&] { point(place.box.min); }, "max", [&] { point(place.box.max); });
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
        const TrianglePoints a = corners_of(mesh, pair.a), b = corners_of(mesh, pair.b);
        csv.add(pair.a, pair.b,
                name_of(common.kind == TriangleContact::crossing ? ContactKind::crossing : ContactKind::touching));
        for (const Eigen::Vector3d& v :
             {common.ends[0], common.ends[1], unit_normal(a[0], a[1], a[2]), unit_normal(b[0], b[1], b[2])})
            for (const double x : v) csv.add(Digits{x, 17});
        csv.end_row();
    }
    file.commit();
}

void check_options(const SelfCheckOptions& options, const std::vector<std::string>& files)
{
    const std::pair<const char*, std::string> of_one_mesh[] = {
        {"--contacts", options.contacts}, {"--picture", options.picture}, {"--view", options.view}};
    for (const auto& [option, file] : of_one_mesh)
        if (!file.empty() && files.size() > 1)
            usage(fmt::format("{}: shows one mesh, and {} has {}", option, options.input, files.size()));
    if (!options.picture.empty() && options.picture != "-") check_extension("--picture", options.picture, {".png"});
    check_files({{"--json", options.json}, of_one_mesh[0], of_one_mesh[1], of_one_mesh[2]}, files);
    check_view("--view", options.view, options.view_limit, {}, files);
}

} // namespace

int check_self(const SelfCheckOptions& options)
{
    std::vector<std::string> warnings;
    const std::vector<std::string> files =
        is_folder(options.input) ? files_of({options.input}, &warnings) : std::vector{options.input};
    check_options(options, files);
    std::optional<OutputFile> contacts;
    if (!options.contacts.empty()) contacts.emplace(options.contacts);
    if (!options.quiet)
        for (const std::string& warning : warnings) log(LogLevel::warning, warning);
    show_reading(options.quiet);
    const bool taken = options.json == "-" || options.contacts == "-" || options.picture == "-";
    std::vector<CheckedMesh> checked;
    std::size_t meeting = 0;
    for (const std::string& file : files) {
        check_format(file);
        std::optional<Mesh> read = mesh_in(file);
        CheckedMesh& result = checked.emplace_back(CheckedMesh{file, {}});
        if (!read && (!options.picture.empty() || !options.view.empty()))
            usage(fmt::format("--picture, --view: show a mesh, and '{}' is none", file));
        World world({.threads = 0});
        const Mesh none;
        const Mesh* kept = &none; // by the World
        if (read) {
            const ModelId model = world.models().add(std::move(*read));
            result.pairs = world.models().self_contacts(model);
            kept = &std::get<Mesh>(world.models().geometry(model).data);
        }
        const Mesh& mesh = *kept;
        result.bounds = mesh.bounds, result.triangles = mesh.triangles.size();
        result.places = places_of(mesh, result.pairs);
        meeting += !result.pairs.empty();
        if (!options.quiet) print(result, taken);
        write_all({[&] {
                       if (contacts) write_contacts(result.pairs, mesh, *contacts);
                   },
                   [&] {
                       if (!options.picture.empty()) save_png(draw_self(mesh, result.places), options.picture);
                   },
                   [&] {
                       if (options.view.empty()) return;
                       const std::string summary = write_self_view(options.view, file, mesh, result.places,
                                                                   std::size_t(options.view_limit) * 1'000'000);
                       if (!options.quiet) log(LogLevel::note, summary);
                   }});
    }
    if (!options.quiet && files.size() > 1)
        write_to_stdout(fmt::format("{} of {} meet themselves.\n", meeting, counted(files.size(), "mesh", "meshes")),
                        taken);
    if (!options.json.empty()) write_json(checked, options.json);
    return meeting ? 1 : 0;
}

} // namespace oncollide::tools

// oncollide spheres: the spheres of a mesh's tree, and how well they stand for it.
#include "command.hpp"
#include "grown_tree.hpp"
#include "options.hpp"
#include "sphere_quality.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <oncollide/scenes/error.hpp>
#include <oncollide/scenes/mesh_file.hpp>
#include <oncollide/scenes/output_file.hpp>

namespace oncollide::tools {
namespace {

struct SpheresOptions {
    std::string mesh, csv, json, spheres = "paper";
    std::optional<int> depth;
    std::optional<double> max_error;
    int directions = QualityOptions{}.directions, threads = 1;
    bool quiet = false;
};

/// One level by one kind of bound.
struct Row {
    int level;
    const char* kind; ///< plain: around the cell; ball and disc: the tight one, without and with its slab
    double radius;    ///< largest
    double certified; ///< no point of a plain sphere is farther from the surface
    SphereQuality quality;
};

struct Judged {
    const Mesh& mesh;
    bool closed;
    double side; ///< longest of the bounds
    std::vector<Row> rows;
};

void add_row(Judged& judged, const TriangleTree& triangles, const GrownTree& tree, int level, const char* kind,
             const std::vector<TreeSphere>& spheres, const SpheresOptions& options)
{
    double radius = 0;
    for (const TreeSphere& s : spheres) radius = std::max(radius, s.radius);
    judged.rows.push_back({level, kind, radius, tree.certified_reach(level),
                           judge_spheres(judged.mesh, triangles, spheres,
                                         {.closed = judged.closed,
                                          .directions = options.directions,
                                          .threads = options.threads ? options.threads : hardware_threads()})});
}

void judge(Judged& judged, const GrownTree& tree, const SpheresOptions& options)
{
    const TriangleTree triangles(judged.mesh);
    for (int level = 0; level <= tree.depth(); ++level) {
        add_row(judged, triangles, tree, level, "plain", tree.spheres(level, Spheres::paper), options);
        if (level == 0) continue; // the root has no tight bound
        const std::vector<TreeSphere> tight = tree.spheres(level, Spheres::tight);
        std::vector<TreeSphere> balls = tight;
        for (TreeSphere& s : balls) s.half = s.radius;
        add_row(judged, triangles, tree, level, "ball", balls, options);
        add_row(judged, triangles, tree, level, "disc", tight, options);
    }
}

/// As much of the surface as is in no sphere; "none" only when nothing is.
std::string uncovered(const SphereQuality& q)
{
    if (q.open_triangles == 0 && q.outside == 0) return "none";
    return fmt::format("{} of triangles, {} of {} points", q.open_triangles, q.outside, q.points);
}

void print_table(const Judged& judged, const GrownTree& tree, const SpheresOptions& options, std::FILE* to)
{
    fmt::print(
        to,
        "mesh       {}: {} triangles, {}; longest side {:.6g} m\n"
        "tree       depth {}; {} cells stored, {} bytes\n"
        "over-reach worst, mean, certified: the farthest that a point of a sphere is from the surface, m\n"
        "           worst out, mean out: of its points outside a closed mesh, in thousandths of the longest side\n"
        "volume     of all spheres, over that of the root cell\n\n",
        options.mesh, judged.mesh.triangles.size(), judged.closed ? "closed" : "open", judged.side, tree.depth(),
        tree.tree().size(), tree.bytes());
    const RootCell& root = tree.tree().root();
    const double cell = 8.0 * root.half[0] * root.half[1] * root.half[2];
    fmt::print(to, "{:>5}  {:<6}{:>9}{:>12}{:>12}{:>12}{:>12}{:>10}{:>10}{:>9}  {}\n", "level", "kind", "spheres",
               "radius", "worst", "mean", "certified", "worst out", "mean out", "volume", "uncovered");
    const auto out = [&](double length) {
        return judged.closed ? fmt::format("{:.2f}", 1000 * length / judged.side) : std::string("-");
    };
    for (const Row& row : judged.rows) {
        const SphereQuality& q = row.quality;
        fmt::print(to, "{:>5}  {:<6}{:>9}{:>12.4g}{:>12.4g}{:>12.4g}{:>12.4g}{:>10}{:>10}{:>9.3f}  {}\n", row.level,
                   row.kind, q.spheres, row.radius, q.worst, q.mean, row.certified, out(q.worst_beyond),
                   out(q.mean_beyond), q.volume / cell, uncovered(q));
    }
}

void write_csv(const std::string& path, const GrownTree& tree, Spheres kind)
{
    OutputFile file(path);
    file.print("level,cell,x,y,z,radius,normal_x,normal_y,normal_z,half_thickness\n");
    for (int level = 0; level <= tree.depth(); ++level) {
        const std::vector<TreeSphere> spheres = tree.spheres(level, kind);
        for (std::size_t i = 0; i < spheres.size(); ++i) {
            const TreeSphere& s = spheres[i];
            file.print("{},{},{},{},{},{},{},{},{},{}\n", level, tree.level(level)[i], s.centre.x(), s.centre.y(),
                       s.centre.z(), s.radius, s.normal.x(), s.normal.y(), s.normal.z(), s.half);
        }
    }
    file.commit();
}

nlohmann::json as_json(const Row& row, const Judged& judged)
{
    const SphereQuality& q = row.quality;
    nlohmann::json object = {{"level", row.level},
                             {"kind", row.kind},
                             {"spheres", q.spheres},
                             {"radius", row.radius},
                             {"certified", row.certified},
                             {"over_reach", {{"worst", q.worst}, {"mean", q.mean}}},
                             {"volume", q.volume},
                             {"open_triangles", q.open_triangles},
                             {"uncovered_area", q.uncovered},
                             {"points", q.points},
                             {"points_outside", q.outside}};
    if (judged.closed) object["over_reach_outside"] = {{"worst", q.worst_beyond}, {"mean", q.mean_beyond}};
    return object;
}

void write_json(const std::string& path, const SpheresOptions& options, const Judged& judged, const GrownTree& tree,
                Spheres kind)
{
    const nlohmann::json header = {{"version", version},      {"mesh", options.mesh},
                                   {"depth", tree.depth()},   {"spheres", name_of(kind)},
                                   {"closed", judged.closed}, {"longest_side", judged.side}};
    OutputFile file(path);
    file.print("{{\"header\": {}, \"levels\": [", header.dump());
    for (const Row& row : judged.rows)
        file.print("{}\n  {}", &row == &judged.rows.front() ? "" : ",", as_json(row, judged).dump());
    file.print("\n], \"columns\": [\"level\", \"x\", \"y\", \"z\", \"radius\", \"normal_x\", \"normal_y\", "
               "\"normal_z\", \"half_thickness\"], \"spheres\": [");
    const char* comma = "";
    for (int level = 0; level <= tree.depth(); ++level)
        for (const TreeSphere& s : tree.spheres(level, kind)) {
            file.print("{}\n  [{}, {}, {}, {}, {}, {}, {}, {}, {}]", comma, level, s.centre.x(), s.centre.y(),
                       s.centre.z(), s.radius, s.normal.x(), s.normal.y(), s.normal.z(), s.half);
            comma = ",";
        }
    file.print("\n]}}\n");
    file.commit();
}

int spheres(const SpheresOptions& options)
{
    const Settings settings{.depth = options.depth, .max_error = options.max_error, .threads = options.threads};
    check(settings);
    const Spheres kind = spheres_from_name(options.spheres);
    if (kind == Spheres::automatic) throw Error(ErrorKind::usage, "--spheres auto: must be paper or tight here");
    if (options.directions < 1 || options.directions > 100'000)
        throw Error(ErrorKind::usage, fmt::format("--directions {}: must be from 1 to 100000", options.directions));
    OutputOptions outputs;
    outputs.csv = options.csv, outputs.json = options.json;
    check_outputs(outputs, options.mesh);

    Scene scene;
    const GeometryId geometry = scene.add(options.mesh, load_mesh(options.mesh));
    const Mesh& mesh = std::get<Mesh>(scene.geometries[index(geometry)].data);
    const GrownTree tree(scene, settings);
    Judged judged{mesh, is_closed(mesh), (mesh.bounds.max - mesh.bounds.min).maxCoeff(), {}};
    judge(judged, tree, options);
    const bool stdout_taken = options.csv == "-" || options.json == "-";
    if (!options.quiet) print_table(judged, tree, options, stdout_taken ? stderr : stdout);
    if (!options.csv.empty()) write_csv(options.csv, tree, kind);
    if (!options.json.empty()) write_json(options.json, options, judged, tree, kind);
    // What the judge measures with is rounded where the mesh lies.
    const double rounding = 1e-14 * mesh.bounds.min.cwiseAbs().cwiseMax(mesh.bounds.max.cwiseAbs()).maxCoeff();
    for (const Row& row : judged.rows)
        if (row.quality.open_triangles || row.quality.outside || row.quality.worst > row.certified + rounding)
            throw Error(ErrorKind::internal,
                        fmt::format("{}: level {}, {}: the spheres leave a part of the surface out, or reach {} m from "
                                    "it, where {} m are certified",
                                    options.mesh, row.level, row.kind, row.quality.worst, row.certified));
    return 0;
}

} // namespace

void add_spheres(CLI::App& app, Command& command)
{
    CLI::App* sub = app.add_subcommand("spheres", "The spheres of a mesh's tree, and how well they stand for it");
    auto options = std::make_shared<SpheresOptions>();
    sub->add_option("mesh", options->mesh, "mesh (OBJ, STL, PLY, OFF, glTF)")->required()->type_name("MESH");
    sub->add_option("--depth", options->depth, "depth of the tree, 1 to 16 (default 6)")->type_name("D");
    sub->add_option("--max-error", options->max_error,
                    "instead of --depth: largest error in metres of the answer 'within' for two such trees")
        ->type_name("M");
    sub->add_option("--spheres", options->spheres,
                    "which to write: paper: around the cells (default); tight: around the surface in them, with a slab")
        ->type_name("NAME");
    sub->add_option("--csv", options->csv, "write the spheres of all levels, one a row; '-' is standard output")
        ->type_name("FILE");
    sub->add_option("--json", options->json, "write the table and the spheres; '-' is standard output")
        ->type_name("FILE");
    sub->add_option("--directions", options->directions,
                    fmt::format("points of each sphere that are looked at (default {})", options->directions))
        ->type_name("N");
    sub->add_option("--threads", options->threads, "threads; 0: all. Never changes the result (default 1)")
        ->type_name("N");
    sub->add_flag("--quiet", options->quiet, "print nothing but errors");
    sub->footer("Exit code 70: a part of the surface is in no sphere, or a sphere reaches farther than certified.\n"
                "Examples:\n"
                "  oncollide spheres bunny.obj --depth 5\n"
                "  oncollide spheres part.stl --max-error 0.002 --spheres tight --csv spheres.csv");
    sub->callback([options, &command] { command = [options] { return spheres(*options); }; });
}

} // namespace oncollide::tools

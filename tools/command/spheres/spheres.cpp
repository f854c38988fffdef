// oncollide spheres: the spheres and OBBs of a mesh's trees, and how closely they fit the mesh.
#include "cli/command.hpp"
#include "cli/options.hpp"
#include "cli/standard_output.hpp"
#include "robot/robot_spheres.hpp"
#include "trees/box_levels.hpp"
#include "trees/grown_tree.hpp"
#include "trees/level_quality.hpp"

#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/text/csv_writer.hpp>
#include <oncollide/base/text/json_writer.hpp>
#include <oncollide/base/text/plain_number.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide::tools {
namespace {

struct SpheresOptions {
    std::string mesh, csv, json, levels, bounding_volume = "sphere";
    std::optional<int> depth;
    std::optional<double> max_error;
    int directions = QualityOptions{}.directions, threads = 1;
    bool quiet = false;
    RobotSpheresOptions robot; ///< further options of robots
};

/// A level of one of the trees.
struct Row {
    BoundingVolume kind;
    int level;
    double certified;           ///< largest distance of a volume's points from the surface
    std::vector<CellKey> cells; ///< only for spheres
    std::vector<CoveringVolume> volumes;
    LevelQuality quality;

    const char* name() const { return kind == BoundingVolume::sphere ? "sphere" : "box"; }
    double radius() const ///< largest
    {
        double radius = 0;
        for (const CoveringVolume& v : volumes) radius = std::max(radius, v.radius());
        return radius;
    }
};

struct Judged {
    const Mesh& mesh;
    bool closed;
    double side; ///< longest side of the bounds
    std::vector<Row> rows;
};

/// Measures the spheres of all levels, then the OBBs. Each OBB contains a part of the surface, so its points are at
/// most twice its radius from the surface.
void judge(Judged& judged, const GrownTree& tree, ObbTree& boxes, const SpheresOptions& options)
{
    for (int level = 0; level <= tree.depth(); ++level)
        judged.rows.push_back(
            {BoundingVolume::sphere, level, tree.certified_reach(level), tree.level(level), tree.spheres(level), {}});
    int level = 0;
    for (std::vector<CoveringVolume>& volumes : box_levels(boxes)) {
        Row& row = judged.rows.emplace_back(Row{BoundingVolume::obb, level++, 0, {}, std::move(volumes), {}});
        row.certified = 2 * row.radius();
    }
    const SurfaceIndex index(judged.mesh);
    for (Row& row : judged.rows)
        row.quality = judge_level(
            judged.mesh, index, row.volumes,
            {.closed = judged.closed, .directions = options.directions, .threads = threads_of(options.threads)});
}

/// Returns how much of the surface is in no volume; "none" only if all of it is covered.
std::string uncovered(const LevelQuality& q)
{
    if (q.open_triangles == 0 && q.outside == 0) return "none";
    return fmt::format("{} of triangles, {} of {} points", q.open_triangles, q.outside, q.points);
}

double volume_of(const RootCell& root)
{
    return 8.0 * root.half[0] * root.half[1] * root.half[2];
}

void print_table(const Judged& judged, const GrownTree& tree, const ObbTree& boxes, const SpheresOptions& options,
                 bool stdout_taken)
{
    std::string text = fmt::format(
        "mesh       {}: {} triangles, {}; longest side {} m\n"
        "spheres    depth {}; {} cells stored, {} bytes\n"
        "boxes      {} nodes, {} bytes; every triangle has its own box on the last level\n"
        "over-reach worst, mean, certified: largest distance of a sphere's or box's points from the surface, m\n"
        "           worst out, mean out: only points outside a closed mesh, in thousandths of the longest side\n"
        "volume     sum of all spheres or boxes, relative to the root cell\n",
        printable(options.mesh), judged.mesh.triangles.size(), judged.closed ? "closed" : "open",
        plain_measure(judged.side, 6), tree.depth(), tree.tree().size(), tree.bytes(), boxes.nodes(), boxes.bytes());
    const double cell = volume_of(tree.tree().root());
    const auto out = [&](double length) {
        return judged.closed ? fmt::format("{:.2f}", 1000 * length / judged.side) : std::string("-");
    };
    for (const Row& row : judged.rows) {
        if (row.level == 0)
            text += fmt::format("\n{:>5}  {:<6}{:>9}{:>12}{:>12}{:>12}{:>12}{:>10}{:>10}{:>9}  {}\n", "level", "kind",
                                "count", "radius", "worst", "mean", "certified", "worst out", "mean out", "volume",
                                "uncovered");
        const LevelQuality& q = row.quality;
        text +=
            fmt::format("{:>5}  {:<6}{:>9}{:>12}{:>12}{:>12}{:>12}{:>10}{:>10}{:>9.4f}  {}\n", row.level, row.name(),
                        row.volumes.size(), plain_measure(row.radius(), 4), plain_measure(q.worst.either, 4),
                        plain_measure(q.mean.either, 4), plain_measure(row.certified, 4), out(q.worst.beyond),
                        out(q.mean.beyond), q.volume / cell, uncovered(q));
    }
    write_to_stdout(text, stdout_taken);
}

std::vector<std::string> columns(BoundingVolume kind, bool closed)
{
    std::vector<std::string> names;
    if (kind == BoundingVolume::sphere)
        names = {"level", "cell", "x", "y", "z", "radius"};
    else
        names = {"level", "x",   "y",   "z",   "half_u", "half_v", "half_w", "u_x",
                 "u_y",   "u_z", "v_x", "v_y", "v_z",    "w_x",    "w_y",    "w_z"};
    names.push_back("over_reach");
    if (closed) names.push_back("over_reach_outside");
    return names;
}

/// Adds the values of the columns.
void add_numbers(CsvWriter& csv, const Row& row, std::size_t i, bool closed)
{
    const CoveringVolume& v = row.volumes[i];
    const auto add = [&](const double* values, int count) {
        for (int k = 0; k < count; ++k) csv.add(values[k]);
    };
    csv.add(row.level);
    if (row.kind == BoundingVolume::sphere) csv.add(row.cells[i]);
    add(v.centre.data(), 3);
    add(v.half.data(), v.ball ? 1 : 3);
    if (!v.ball) add(v.axes.data(), 9); // writes column after column
    const Reach& reach = row.quality.reaches[i];
    add(&reach.either, 1);
    if (closed) add(&reach.beyond, 1);
}

void write_csv(const std::string& path, const Judged& judged, BoundingVolume kind)
{
    CsvFile csv(path, fmt::format("{}", fmt::join(columns(kind, judged.closed), ",")));
    for (const Row& row : judged.rows)
        for (std::size_t i = 0; row.kind == kind && i < row.volumes.size(); ++i)
            add_numbers(csv.rows(), row, i, judged.closed), csv.rows().end_row();
    csv.commit();
}

/// The tables, one row per level; the last column is the size of the whole tree in bytes.
void write_levels(const std::string& path, const Judged& judged, const GrownTree& tree, const ObbTree& boxes)
{
    const double cell = volume_of(tree.tree().root());
    CsvFile csv(path, "kind,level,count,triangles,longest_side,radius,worst,mean,certified,worst_outside,mean_outside,"
                      "volume,open_triangles,points,points_outside,tree_bytes");
    const auto if_closed = [&](double x) { return judged.closed ? std::optional(x) : std::nullopt; };
    for (const Row& row : judged.rows) {
        const LevelQuality& q = row.quality;
        csv.row(row.name(), row.level, row.volumes.size(), judged.mesh.triangles.size(), judged.side, row.radius(),
                q.worst.either, q.mean.either, row.certified, if_closed(q.worst.beyond), if_closed(q.mean.beyond),
                q.volume / cell, q.open_triangles, q.points, q.outside,
                row.kind == BoundingVolume::sphere ? tree.bytes() : boxes.bytes());
    }
    csv.commit();
}

nlohmann::json as_json(const Row& row, const Judged& judged)
{
    const LevelQuality& q = row.quality;
    nlohmann::json object = {{"level", row.level},
                             {"kind", row.name()},
                             {"count", row.volumes.size()},
                             {"radius", row.radius()},
                             {"certified", row.certified},
                             {"over_reach", {{"worst", q.worst.either}, {"mean", q.mean.either}}},
                             {"volume", q.volume},
                             {"open_triangles", q.open_triangles},
                             {"uncovered_area", q.uncovered},
                             {"points", q.points},
                             {"points_outside", q.outside}};
    if (judged.closed) object["over_reach_outside"] = {{"worst", q.worst.beyond}, {"mean", q.mean.beyond}};
    return object;
}

void write_json(const std::string& path, const SpheresOptions& options, const Judged& judged, int depth,
                BoundingVolume kind)
{
    // `spheres` is the earlier name of the setting, with its earlier values.
    const nlohmann::json header = {{"version", version},      {"mesh", options.mesh},
                                   {"depth", depth},          {"bounding_volume", name_of(kind)},
                                   {"closed", judged.closed}, {"longest_side", judged.side}};
    OutputFile file(path);
    JsonWriter json(file);
    json.begin_object(), json.schema("oncollide.spheres", 1);
    json.key("header"), json.raw(header.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    json.key("levels"), json.begin_array();
    for (const Row& row : judged.rows) json.line(2), json.raw(as_json(row, judged).dump());
    json.line(), json.end_array();
    json.key("columns"), json.raw(nlohmann::json(columns(kind, judged.closed)).dump());
    json.key("rows"), json.begin_array();
    for (const Row& row : judged.rows)
        for (std::size_t i = 0; row.kind == kind && i < row.volumes.size(); ++i) {
            TextInMemory text;
            CsvWriter numbers(text);
            add_numbers(numbers, row, i, judged.closed);
            json.line(2), json.raw(fmt::format("[{}]", text.text()));
        }
    json.line(), json.end_array();
    json.end_object();
    file.write("\n");
    file.commit();
}

int spheres(const SpheresOptions& options)
{
    Settings settings{.depth = options.depth, .max_error = options.max_error, .threads = options.threads};
    if (!settings.depth && !settings.max_error) settings.depth = 6;
    check(settings);
    const BoundingVolume kind = bounding_volume_from_name(options.bounding_volume);
    if (kind == BoundingVolume::automatic) usage("--bounding-volume auto: must be sphere or obb here");
    check_range("--directions", options.directions, 1, 100'000);
    check_files({{"--levels", options.levels}, {"--json", options.json}, {"--csv", options.csv}}, {options.mesh});

    Scene scene;
    const GeometryId geometry = scene.add(options.mesh, load_mesh(options.mesh));
    const Mesh& mesh = std::get<Mesh>(scene.geometries[index(geometry)].data);
    const GrownTree tree(scene.geometries.share(index(geometry)), settings);
    Judged judged{mesh, is_closed(mesh), (mesh.bounds.max - mesh.bounds.min).maxCoeff(), {}};
    ObbTree boxes(mesh);
    judge(judged, tree, boxes, options);
    const bool stdout_taken = options.csv == "-" || options.json == "-" || options.levels == "-";
    if (!options.quiet) print_table(judged, tree, boxes, options, stdout_taken);
    write_all({[&] {
                   if (!options.csv.empty()) write_csv(options.csv, judged, kind);
               },
               [&] {
                   if (!options.levels.empty()) write_levels(options.levels, judged, tree, boxes);
               },
               [&] {
                   if (!options.json.empty()) write_json(options.json, options, judged, tree.depth(), kind);
               }});
    // The measured distances are rounded according to the mesh's coordinates.
    const double rounding = 1e-14 * mesh.bounds.min.cwiseAbs().cwiseMax(mesh.bounds.max.cwiseAbs()).maxCoeff();
    for (const Row& row : judged.rows) {
        const LevelQuality& q = row.quality;
        if (q.open_triangles || q.outside || q.worst.either > row.certified + rounding)
            throw Error(ErrorKind::internal,
                        fmt::format("{}: {} level {}: a part of the surface is not covered, or a point is {} m from "
                                    "it, but {} m are certified",
                                    options.mesh, row.name(), row.level, q.worst.either, row.certified));
    }
    return 0;
}

/// All options of a robot.
RobotSpheresOptions for_robot(const SpheresOptions& options)
{
    if (options.depth) usage("--depth: is for meshes; a robot has --max-error and --count");
    RobotSpheresOptions robot = options.robot;
    robot.urdf = options.mesh, robot.csv = options.csv, robot.json = options.json, robot.levels = options.levels;
    robot.max_error = options.max_error, robot.threads = options.threads, robot.quiet = options.quiet;
    return robot;
}

} // namespace

void add_spheres(Arguments app)
{
    Arguments sub = app.add_command(
        "spheres", "List the bounding volumes of a mesh's trees, spheres or OBBs, and how closely they fit");
    auto options = std::make_shared<SpheresOptions>();
    sub.add_option("mesh MESH|URDF", options->mesh, "mesh (OBJ, STL, PLY, OFF, glTF, COLLADA, 3MF), or a robot (URDF)")
        .required();
    sub.add_option("--depth D", options->depth,
                   "depth of the sphere-tree, 1 to 16 (default 6); boxes go down to single triangles");
    sub.add_option("--max-error", options->max_error,
                   "instead of --depth: largest error in metres of the verdict 'within' for two such trees")
        .length();
    sub.add_option("--bounding-volume NAME", options->bounding_volume,
                   "volumes to write: sphere, spheres around cells (default), or obb, oriented boxes around triangles");
    sub.add_option("--csv FILE", options->csv, "write the volumes of all levels, one per row; '-' is standard output");
    sub.add_option("--levels FILE", options->levels,
                   "write the tables as CSV, one row per level; '-' is standard output");
    sub.add_option("--json FILE", options->json, "write the tables and all volumes as JSON; '-' is standard output");
    sub.add_option("--directions N", options->directions,
                   fmt::format("sample points per sphere or box (default {})", options->directions));
    sub.add_option("--threads N", options->threads,
                   "number of threads; 0: all. Does not change the result (default 1)");
    sub.add_flag("--quiet", options->quiet, "print only errors");
    RobotSpheresOptions& robot = options->robot;
    sub.group("Robots");
    sub.add_option("--judge MODEL", robot.judge,
                   "model of spheres (cuRobo's .yml, a .urdf of spheres, or .csv): how much of each link do they leave "
                   "uncovered?");
    sub.add_option("--count N", robot.count, "make a model of at most N spheres, with the least over-reach found");
    sub.add_option("--yaml FILE", robot.yaml, "write the model as cuRobo's YAML");
    sub.add_option("--urdf FILE", robot.out, "write the model as a URDF whose collision geometry is spheres");
    sub.add_option("--html FILE", robot.html,
                   "write a page with a picture of each link: the uncovered surface, and the worst gap");
    sub.add_option("--package NAME=FOLDER", robot.packages, "folder of the meshes named package://NAME/...")
        .repeatable();
    sub.footer(
        "For a robot, --max-error or --count makes spheres that cover all collision geometry; --csv, --levels and\n"
        "--json write the spheres and their coverage. Exit codes: 0 everything is covered, 1 not.\n"
        "For a mesh, exit code 70: a part of the surface is not covered, or a volume extends farther than certified.\n"
        "Examples:\n"
        "  oncollide spheres bunny.obj --depth 5\n"
        "  oncollide spheres part.stl --max-error 0.002 --bounding-volume obb --csv boxes.csv\n"
        "  oncollide spheres panda.urdf --max-error 5mm --yaml panda_spheres.yml\n"
        "  oncollide spheres panda.urdf --judge panda_spherized.urdf");
    sub.action([options] {
        const bool robot_given = lower_extension(options->mesh) == ".urdf";
        return robot_given ? robot_spheres(for_robot(*options)) : spheres(*options);
    });
}

} // namespace oncollide::tools

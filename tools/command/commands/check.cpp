#include "cli/command.hpp"
#include "cli/log.hpp"
#include "cli/options.hpp"
#include "cli/progress.hpp"
#include "cli/standard_output.hpp"
#include "cli/system.hpp"
#include "common/numbers.hpp"
#include "play/play.hpp"
#include "render/backend_trial.hpp"
#include "self/check_self.hpp"
#include "view/view_page.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/text/csv_writer.hpp>
#include <oncollide/base/text/plain_number.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/pipeline/results.hpp>
#include <oncollide/runs/report_kept.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide::tools {
namespace {

struct CheckOptions {
    std::string a, b, pose_a, pose_b, to_pose_a, to_pose_b, stop;
    SettingsOptions settings;
    CacheOptions cache;
    std::string json, contacts, picture, view;
    int view_limit = 40;
    std::optional<double> distance; ///< tolerance, metres
    bool self = false, quiet = false;
};

/// Warns if the quaternion was not of length 1.
Eigen::Isometry3d pose_of(const std::string& option, const std::string& text, std::vector<std::string>& warnings)
{
    double length;
    const Eigen::Isometry3d pose = parse_pose(option, text, length);
    if (std::abs(length - 1) > 1e-6)
        warnings.push_back(fmt::format("{}: the quaternion has length {:.9g}; normalised", option, length));
    return pose;
}

GeometryId add_file(Scene& scene, const std::string& name, const std::string& path, const SceneReading& cache)
{
    if (cache.cooked && kind_of_file(path) == FileKind::mesh)
        if (const auto cooked = cache.cooked(path, {}))
            return scene.add(name, std::make_shared<const CookedMesh>(*cooked));
    return scene.add(name, std::move(load_geometry(path)->data));
}

Scene load_pair(const CheckOptions& options)
{
    Scene scene;
    scene.name = fmt::format("{} against {}", options.a, options.b);
    const Eigen::Isometry3d pose_a = pose_of("--pose-a", options.pose_a, scene.warnings);
    const Eigen::Isometry3d pose_b = pose_of("--pose-b", options.pose_b, scene.warnings);
    const std::string name_b = options.a == options.b ? options.b + " (second)" : options.b;
    const SceneReading cache = reading_with(options.cache);
    const GeometryId a = add_file(scene, options.a, options.a, cache);
    const GeometryId b = options.a == options.b ? a : add_file(scene, options.b, options.b, cache);
    scene.add_body({.name = options.a, .geometry = a, .pose = pose_a});
    scene.add_body({.name = name_b, .geometry = b, .pose = pose_b});
    return scene;
}

std::string describe(const Scene& scene, const Settings& settings, const PairResult& pair)
{
    const std::string both =
        fmt::format("'{}' and '{}'", printable(scene.label(SceneBodyId{0})), printable(scene.label(SceneBodyId{1})));
    switch (pair.verdict) {
    case Verdict::separate:
        if (pair.kind == ContactKind::touching)
            return fmt::format(
                "separate: {} touch without crossing, and touching pairs are ignored (--ignore-touching).", both);
        if (const double gap = std::max(pair.bound, settings.clearance); gap > 0)
            return fmt::format("separate: {} are at least {} m apart (certified).", both, plain_measure(gap, 6));
        return fmt::format("separate: {} do not meet (tested triangle by triangle).", both);
    case Verdict::colliding:
        switch (pair.kind) {
        case ContactKind::touching:
            return fmt::format("colliding (touching): {} meet without crossing.", both);
        case ContactKind::crossing:
            return fmt::format("colliding (crossing): {} pass through each other.", both);
        case ContactKind::enclosed:
            return fmt::format("colliding (enclosed): {}: one lies inside the other and their surfaces do not meet.",
                               both);
        default:
            return fmt::format("colliding: {} intersect (tested triangle by triangle).", both);
        }
    case Verdict::within:
        if (settings.clearance > 0 && pair.bound <= settings.clearance)
            return fmt::format(
                "within {} m{}: {} are at most that far apart (certified), inside the clearance of {} m.",
                plain_measure(pair.bound, 6), pair.kind == ContactKind::near ? " (near)" : "", both,
                plain_measure(settings.clearance, 6));
        return fmt::format("within {} m: {} are at most that far apart (certified), and may or may not collide. "
                           "A smaller --max-error narrows the bound{}.",
                           plain_measure(pair.bound, 6), both,
                           exact_level(settings) == ExactLevel::off ? "; --exact on decides" : "");
    case Verdict::undecided:
        return fmt::format(
            "undecided: {} are at most {} m apart (certified); a budget was used up before the pair was decided.", both,
            plain_measure(pair.bound, 6));
    }
    return {};
}

/// Colours the first word, the verdict.
std::string tinted_verdict(const std::string& text, Verdict verdict, bool on_stderr)
{
    const Tint tint = verdict == Verdict::colliding  ? Tint::red
                      : verdict == Verdict::separate ? Tint::green
                                                     : Tint::yellow;
    const std::size_t end = text.find_first_of(" :");
    return tinted(tint, text.substr(0, end), on_stderr ? stderr_is_terminal() : stdout_is_terminal()) +
           text.substr(end);
}

std::string describe(const BodyPart& part, const std::string& name)
{
    return fmt::format("{} {} of '{}'", part.cell.side > 0 ? "cell" : "triangle", part_text(part), name);
}

/// One row per pair of parts that meet.
void write_contacts(const World& world, OutputFile& file)
{
    CsvWriter csv(file, "part_a,part_b,kind,x0,y0,z0,x1,y1,z1,normal_a_x,normal_a_y,normal_a_z,normal_b_x,normal_b_y,"
                        "normal_b_z");
    for (const Contact& c : world.pairs().contacts(world.bodies().at(0), world.bodies().at(1))) {
        csv.add(part_text(c.a), part_text(c.b), name_of(c.kind));
        for (const Eigen::Vector3d& v : {c.ends[0], c.ends[1], c.normal_a, c.normal_b})
            for (const double x : v) csv.add(Digits{x, 17});
        csv.end_row();
    }
    file.commit();
}

SweepStop stop_of(const std::string& name)
{
    if (name.empty()) return SweepOptions{}.stop;
    for (const SweepStop stop : {SweepStop::contact, SweepStop::touch, SweepStop::press})
        if (name == name_of(stop)) return stop;
    usage(fmt::format("--stop: '{}' is not contact, touch or press", name));
}

/// Lets the bodies move in the next step.
void set_motions(World& world, const CheckOptions& options)
{
    std::vector<std::string> warnings;
    if (!options.to_pose_a.empty())
        world.bodies().set_motion(world.bodies().at(0), pose_of("--to-pose-a", options.to_pose_a, warnings));
    if (!options.to_pose_b.empty())
        world.bodies().set_motion(world.bodies().at(1), pose_of("--to-pose-b", options.to_pose_b, warnings));
    for (const std::string& warning : warnings) log(LogLevel::warning, warning);
}

std::string describe(const Scene& scene, const PairSweep& sweep)
{
    const std::string both =
        fmt::format("'{}' and '{}'", printable(scene.label(SceneBodyId{0})), printable(scene.label(SceneBodyId{1})));
    const auto& at = sweep.contact.ends[0];
    const std::string time = fmt::format("from time {:.9g} to {:.9g}", sweep.clear_until, sweep.contact_by);
    switch (sweep.verdict) {
    case Verdict::separate:
        return fmt::format("separate: {} never meet on the way (certified).", both);
    case Verdict::undecided:
        return fmt::format("undecided: {} do not meet before time {:.9g} (certified).", both, sweep.clear_until);
    default:
        break;
    }
    const std::string_view word = name_of(sweep.verdict);
    if (sweep.verdict == Verdict::within && sweep.kind == ContactKind::unknown &&
        sweep.grazes_until > sweep.clear_until)
        return fmt::format(
            "within {:.6g} m: {} graze from time {:.9g} to {:.9g}, and no deeper contact was found then.", sweep.gap,
            both, sweep.clear_until, sweep.grazes_until);
    if (sweep.verdict == Verdict::colliding && sweep.grazes_until > sweep.clear_until)
        return fmt::format(
            "{}: {} graze from time {:.9g}, {:.6g} m apart or less, and meet from time {:.9g} to {:.9g}, "
            "at ({:.6g}, {:.6g}, {:.6g}).",
            word, both, sweep.clear_until, sweep.gap, sweep.grazes_until, sweep.contact_by, at.x(), at.y(), at.z());
    if (sweep.contact_by == 0)
        return fmt::format("{}: {} are in contact at time 0{}.", word, both,
                           sweep.separating ? ", and apart soon after" : "");
    return fmt::format("{}: {} first meet {} (certified), at ({}, {}, {}).", word, both, time, plain_number(at.x(), 6),
                       plain_number(at.y(), 6), plain_number(at.z(), 6));
}

std::string describe_distance(const Scene& scene, const World& world, double tolerance)
{
    const Distance d = world.pairs().distance(world.bodies().at(0), world.bodies().at(1), {.tolerance = tolerance});
    const std::string a = describe(d.a, printable(scene.label(SceneBodyId{0}))),
                      b = describe(d.b, printable(scene.label(SceneBodyId{1})));
    if (d.upper == 0) return fmt::format("distance: 0, {} meets {}.", a, b);
    return fmt::format("distance: from {} to {} m (certified), between {} and {}.", plain_number(d.lower, 12),
                       plain_number(d.upper, 12), a, b);
}

int check_pair(const CheckOptions& options)
{
    if (options.b.empty()) usage("check: B is missing: the second file; or --self: whether A meets itself");
    if (!options.picture.empty() || !options.view.empty()) usage("--picture, --view: need --self");
    Settings settings = with_tried_backend(settings_from(options.settings));
    Settings plain = settings;
    plain.clearance = 0; // distances of one pair are cheap enough to be exact by default
    settings.exact = exact_level(plain);
    if (options.distance && !(*options.distance >= 0))
        throw Error(ErrorKind::usage,
                    fmt::format("--distance: a tolerance of {}; must be 0 or more", *options.distance));
    if (!options.contacts.empty() && exact_level(settings) != ExactLevel::predicates)
        throw Error(ErrorKind::usage,
                    "--contacts: needs the exact level: leave out --max-error and --depth, or give --exact on");
    const bool moves = !options.to_pose_a.empty() || !options.to_pose_b.empty();
    if (moves && (options.distance || !options.contacts.empty()))
        usage("--to-pose-a, --to-pose-b: not together with --distance or --contacts, which are of one pose");
    if (!moves && !options.stop.empty()) usage("--stop: of bodies that move; needs --to-pose-a or --to-pose-b");
    const SweepOptions sweep{.stop = stop_of(options.stop)};
    settings.contact_kinds = exact_level(settings) == ExactLevel::predicates;
    // Both stages would cull without a bound on the distance, and a single pair needs neither.
    for (const StageId stage : {StageId::delimitation, StageId::broad}) settings.skip.insert(stage);
    check_files({{"--json", options.json}, {"--contacts", options.contacts}}, {options.a, options.b});

    std::optional<OutputFile> contacts;
    if (!options.contacts.empty()) contacts.emplace(options.contacts);
    show_reading(options.quiet);
    const Scene scene = load_pair(options);
    if (!options.quiet) print_warnings(scene);
    Pipeline pipeline(scene, settings);
    pipeline.world().set_sweep_options(sweep);
    set_motions(pipeline.world(), options);
    pipeline.set_continuous(moves); // makes the results contain the sweep
    Report report(scene, pipeline, {.csv = false, .trace = false, .separate = true});
    const FrameView frame = pipeline.step(scene);
    report.add(frame);
    const PairResult pair =
        frame.pairs.empty()
            ? PairResult{{Verdict::separate, ContactKind::unknown, settings.clearance}, StageId::bounds, {}, {}}
            : frame.pairs.front();
    const bool taken = options.json == "-" || options.contacts == "-";
    if (!options.quiet)
        write_to_stdout(tinted_verdict(frame.sweeps.empty() ? describe(scene, settings, pair)
                                                            : describe(scene, frame.sweeps.front()),
                                       pair.verdict, taken) +
                            "\n",
                        taken);
    if (!options.quiet && options.distance)
        write_to_stdout(describe_distance(scene, pipeline.world(), *options.distance) + "\n", taken);
    write_all({[&] {
                   if (!options.json.empty()) report.write_json(options.json);
               },
               [&] {
                   if (contacts) write_contacts(pipeline.world(), *contacts);
               }});
    if (const int code = say_file_faults(pipeline.world())) return code;
    return pair.verdict == Verdict::separate ? 0 : pair.verdict == Verdict::colliding ? 1 : 2;
}

int check_alone(const CheckOptions& options)
{
    for (const std::string* text :
         {&options.b, &options.pose_a, &options.pose_b, &options.to_pose_a, &options.to_pose_b, &options.stop})
        if (!text->empty() || options.distance)
            usage("--self: is about A alone: not together with B, poses, --stop or --distance");
    return check_self({.input = options.a,
                       .json = options.json,
                       .contacts = options.contacts,
                       .picture = options.picture,
                       .view = options.view,
                       .view_limit = options.view_limit,
                       .quiet = options.quiet});
}

} // namespace

void add_check(Arguments app)
{
    Arguments sub = app.add_command("check", "Check whether two files collide, or whether a mesh meets itself");
    auto options = std::make_shared<CheckOptions>();
    sub.add_option("A FILE", options->a,
                   "mesh (OBJ, STL, PLY, OFF, glTF, COLLADA, 3MF, cooked; '-': standard input), OctoMap (.bt, .ot) or "
                   "terrain (PGM, PNG, NumPy, GDAL's)")
        .required();
    sub.add_option("B FILE", options->b, "the second body, in the same formats; may be the same file");
    sub.add_flag(
        "--self", options->self,
        "without B: find the triangles of A that meet each other beyond the vertices and edges that they share; "
        "exact with all settings. A may be a folder, whose mesh files are checked one by one");
    sub.add_option("--pose-a \"x y z qx qy qz qw\"", options->pose_a,
                   "pose of A, metres and unit quaternion (default: identity)");
    sub.add_option("--pose-b \"x y z qx qy qz qw\"", options->pose_b, "pose of B");
    sub.add_option("--to-pose-a \"x y z qx qy qz qw\"", options->to_pose_a,
                   "A moves to this pose, over the time from 0 to 1: in a straight line, rotating along the shorter "
                   "arc; the result is the first contact on the way");
    sub.add_option("--to-pose-b \"x y z qx qy qz qw\"", options->to_pose_b, "the same for B");
    sub.add_option(
        "--stop", options->stop,
        "which contact on the way is the result: contact (default: the first certain one; a gap that rounding "
        "hides is passed), touch (such a gap, too) or press (the first that gets deeper than 0.1 mm; bodies "
        "may touch, slide along each other, and part)");
    add_accuracy_options(sub, options->settings);
    add_cache_options(sub, options->cache);
    sub.add_option("--json FILE", options->json, "write the result as JSON; '-' is standard output");
    sub.add_option(
        "--contacts FILE.csv", options->contacts,
        "write each pair of triangles or cells that meet, with its position and normals, as CSV; not with --exact off");
    sub.add_option("--picture FILE.png", options->picture,
                   "with --self: draw the mesh with the triangles that meet in red, and the worst place close up");
    sub.add_option("--view FILE.html", options->view,
                   "with --self: write the mesh as a page in 3D with the triangles that meet in red; needs three.js "
                   "(Debian: libjs-three)");
    add_view_limit(sub, options->view_limit);
    sub.add_option("--distance", options->distance,
                   "also print the distance of two meshes or terrains as two bounds that differ by at most M metres; "
                   "0: as close as double precision allows")
        .length();
    sub.add_flag("--quiet", options->quiet, "print only errors; the exit code is the result");
    sub.footer("Exit codes: 0 separate, 1 colliding, 2 within or undecided, 64 and above: error.\n"
               "The pair is decided exactly, triangle by triangle. --max-error M, --depth D or --exact off requests a\n"
               "certified bound instead: a pair that may touch is then 'within' that bound, and never 'colliding'.\n"
               "Examples:\n"
               "  oncollide check bunny.obj cow.obj --pose-b \"0.4 0 0 0 0 0 1\"\n"
               "  oncollide check bunny.obj cow.obj --pose-b \"2 0 0 0 0 0 1\" --to-pose-b \"-2 0 0 0 0 1 0\"\n"
               "  oncollide check part.stl fixture.stl --clearance 0.002 --json -\n"
               "  oncollide check arm.stl bench.stl --pose-b \"0 0 0.5 0 0 0 1\" --distance 0.001\n"
               "  oncollide check scan.ply --self --picture scan.png");
    sub.action([options] { return options->self ? check_alone(*options) : check_pair(*options); });
}

} // namespace oncollide::tools

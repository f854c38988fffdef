#include "robot/robot_spheres.hpp"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/text/csv_writer.hpp>
#include <oncollide/base/text/json_writer.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/robots/spheres/sphere_judge.hpp>
#include <oncollide/robots/spheres/sphere_maker.hpp>

#include "cli/log.hpp"
#include "cli/outputs.hpp"
#include "cli/standard_output.hpp"
#include "render/painter_process.hpp"
#include "robot/robot_world.hpp"
#include "robot/sphere_files.hpp"
#include "robot/sphere_page.hpp"

namespace oncollide::tools {

namespace {

/// A robot with the surfaces of its links.
struct Surfaces {
    RobotDescription robot;
    std::vector<LinkSurface> links;
    int threads;

    /// Calls work(i) for each link that has collision geometry.
    template <class Work>
    void each(Work work) const
    {
        parallel_chunks(links.size(), 1, threads, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i)
                if (!links[i].triangles().empty()) work(i);
        });
    }
};

Surfaces surfaces_of(const RobotSpheresOptions& options)
{
    RobotOptions robot;
    robot.urdf = options.urdf, robot.packages = options.packages;
    Surfaces surfaces{open_robot(robot), {}, threads_of(options.threads)};
    for (const RobotLink& link : surfaces.robot.links) surfaces.links.emplace_back(link);
    return surfaces;
}

/// The models of all links, with the same error.
class ModelMaker {
public:
    explicit ModelMaker(const Surfaces& surfaces) : surfaces_(surfaces), makers_(surfaces.links.size())
    {
        surfaces.each([&](std::size_t i) { makers_[i].emplace(surfaces.links[i]); });
    }

    SphereModel within(double error) const
    {
        SphereModel model(makers_.size());
        surfaces_.each([&](std::size_t i) { model[i] = makers_[i]->within(error); });
        return model;
    }

    /// At most `count` spheres, with the least error that halving an interval finds.
    SphereModel of(std::size_t count) const
    {
        SphereModel best(makers_.size());
        double low = 0, high = 0;
        for (std::size_t i = 0; i < makers_.size(); ++i)
            if (makers_[i]) {
                best[i] = {makers_[i]->single()};
                high = std::max(high, best[i][0].radius + surfaces_.links[i].signed_distance(best[i][0].centre));
            }
        if (count < count_of(best))
            throw Error(ErrorKind::usage,
                        fmt::format("--count is {}; {} links have collision geometry, and each needs a sphere", count,
                                    count_of(best)));
        for (int i = 0; i < 14 && high - low > 1e-5; ++i) {
            const double middle = i == 0 ? high / 8 : (low + high) / 2;
            SphereModel model = within(middle);
            if (count_of(model) <= count)
                best = std::move(model), high = middle;
            else
                low = middle;
        }
        return best;
    }

private:
    const Surfaces& surfaces_;
    std::vector<std::optional<SphereMaker>> makers_;
};

struct LinkRow {
    std::size_t number;
    std::string link;
    std::size_t spheres;
    bool closed;
    CoverJudgement judged;
};

std::vector<LinkRow> judge(const Surfaces& surfaces, const SphereModel& model)
{
    std::vector<LinkRow> rows(surfaces.links.size());
    surfaces.each([&](std::size_t i) {
        rows[i] = {i, surfaces.robot.links[i].name, model[i].size(), surfaces.links[i].closed(),
                   judge_cover(surfaces.links[i], model[i])};
    });
    std::erase_if(rows, [](const LinkRow& row) { return row.link.empty(); });
    return rows;
}

/// The sums and the worst values of all links.
CoverJudgement all_of(const std::vector<LinkRow>& rows)
{
    CoverJudgement all;
    all.complete = true;
    for (const LinkRow& row : rows) {
        const CoverJudgement& one = row.judged;
        all.area += one.area, all.uncovered += one.uncovered, all.uncovered_most += one.uncovered_most;
        if (one.gap > all.gap) all.gap = one.gap, all.worst = one.worst;
        all.gap_most = std::max(all.gap_most, one.gap_most);
        all.over_reach = std::max(all.over_reach, one.over_reach);
        all.complete = all.complete && one.complete;
    }
    return all;
}

std::string percent(const CoverJudgement& judged)
{
    if (judged.complete) return "0";
    const double least = 100 * judged.uncovered / judged.area, most = 100 * judged.uncovered_most / judged.area;
    return fmt::format("{:.2f} to {:.2f}", least, most);
}

std::string millimetres(double metres)
{
    return std::isfinite(metres) ? fmt::format("{:.2f}", 1e3 * metres) : "-";
}

std::string table(const std::vector<LinkRow>& rows)
{
    std::string text = fmt::format("{:<32}{:>8}{:>20}{:>10}{:>26}{:>14}\n", "link", "spheres", "uncovered, %",
                                   "gap, mm", "at, m (link's frame)", "over-reach, mm");
    const auto line = [&](const std::string& name, std::size_t spheres, const CoverJudgement& judged, bool place) {
        const Eigen::Vector3d& at = judged.worst;
        text += fmt::format("{:<32}{:>8}{:>20}{:>10}{:>26}{:>14}\n", printable(name), spheres, percent(judged),
                            millimetres(judged.gap),
                            place && judged.gap > 0 && std::isfinite(judged.gap)
                                ? fmt::format("{:.3f} {:.3f} {:.3f}", at.x(), at.y(), at.z())
                                : "",
                            spheres ? millimetres(judged.over_reach) : "-");
    };
    std::size_t spheres = 0;
    for (const LinkRow& row : rows) {
        line(row.link + (row.closed ? "" : " (open)"), row.spheres, row.judged, true);
        spheres += row.spheres;
    }
    line("all", spheres, all_of(rows), false);
    return text;
}

void write_levels(const std::string& path, const std::vector<LinkRow>& rows)
{
    OutputFile file(path);
    CsvWriter csv(file, "link,spheres,closed,area,uncovered,uncovered_most,gap,gap_most,x,y,z,over_reach");
    for (const LinkRow& row : rows) {
        const CoverJudgement& j = row.judged;
        csv.row(Quoted{row.link}, row.spheres, row.closed ? 1 : 0, j.area, j.uncovered, j.uncovered_most, j.gap,
                j.gap_most, j.worst.x(), j.worst.y(), j.worst.z(), j.over_reach);
    }
    file.commit();
}

void write_json(const std::string& path, const RobotDescription& robot, const std::vector<LinkRow>& rows)
{
    OutputFile file(path);
    JsonWriter json(file);
    const CoverJudgement all = all_of(rows);
    json.begin_object();
    json.members("schema", "oncollide.robot_spheres", "schema_version", 1, "robot", robot.name, "complete",
                 all.complete, "area", all.area, "uncovered", all.uncovered, "uncovered_most", all.uncovered_most,
                 "gap", all.gap, "over_reach", all.over_reach);
    json.key("links"), json.begin_array();
    for (const LinkRow& row : rows) {
        const CoverJudgement& j = row.judged;
        json.line(2);
        json.object("link", row.link, "spheres", row.spheres, "closed", row.closed, "complete", j.complete, "area",
                    j.area, "uncovered", j.uncovered, "uncovered_most", j.uncovered_most, "gap", j.gap, "gap_most",
                    j.gap_most, "over_reach", j.over_reach);
    }
    json.line();
    json.end_array(), json.end_object();
    file.commit();
}

/// Returns why pictures are missing; empty: none is.
std::string write_page(const RobotSpheresOptions& options, const Surfaces& surfaces, const SphereModel& model,
                       const std::vector<LinkRow>& rows, PainterProcess& painter)
{
    std::vector<JudgedLink> links;
    for (const LinkRow& row : rows)
        links.push_back({row.link, &surfaces.links[row.number], model[row.number], row.judged});
    const std::string of = options.judge.empty() ? "spheres" : std::filesystem::path(options.judge).filename().string();
    return write_sphere_page(options.html, fmt::format("{}: {}", surfaces.robot.name, of), table(rows), links, painter);
}

} // namespace

int robot_spheres(const RobotSpheresOptions& o)
{
    if (!o.judge.empty() && (o.max_error || o.count))
        usage("spheres: --judge does not make spheres; leave out --max-error and --count");
    if (o.judge.empty() && o.max_error.has_value() == o.count.has_value())
        usage("spheres: a robot needs one of --judge MODEL, --max-error M and --count N");
    if (o.max_error && !(*o.max_error >= 1e-4)) usage("--max-error: must be 0.1 mm or more for a robot");
    check_files({{"--yaml", o.yaml},
                 {"--urdf", o.out},
                 {"--csv", o.csv},
                 {"--levels", o.levels},
                 {"--json", o.json},
                 {"--html", o.html}},
                {o.urdf, o.judge});
    std::optional<PainterProcess> painter;
    if (!o.html.empty()) painter.emplace();
    const Surfaces surfaces = surfaces_of(o);
    std::vector<std::string> warnings;
    const SphereModel model = !o.judge.empty() ? load_sphere_model(o.judge, surfaces.robot, warnings)
                              : o.count ? ModelMaker(surfaces).of(static_cast<std::size_t>(std::max(*o.count, 0)))
                                        : ModelMaker(surfaces).within(*o.max_error);
    if (!o.quiet) log_warnings(warnings);
    const std::vector<LinkRow> rows = judge(surfaces, model);
    const CoverJudgement all = all_of(rows);
    if (o.judge.empty() && !all.complete)
        throw Error(ErrorKind::internal, fmt::format("{}: the spheres do not cover {} m2", o.urdf, all.uncovered_most));
    write_all({[&] {
                   if (!o.yaml.empty()) save_yaml_spheres(o.yaml, surfaces.robot, model);
               },
               [&] {
                   if (!o.out.empty()) save_urdf_spheres(o.out, surfaces.robot, model);
               },
               [&] {
                   if (!o.csv.empty()) save_csv_spheres(o.csv, surfaces.robot, model);
               },
               [&] {
                   if (!o.levels.empty()) write_levels(o.levels, rows);
               },
               [&] {
                   if (!o.json.empty()) write_json(o.json, surfaces.robot, rows);
               }});
    if (!o.quiet) {
        const bool taken = o.json == "-" || o.csv == "-" || o.levels == "-" || o.yaml == "-" || o.out == "-";
        write_to_stdout(table(rows), taken);
        write_to_stdout(all.complete
                            ? "Every triangle is in a sphere: a check with these spheres misses no collision, and "
                              "refuses only\nconfigurations that are within the over-reach.\n"
                            : "A check with these spheres misses collisions of the uncovered surface, up to the depth "
                              "of the gap.\n",
                        taken);
    }
    if (painter) // comes last, so that other results do not wait for pictures
        if (const std::string missing = write_page(o, surfaces, model, rows, *painter); !missing.empty() && !o.quiet)
            log(LogLevel::warning, fmt::format("{}: {}", o.html, missing));
    return all.complete ? 0 : 1;
}

} // namespace oncollide::tools

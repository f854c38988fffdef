// oncollide robot: which of many configurations of a robot collide, with itself or with an environment?
#include "cli/command.hpp"
#include "cli/options.hpp"
#include "cli/outputs.hpp"
#include "cli/progress.hpp"
#include "common/statistics.hpp"
#include "play/play.hpp"
#include "robot/robot_world.hpp"

#include <array>
#include <iostream>
#include <memory>

#include <fmt/format.h>

#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/text/csv_writer.hpp>
#include <oncollide/base/text/json_writer.hpp>
#include <oncollide/base/text/printable.hpp>

namespace oncollide::tools {
namespace {

struct RobotCommand {
    RobotOptions robot;
    ConfigurationOptions configurations;
    SettingsOptions settings;
    std::string json, csv;
    bool limits = false, no_self = false, path = false, quiet = false;
};

/// One run, with its results.
struct Checked {
    RobotWorld& environment;
    const Robot& robot;
    std::vector<RobotFinding> findings;  ///< of configurations, or of motions
    std::vector<RobotEdgeFinding> edges; ///< times of motions; empty: configurations
    double seconds;

    const char* item() const { return edges.empty() ? "configuration" : "motion"; }

    std::array<std::size_t, 4> counts() const
    {
        std::array<std::size_t, 4> counts{};
        for (const RobotFinding& found : findings) ++counts[static_cast<std::size_t>(found.verdict)];
        return counts;
    }
    const std::string& link(std::uint32_t i) const { return robot.description().links[i].name; }
    /// "colliding", "within 0.001 m", "colliding by 0.52, clear until 0.5199".
    std::string what(std::size_t i) const
    {
        const RobotFinding& found = findings[i];
        const std::string verdict(name_of(found.verdict));
        if (edges.empty())
            return found.verdict == Verdict::colliding ? verdict : fmt::format("{} {:.6g} m", verdict, found.bound);
        const RobotEdgeFinding& edge = edges[i];
        const std::string by = edge.contact_by <= 1 ? fmt::format(" by {:.6g}", edge.contact_by) : "";
        return fmt::format("{}{}, clear until {:.6g}", verdict, by, edge.clear_until);
    }
    /// The other side of a pair that is not separate.
    std::string other(const RobotFinding& found) const
    {
        return found.other != RobotFinding::no_link ? link(found.other) : environment.label(found.body);
    }
};

void write_json(const std::string& path, const Checked& checked)
{
    OutputFile file(path);
    JsonWriter json(file);
    const auto counts = checked.counts();
    json.begin_object();
    json.members("schema", "oncollide.robot", "schema_version", 1, "robot", checked.robot.description().name,
                 checked.item() + std::string("s"), checked.findings.size());
    for (const Verdict verdict : {Verdict::separate, Verdict::within, Verdict::colliding, Verdict::undecided})
        json.members(name_of(verdict), counts[static_cast<std::size_t>(verdict)]);
    json.members("seconds", checked.seconds);
    json.key("results"), json.begin_array();
    for (std::size_t i = 0; i < checked.findings.size(); ++i) {
        const RobotFinding& found = checked.findings[i];
        json.line(2);
        json.begin_object();
        json.members(checked.item(), i, "verdict", name_of(found.verdict));
        if (checked.edges.empty())
            json.members("bound", found.bound);
        else
            json.members("clear_until", checked.edges[i].clear_until);
        if (!checked.edges.empty() && checked.edges[i].contact_by <= 1)
            json.members("contact_by", checked.edges[i].contact_by);
        if (found.link != RobotFinding::no_link)
            json.members("link", checked.link(found.link), found.other != RobotFinding::no_link ? "other_link" : "body",
                         checked.other(found));
        json.end_object();
    }
    json.line();
    json.end_array(), json.end_object();
    file.commit();
}

void write_csv(const std::string& path, const Checked& checked)
{
    OutputFile file(path);
    const bool motions = !checked.edges.empty();
    CsvWriter csv(file, motions ? "motion,verdict,clear_until,contact_by,link,other_link,body"
                                : "configuration,verdict,bound,link,other_link,body");
    for (std::size_t i = 0; i < checked.findings.size(); ++i) {
        const RobotFinding& found = checked.findings[i];
        const bool pair = found.link != RobotFinding::no_link, self = found.other != RobotFinding::no_link;
        const std::string link = pair ? checked.link(found.link) : "", other = pair ? checked.other(found) : "";
        const auto row = [&](const auto&... numbers) {
            csv.row(i, name_of(found.verdict), numbers..., Quoted{link}, Quoted{self ? other : ""},
                    Quoted{self ? "" : other});
        };
        if (motions)
            row(Digits{checked.edges[i].clear_until, 9}, Digits{checked.edges[i].contact_by, 9});
        else
            row(Digits{found.bound, 9});
    }
    file.commit();
}

std::string describe(const Checked& checked)
{
    const auto counts = checked.counts();
    std::string text =
        fmt::format("{}: {} {}s", printable(checked.robot.description().name), checked.findings.size(), checked.item());
    const char* comma = ": ";
    for (const Verdict verdict : {Verdict::separate, Verdict::within, Verdict::colliding, Verdict::undecided})
        if (const std::size_t count = counts[static_cast<std::size_t>(verdict)])
            text += fmt::format("{}{} {}", comma, count, name_of(verdict)), comma = ", ";
    text += fmt::format(" ({:.3g} s)\n", checked.seconds);
    constexpr std::size_t most = 10;
    std::size_t told = 0;
    for (std::size_t i = 0; i < checked.findings.size(); ++i) {
        const RobotFinding& found = checked.findings[i];
        if (found.verdict == Verdict::separate) continue;
        if (++told > most) continue;
        text += fmt::format("{} {}: {}, link '{}' and {} '{}'\n", checked.item(), i, checked.what(i),
                            printable(checked.link(found.link)), found.other != RobotFinding::no_link ? "link" : "body",
                            printable(checked.other(found)));
    }
    if (told > most) text += fmt::format("and {} more\n", told - most);
    return text;
}

int check_robot(const RobotCommand& options)
{
    check_files({{"--json", options.json}, {"--csv", options.csv}},
                {options.robot.urdf, options.robot.srdf, options.robot.world, options.configurations.file});
    const Settings settings = settings_from(options.settings);
    show_reading(options.quiet);
    RobotDescription description = open_robot(options.robot);
    RobotWorld environment = open_robot_world(options.robot, settings);
    if (!options.quiet) print_warnings(environment.scene);
    const Robot robot(environment.world(), std::move(description), base_of(options.robot));
    const std::vector<double> numbers = open_configurations(options.configurations, robot);
    const std::size_t width = robot.width(), count = width ? numbers.size() / width : 1;
    for (std::size_t i = 0; options.limits && i < count; ++i) try { // check() checks the rest
            robot.check_configuration(std::span(numbers).subspan(i * width, width), true);
        } catch (const Error& error) {
            throw Error(error.kind(), fmt::format("configuration {}: {}", i, error.what()));
        }
    if (options.path && count < 2)
        throw Error(ErrorKind::usage, "--path: needs two configurations or more (--configurations)");
    Checked checked{environment, robot, std::vector<RobotFinding>(options.path ? count - 1 : count), {}, 0};
    const RobotCheck pairs{.self = !options.no_self};
    const Clock::time_point from = Clock::now();
    if (options.path) {
        checked.edges.resize(count - 1);
        const std::span<const double> all(numbers);
        robot.check_edges(environment.world(), all.first((count - 1) * width), all.subspan(width), checked.edges,
                          {.pairs = pairs});
        for (std::size_t i = 0; i + 1 < count; ++i) {
            const RobotEdgeFinding& edge = checked.edges[i];
            checked.findings[i] = {0, edge.verdict, edge.link, edge.other, edge.body};
        }
    } else {
        robot.check(environment.world(), numbers, checked.findings, pairs);
    }
    checked.seconds = milliseconds_since(from) / 1e3;
    if (!options.json.empty()) write_json(options.json, checked);
    if (!options.csv.empty()) write_csv(options.csv, checked);
    if (!options.quiet) (options.json == "-" || options.csv == "-" ? std::cerr : std::cout) << describe(checked);
    if (const int code = say_file_faults(environment.world())) return code;
    const auto counts = checked.counts();
    if (counts[static_cast<std::size_t>(Verdict::colliding)]) return 1;
    return counts[static_cast<std::size_t>(Verdict::separate)] == checked.findings.size() ? 0 : 2;
}

} // namespace

void add_robot(Arguments app)
{
    Arguments sub = app.add_command("robot", "Check configurations of a robot against itself and an environment");
    auto options = std::make_shared<RobotCommand>();
    add_robot_options(sub, options->robot);
    add_configuration_options(sub, options->configurations);
    sub.add_flag("--limits", options->limits, "refuse a configuration that is out of the limits of a joint");
    sub.add_flag("--path", options->path, "check the whole motions from each configuration to the next, without gaps");
    sub.add_flag("--no-self", options->no_self, "only against the environment");
    add_accuracy_options(sub, options->settings);
    add_pipeline_options(sub, options->settings);
    sub.add_option("--json FILE", options->json, "write the results as JSON; '-' is standard output");
    sub.add_option("--csv FILE", options->csv, "write the results as CSV; '-' is standard output");
    sub.add_flag("--quiet", options->quiet, "print only errors; the exit code is the result");
    sub.footer("Exit codes: 0 all configurations or motions separate, 1 one or more colliding, 2 one or more within or "
               "undecided,\n"
               "64 and above: error.\n"
               "Examples:\n"
               "  oncollide robot panda.urdf --srdf panda.srdf --state ready\n"
               "  oncollide robot panda.urdf --srdf panda.srdf --world shelf.json --group panda_arm \\\n"
               "    --configurations samples.npy --threads 0 --json results.json\n"
               "  oncollide robot panda.urdf --srdf panda.srdf --world shelf.json --configurations plan.csv --path");
    sub.action([options] { return check_robot(*options); });
}

} // namespace oncollide::tools

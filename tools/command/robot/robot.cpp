// oncollide robot: which of many configurations of a robot collide, with itself or with an environment?
#include "cli/command.hpp"
#include "cli/log.hpp"
#include "cli/options.hpp"
#include "cli/outputs.hpp"
#include "cli/progress.hpp"
#include "cli/standard_output.hpp"
#include "cli/system.hpp"
#include "common/statistics.hpp"
#include "play/play.hpp"
#include "robot/robot_padding.hpp"
#include "robot/robot_refusals.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <memory>

#include <fmt/format.h>

#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/text/csv_writer.hpp>
#include <oncollide/base/text/json_writer.hpp>
#include <oncollide/base/text/listed.hpp>
#include <oncollide/base/text/plain_number.hpp>
#include <oncollide/base/text/printable.hpp>

namespace oncollide::tools {
namespace {

struct RobotCommand {
    RobotOptions robot;
    ConfigurationOptions configurations;
    PaddingOptions padding;
    SettingsOptions settings;
    std::string json, csv;
    std::string limits = "warn";
    bool no_self = false, path = false, quiet = false;
};

/// One run, with its results.
struct Checked {
    RobotWorld& environment;
    const Robot& robot;
    bool motions;
    std::vector<RobotFinding> findings;  ///< findings of configurations, or of motions
    std::vector<RobotEdgeFinding> edges; ///< times of motions; empty: configurations
    double seconds = 0;
    bool interrupted = false; ///< only the first items have findings

    const char* item() const { return motions ? "motion" : "configuration"; }

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
        if (!motions)
            return found.verdict == Verdict::colliding ? verdict
                                                       : fmt::format("{} {} m", verdict, plain_measure(found.bound, 6));
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
    json.members("seconds", checked.seconds, "interrupted", checked.interrupted);
    json.key("results"), json.begin_array();
    for (std::size_t i = 0; i < checked.findings.size(); ++i) {
        const RobotFinding& found = checked.findings[i];
        json.line(2);
        json.begin_object();
        json.members(checked.item(), i, "verdict", name_of(found.verdict));
        if (!checked.motions)
            json.members("bound", found.bound);
        else
            json.members("clear_until", checked.edges[i].clear_until);
        if (checked.motions && checked.edges[i].contact_by <= 1)
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
    const bool motions = checked.motions;
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

std::string described(const Checked& checked)
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
                            shortened(printable(checked.link(found.link))),
                            found.other != RobotFinding::no_link ? "link" : "body",
                            shortened(printable(checked.other(found))));
    }
    if (told > most) text += fmt::format("and {} more\n", told - most);
    return text;
}

/// Checks all items; after an interrupt, the remaining ones are left out. `check(begin, end)` checks some of them.
void check_in_chunks(Checked& checked, std::size_t count, std::size_t chunk,
                     const std::function<void(std::size_t, std::size_t)>& check)
{
    const Clock::time_point from = Clock::now();
    catch_interrupts();
    std::size_t done = 0;
    while (done < count && !interrupted()) {
        const Clock::time_point begin = Clock::now();
        const std::size_t end = std::min(count, done + chunk);
        check(done, end);
        done = end;
        if (milliseconds_since(begin) < 100) chunk *= 2;
    }
    checked.interrupted = done < count;
    if (!checked.interrupted) release_interrupts();
    checked.findings.resize(done);
    if (checked.motions) checked.edges.resize(done);
    checked.seconds = milliseconds_since(from) / 1e3;
}

int check_robot(const RobotCommand& options)
{
    check_files({{"--json", options.json}, {"--csv", options.csv}},
                {options.robot.urdf, options.robot.srdf, options.robot.world, options.configurations.file,
                 options.padding.file});
    const Settings settings = settings_from(options.settings);
    const LimitsCheck limits = limits_check(options.limits);
    show_reading(options.quiet);
    RobotDescription description = open_robot(options.robot);
    RobotWorld environment = open_robot_world(options.robot, settings);
    if (!options.quiet) print_warnings(environment.scene);
    check_pairs(options.robot, options.no_self, description, environment.scene.size());
    Robot robot(environment.world(), std::move(description), base_of(options.robot));
    set_padding(options.padding, environment, robot);
    const std::vector<double> numbers = open_configurations(options.configurations, robot);
    const std::size_t width = robot.width(), count = width ? numbers.size() / width : 1;
    check_limits(limits, robot, numbers, options.quiet);
    if (options.path && count < 2)
        throw Error(ErrorKind::usage, "--path: needs two configurations or more (--configurations)");
    if (!options.quiet) tell_links_without_geometry(robot.description());
    const std::size_t items = options.path ? count - 1 : count;
    Checked checked{environment, robot, options.path, std::vector<RobotFinding>(items), {}};
    const RobotCheck pairs{.self = !options.no_self};
    const std::span<const double> all(numbers);
    const auto findings = [&](std::size_t begin, std::size_t end) {
        return std::span(checked.findings).subspan(begin, end - begin);
    };
    if (options.path) {
        checked.edges.resize(items);
        const auto threads = static_cast<std::size_t>(thread_count(settings));
        check_in_chunks(checked, items, threads, [&](std::size_t begin, std::size_t end) {
            const std::size_t numbers_of_them = (end - begin) * width;
            const auto edges = std::span(checked.edges).subspan(begin, end - begin);
            robot.check_edges(environment.world(), all.subspan(begin * width, numbers_of_them),
                              all.subspan((begin + 1) * width, numbers_of_them), edges, {.pairs = pairs});
            std::ranges::transform(edges, findings(begin, end).begin(), [](const RobotEdgeFinding& edge) {
                return RobotFinding{0, edge.verdict, edge.link, edge.other, edge.body};
            });
        });
    } else {
        check_in_chunks(checked, items, 1024, [&](std::size_t begin, std::size_t end) {
            robot.check(environment.world(), all.subspan(begin * width, (end - begin) * width), findings(begin, end),
                        pairs);
        });
    }
    write_all({[&] {
                   if (!options.json.empty()) write_json(options.json, checked);
               },
               [&] {
                   if (!options.csv.empty()) write_csv(options.csv, checked);
               }});
    if (!options.quiet) write_to_stdout(described(checked), options.json == "-" || options.csv == "-");
    const int code = say_file_faults(environment.world());
    if (checked.interrupted) {
        std::vector<std::string> files;
        for (const std::string& file : {options.json, options.csv})
            if (!file.empty()) files.push_back(file == "-" ? "standard output" : file);
        log(LogLevel::error,
            fmt::format("interrupted after {} of {} {}s{}", checked.findings.size(), items, checked.item(),
                        files.empty() ? "" : "; their results are in " + listed(files)));
        return interrupted_code;
    }
    if (code) return code;
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
    sub.add_option("--limits ignore|warn|refuse", options->limits,
                   "configurations out of the limits of a joint (default warn)");
    sub.add_flag("--path", options->path, "check the whole motions from each configuration to the next, without gaps");
    sub.add_flag("--no-self", options->no_self, "only against the environment");
    add_padding_options(sub, options->padding);
    add_accuracy_options(sub, options->settings);
    add_pipeline_options(sub, options->settings);
    sub.add_option("--json FILE", options->json, "write the results as JSON; '-' is standard output");
    sub.add_option("--csv FILE", options->csv, "write the results as CSV; '-' is standard output");
    sub.add_flag("--quiet", options->quiet, "print only errors; the exit code is the result");
    sub.footer("Exit codes: 0 all configurations or motions separate, 1 one or more colliding, 2 one or more within or "
               "undecided,\n"
               "64 and above: error. Ctrl-C stops early; the results so far are written, and the exit code is 130.\n"
               "Examples:\n"
               "  oncollide robot panda.urdf --srdf panda.srdf --state ready\n"
               "  oncollide robot panda.urdf --srdf panda.srdf --world shelf.json --group panda_arm \\\n"
               "    --configurations samples.npy --threads 0 --json results.json\n"
               "  oncollide robot panda.urdf --srdf panda.srdf --world shelf.json --configurations plan.csv --path");
    sub.action([options] { return check_robot(*options); });
}

} // namespace oncollide::tools

#include "bench/scenes/scene_race.hpp"

#include <algorithm>

#include <oncollide/pipeline/result_hash.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>

#include "cli/system.hpp"

namespace oncollide::tools {
namespace {

/// The figures of a frame, as in the CSV.
Figures figures_of(const SceneRow& r, int frame)
{
    const Comparison& c = r.counts;
    const TreeStats& t = r.trees;
    return figures("frame", frame, "fcl_ms", r.fcl_ms, "fcl_transforms_ms", r.fcl_parts[0], "fcl_update_ms",
                   r.fcl_parts[1], "fcl_pairs_ms", r.fcl_parts[2], "fcl_narrow_ms", r.fcl_parts[3], "fcl_candidates",
                   r.fcl_candidates, "fcl_colliding", c.fcl_colliding, "fcl_contacts", r.fcl_contacts, "ms", r.our_ms,
                   "bounds_ms", r.our_parts[0], "delimitation_ms", r.our_parts[1], "broad_ms", r.our_parts[2],
                   "ocst_ms", r.our_parts[3], "exact_ms", r.our_parts[4], "contacts_ms", r.contacts_ms, "candidates",
                   c.pairs, "left_over", c.left_over, "colliding", c.colliding, "undecided", c.undecided, "contacts",
                   r.our_contacts, "false_positives", c.false_positives, "missed", c.missed, "cells", t.nodes,
                   "cells_asked", t.rows, "cell_pairs", t.node_pairs, "bytes", t.bytes, "rounds", t.rounds, "gpu_ms",
                   r.gpu_ms, "wait_ms", r.wait_ms, "gpu_bytes", t.gpu_bytes, "queries", t.queries, "hash", Hex{r.hash},
                   "regions", r.regions, "left", r.left, "narrowed", t.narrowed, "by_gap", t.by_gap, "by_hull",
                   t.by_hull, "by_inner_spheres", t.by_inner_spheres, "by_witness", t.by_witness);
}

/// The mean of a figure over the frames.
std::string mean_of(std::span<const SceneRow> frames, std::string_view name)
{
    double sum = 0;
    for (const SceneRow& row : frames)
        for (const Figure& figure : figures_of(row, 0))
            if (figure.name == name) sum += number_of(figure);
    return plain_measure(sum / double(frames.size()), 4);
}

/// The same of several, with their titles: "bounds, ms 0.0932; broad, ms 0.0081".
std::string means(std::span<const SceneRow> frames, std::initializer_list<std::string_view> names)
{
    std::string text;
    for (const std::string_view name : names)
        text += fmt::format("{}{} {}", text.empty() ? "" : "; ", title_of(name), mean_of(frames, name));
    return text;
}

/// The results of a race on a scene, as text and CSV.
class SceneReport {
public:
    SceneReport(const CompareOptions& options, const Settings& settings, const Scene& scene, const SceneRuns& runs)
        : options_(options), settings_(settings), scene_(scene), runs_(runs), with_fcl_(options.only != "oncollide"),
          with_ours_(options.only != "fcl")
    {
    }

    /// Returns the number of collisions that oncollide missed or reported wrongly.
    std::uint64_t print() const
    {
        print_head();
        print_times();
        const std::uint64_t faults = print_counts();
        if (options_.timeline) print_timeline();
        return faults;
    }

    void write_csv() const
    {
        ResultTable table(
            options_.csv, {},
            shard_from(options_.shard)
                .line(fmt::format("bench scene {}, {} bodies, {} frames, pace {}, settings {:016x}, only {}",
                                  scene_.name, scene_.size(), scene_.frames, scene_.pace, hash_of(settings_),
                                  options_.only)));
        int frame = runs_.first;
        for (SceneRow row : runs_.rows) {
            if (!with_fcl_) row.fcl_ms = 0;
            if (!with_ours_) row.our_ms = 0;
            table.row({}, figures_of(row, frame++));
        }
        table.commit();
    }

    void write_summary() const
    {
        std::vector<double> fcl, ours;
        Comparison sum;
        for (const SceneRow& row : counted()) fcl.push_back(row.fcl_ms), ours.push_back(row.our_ms), sum += row.counts;
        std::uint64_t missed = 0;
        for (const SceneRow& row : runs_.rows) missed += row.counts.missed + row.counts.wrong_exact;
        const double n = double(counted().size());
        const auto of_fcl = [&](double value) { return with_fcl_ ? std::optional(value) : std::nullopt; };
        const auto of_ours = [&](double value) { return with_ours_ ? std::optional(value) : std::nullopt; };
        ResultTable table(options_.summary);
        table.row({},
                  figures("scene", scene_.name, "bodies", scene_.size(), "triangles", triangles(), "exact",
                          name_of(settings_.exact), "threads", settings_.threads, "frames", counted().size(), "only",
                          options_.only, "fcl_first_ms", of_fcl(median(runs_.fcl_cold)), "fcl_ms", of_fcl(mean(fcl)),
                          "fcl_median_ms", of_fcl(median(fcl)), "fcl_mb", of_fcl(1e-6 * double(runs_.fcl_bytes.obb)),
                          "first_ms", of_ours(median(runs_.our_cold)), "ms", of_ours(mean(ours)), "median_ms",
                          of_ours(median(ours)), "slowest_ms", of_ours(*std::ranges::max_element(ours)), "trees_mb",
                          of_ours(1e-6 * double(runs_.our_bytes)), "process_mb", 1e-6 * double(peak_memory()),
                          "colliding", double(with_fcl_ ? sum.fcl_colliding : sum.colliding) / n, "false_positives",
                          double(sum.false_positives) / n, "missed", missed, "hash", Hex{runs_.hash}));
        table.commit();
    }

private:
    struct InMeshes {
        std::size_t triangles = 0, bytes = 0;
    };

    void print_head() const
    {
        say("scene      {}, {} bodies, {} geometries of {} triangles in total; frames {} to {}, {} before them to warm "
            "up, least of {} {}\n"
            "settings   {}\n{}\n",
            printable(scene_.name), grouped(scene_.size()), scene_.geometries.size(), grouped(triangles()),
            runs_.first + options_.warm_up, runs_.first + int(runs_.rows.size()) - 1, options_.warm_up,
            options_.repeats, options_.repeats == 1 ? "run" : "runs", describe(settings_),
            describe_program(runs_.backend));
    }

    std::span<const SceneRow> counted() const
    {
        return std::span(runs_.rows).subspan(static_cast<std::size_t>(options_.warm_up));
    }

    void print_times() const
    {
        std::vector<double> fcl, ours, ratios;
        for (const SceneRow& row : counted())
            fcl.push_back(row.fcl_ms), ours.push_back(row.our_ms), ratios.push_back(row.fcl_ms / row.our_ms);
        ResultTable table({}, {17});
        const auto line = [&](const char* who, const std::vector<double>& ms, const std::vector<double>& cold) {
            table.print(figures("per_frame", who, "median_ms", median(ms), "mean_ms", mean(ms), "frames_per_s",
                                1e3 / mean(ms), "cold_start_ms", median(cold)));
        };
        if (with_fcl_) line("FCL", fcl, runs_.fcl_cold);
        if (with_ours_) line("oncollide", ours, runs_.our_cold);
        if (with_fcl_ && with_ours_) // of medians: the median of the frames' ratios
            table.print(figures("per_frame", "FCL / oncollide", "median_ms", median(ratios), "mean_ms",
                                mean(fcl) / mean(ours), "frames_per_s", std::optional<double>(), "cold_start_ms",
                                median(runs_.fcl_cold) / median(runs_.our_cold)));
    }

    std::uint64_t print_counts() const
    {
        say("\nmeans per frame\n");
        if (with_fcl_)
            say("  FCL        {}\n", means(counted(), {"fcl_transforms_ms", "fcl_update_ms", "fcl_pairs_ms",
                                                       "fcl_narrow_ms", "fcl_candidates", "fcl_colliding"}));
        if (with_ours_)
            say("  oncollide  {}\n             {}\n",
                means(counted(), {"bounds_ms", "delimitation_ms", "broad_ms", "ocst_ms", "exact_ms", "contacts_ms"}),
                means(counted(), {"candidates", "left_over", "colliding", "undecided", "cell_pairs", "cells_asked"}));
        if (options_.contacts)
            say("  contacts   FCL {}, oncollide {} pairs of triangles\n", mean_of(counted(), "fcl_contacts"),
                mean_of(counted(), "contacts"));
        if (with_ours_)
            for (const auto& [what, rows] :
                 {std::pair("rounds     ", counted()), std::pair("at first   ", std::span(runs_.rows).first(1))})
                say("  {}{}\n", what,
                    means(rows, {"rounds", "cells_asked", "gpu_ms", "wait_ms", "gpu_bytes", "queries"}));
        const std::uint64_t faults = with_fcl_ && with_ours_ ? print_faults() : 0;
        print_memory();
        if (with_ours_) say("hash       {:016x}\n", runs_.hash);
        return faults;
    }

    std::uint64_t print_faults() const
    {
        Comparison all; // missed collisions count in every frame
        for (const SceneRow& row : runs_.rows) all += row.counts;
        say("  oncollide  {}; in all frames: missed {}, within FCL's rounding {}, wrong exact results {}\n",
            means(counted(), {"false_positives"}), all.missed, all.missed_by_rounding, all.wrong_exact);
        if (all.missed) say("MISSED     {}\n", all.first_missed);
        return all.missed + all.wrong_exact;
    }

    void print_memory() const
    {
        std::uint64_t nodes = 0;
        for (const SceneRow& row : counted()) nodes = std::max(nodes, row.trees.nodes);
        say("\nmemory     ");
        if (with_ours_) say("trees {:.3f} MB at most ({} cells); ", double(runs_.our_bytes) / 1e6, grouped(nodes));
        if (with_fcl_) say("FCL models {:.3f} MB; ", double(runs_.fcl_bytes.obb) / 1e6);
        say("process {:.1f} MB at its peak{}\n", double(peak_memory()) / 1e6,
            with_fcl_ && with_ours_ ? " (both; --only measures one)" : "");
        if (const auto [meshed, bytes] = in_meshes(); meshed && meshed == triangles()) {
            const auto each = [count = double(meshed)](std::size_t all) { return double(all) / count; };
            say("           bytes per triangle:");
            if (with_ours_)
                say(" trees {:.0f}, with the meshes {:.0f};", each(runs_.our_bytes), each(runs_.our_bytes + bytes));
            if (with_fcl_)
                say(" FCL models {:.0f}, with OBBRSS {:.0f};", each(runs_.fcl_bytes.obb), each(runs_.fcl_bytes.obbrss));
            say(" vertices and triangles {:.0f}\n", each(bytes));
        }
    }

    InMeshes in_meshes() const
    {
        InMeshes sum;
        for (const Geometry& geometry : scene_.geometries)
            if (const auto* mesh = std::get_if<Mesh>(&geometry.data)) {
                sum.triangles += mesh->triangles.size();
                sum.bytes +=
                    mesh->triangles.size() * sizeof(Triangle) + mesh->vertices.size() * sizeof(Eigen::Vector3d);
            }
        return sum;
    }

    std::uint64_t triangles() const
    {
        std::uint64_t sum = 0;
        for (const Geometry& geometry : scene_.geometries) {
            if (const auto* mesh = std::get_if<Mesh>(&geometry.data)) sum += mesh->triangles.size();
            if (const auto* terrain = std::get_if<Terrain>(&geometry.data)) sum += 2 * terrain->cells();
            if (const auto* cooked = std::get_if<std::shared_ptr<const CookedMesh>>(&geometry.data))
                sum += (*cooked)->triangles();
        }
        return sum;
    }

    void print_timeline() const
    {
        ResultTable table;
        say("\n");
        for (std::size_t from = 0; from < runs_.rows.size(); from += static_cast<std::size_t>(options_.timeline)) {
            const std::size_t to = std::min(from + static_cast<std::size_t>(options_.timeline), runs_.rows.size());
            std::uint64_t requested = 0, dropped = 0;
            double ours = 0, fcl = 0;
            for (std::size_t f = from; f < to; ++f) {
                requested += runs_.rows[f].trees.rows, dropped += runs_.rows[f].trees.collapsed;
                ours += runs_.rows[f].our_ms / double(to - from), fcl += runs_.rows[f].fcl_ms / double(to - from);
            }
            const SceneRow& last = runs_.rows[to - 1];
            table.print(figures("frame", to - 1, "cells", last.trees.nodes, "left_over", last.counts.left_over,
                                "fcl_colliding", last.counts.fcl_colliding, "requested", requested, "dropped", dropped,
                                "ms", ours, "fcl_ms", fcl));
        }
    }

    const CompareOptions& options_;
    const Settings& settings_;
    const Scene& scene_;
    const SceneRuns& runs_;
    const bool with_fcl_, with_ours_;
};

} // namespace

std::uint64_t report(const CompareOptions& options, const Settings& settings, const Scene& scene, const SceneRuns& runs)
{
    const SceneReport report(options, settings, scene, runs);
    const std::uint64_t faults = report.print();
    if (!options.csv.empty()) report.write_csv();
    if (!options.summary.empty()) report.write_summary();
    return faults;
}

} // namespace oncollide::tools

#include "bench/scenes/scene_report.hpp"

#include <algorithm>

#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/pipeline/result_hash.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>

#include "cli/outputs.hpp"
#include "cli/shard.hpp"
#include "cli/system.hpp"
#include "common/statistics.hpp"
#include "common/text.hpp"

namespace oncollide::tools {

std::uint64_t SceneReport::print() const
{
    print_head();
    print_times();
    const std::uint64_t faults = print_counts();
    if (options_.timeline) print_timeline();
    return faults;
}

void SceneReport::print_head() const
{
    say("scene      {}, {} bodies, {} geometries of {} triangles in total; frames {} to {}, {} before them to warm "
        "up, least of {} {}\n"
        "settings   {}\n{}\n",
        printable(scene_.name), grouped(scene_.size()), scene_.geometries.size(), grouped(triangles()),
        runs_.first + options_.warm_up, runs_.first + int(runs_.rows.size()) - 1, options_.warm_up, options_.repeats,
        options_.repeats == 1 ? "run" : "runs", describe(settings_), describe_program(runs_.backend));
}

std::span<const SceneRow> SceneReport::counted() const
{
    return std::span(runs_.rows).subspan(static_cast<std::size_t>(options_.warm_up));
}

void SceneReport::print_times() const
{
    std::vector<double> fcl, ours, ratios;
    std::array<double, 4> fcl_parts{};
    std::array<double, stage_count> our_parts{};
    double contacts = 0;
    for (const SceneRow& row : counted()) {
        fcl.push_back(row.fcl_ms), ours.push_back(row.our_ms), ratios.push_back(row.fcl_ms / row.our_ms);
        for (std::size_t i = 0; i < fcl_parts.size(); ++i) fcl_parts[i] += row.fcl_parts[i];
        for (std::size_t i = 0; i < stage_count; ++i) our_parts[i] += row.our_parts[i];
        contacts += row.contacts_ms;
    }
    const double n = double(counted().size());
    say("{:<17}{:>12}{:>12}{:>14}{:>24}\n", "ms per frame", "median", "mean", "frames/s", "first, cold start");
    const auto line = [](const char* who, const std::vector<double>& ms, const std::vector<double>& cold) {
        say("{:<17}{:>12.4f}{:>12.4f}{:>14.1f}{:>24.3f}\n", who, median(ms), mean(ms), 1e3 / mean(ms), median(cold));
    };
    if (with_fcl_) line("FCL", fcl, runs_.fcl_cold);
    if (with_ours_) line("oncollide", ours, runs_.our_cold);
    if (with_fcl_ && with_ours_)
        say("{:<17}{:>12.2f}{:>12.2f}{:>14}{:>24.2f}   (median of the frames' ratios; ratio of the totals)\n",
            "FCL / oncollide", median(ratios), mean(fcl) / mean(ours), "",
            median(runs_.fcl_cold) / median(runs_.our_cold));
    say("\ntime by part, mean ms\n");
    if (with_fcl_)
        say("  FCL        transforms {:.4f}, tree update {:.4f}, pairs {:.4f}, narrow {:.4f}\n", fcl_parts[0] / n,
            fcl_parts[1] / n, fcl_parts[2] / n, fcl_parts[3] / n);
    if (with_ours_)
        say("  oncollide  bounds {:.4f}, delimitation {:.4f}, broad {:.4f}, refine {:.4f}, exact {:.4f}",
            our_parts[0] / n, our_parts[1] / n, our_parts[2] / n, our_parts[3] / n, our_parts[4] / n);
    if (with_ours_ && options_.contacts) say(", contacts {:.4f}", contacts / n);
    say("\n\n");
}

std::uint64_t SceneReport::print_counts() const
{
    Comparison sum;
    std::uint64_t fcl_candidates = 0, node_pairs = 0, nodes = 0, rows = 0;
    for (const SceneRow& row : counted()) {
        sum += row.counts, fcl_candidates += row.fcl_candidates;
        node_pairs += row.trees.node_pairs, rows += row.trees.rows, nodes = std::max(nodes, row.trees.nodes);
    }
    const std::uint64_t n = counted().size();
    say("pairs, mean per frame\n");
    if (with_fcl_)
        say("  FCL        candidates {}, colliding {}\n", mean_text(fcl_candidates, n),
            mean_text(sum.fcl_colliding, n));
    if (with_ours_)
        say("  oncollide  candidates {}, left over {} (colliding {}, undecided {}); cell pairs compared {}, cells "
            "requested {}\n",
            mean_text(sum.pairs, n), mean_text(sum.left_over, n), mean_text(sum.colliding, n),
            mean_text(sum.undecided, n), mean_text(node_pairs, n), mean_text(rows, n));
    if (options_.contacts) {
        std::uint64_t theirs = 0, ours = 0;
        for (const SceneRow& row : counted()) theirs += row.fcl_contacts, ours += row.our_contacts;
        say("  contacts   FCL {}, oncollide {} pairs of triangles\n", mean_text(theirs, n), mean_text(ours, n));
    }
    if (with_ours_) print_rounds();
    const std::uint64_t faults = with_fcl_ && with_ours_ ? print_faults(sum, n) : 0;
    print_memory(nodes);
    if (with_ours_) say("hash       {:016x}\n", runs_.hash);
    return faults;
}

std::uint64_t SceneReport::print_faults(const Comparison& sum, std::uint64_t frames) const
{
    Comparison all; // missed collisions count in every frame
    for (const SceneRow& row : runs_.rows) all += row.counts;
    say("  oncollide  false positives {} ({:.1f} % of pairs left over), missed {}, within FCL's rounding {}, wrong "
        "exact results {}\n",
        mean_text(sum.false_positives, frames),
        sum.left_over ? 100.0 * double(sum.false_positives) / double(sum.left_over) : 0.0, all.missed,
        all.missed_by_rounding, all.wrong_exact);
    if (all.missed) say("MISSED     {}\n", all.first_missed);
    return all.missed + all.wrong_exact;
}

void SceneReport::print_memory(std::uint64_t nodes) const
{
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

SceneReport::InMeshes SceneReport::in_meshes() const
{
    InMeshes sum;
    for (const Geometry& geometry : scene_.geometries)
        if (const auto* mesh = std::get_if<Mesh>(&geometry.data)) {
            sum.triangles += mesh->triangles.size();
            sum.bytes += mesh->triangles.size() * sizeof(Triangle) + mesh->vertices.size() * sizeof(Eigen::Vector3d);
        }
    return sum;
}

std::uint64_t SceneReport::triangles() const
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

/// Requests of the sphere-trees to the backend, in later frames and in the first.
void SceneReport::print_rounds() const
{
    std::uint64_t rounds = 0, rows = 0, bytes = 0, queries = 0;
    double gpu_ms = 0, wait_ms = 0;
    for (const SceneRow& row : counted()) {
        rounds += row.trees.rounds, rows += row.trees.rows;
        bytes += row.trees.gpu_bytes, queries += row.trees.queries, gpu_ms += row.gpu_ms, wait_ms += row.wait_ms;
    }
    const std::uint64_t n = counted().size();
    const SceneRow& first = runs_.rows.front();
    say("  rounds     {} per frame, {} cells per round; the first frame: {} rounds of {} cells\n", mean_text(rounds, n),
        mean_text(rows, rounds), first.trees.rounds, mean_text(first.trees.rows, first.trees.rounds));
    if (first.trees.gpu_bytes)
        say("  GPU        {:.3f} ms GPU time per frame, {:.3f} ms waiting for it, {} bytes moved, {} queries; the "
            "first "
            "frame: {:.3f}, {:.3f}, {}, {}\n",
            gpu_ms / double(n), wait_ms / double(n), mean_text(bytes, n), mean_text(queries, n), first.gpu_ms,
            first.wait_ms, grouped(first.trees.gpu_bytes), grouped(first.trees.queries));
}

void SceneReport::print_timeline() const
{
    say("\n{:>8}{:>14}{:>12}{:>14}{:>14}{:>12}{:>14}{:>14}\n", "frame", "cells alive", "left over", "FCL collides",
        "requested", "dropped", "oncollide ms", "FCL ms");
    for (std::size_t from = 0; from < runs_.rows.size(); from += static_cast<std::size_t>(options_.timeline)) {
        const std::size_t to = std::min(from + static_cast<std::size_t>(options_.timeline), runs_.rows.size());
        std::uint64_t requested = 0, dropped = 0;
        double ours = 0, fcl = 0;
        for (std::size_t f = from; f < to; ++f) {
            requested += runs_.rows[f].trees.rows, dropped += runs_.rows[f].trees.collapsed;
            ours += runs_.rows[f].our_ms / double(to - from), fcl += runs_.rows[f].fcl_ms / double(to - from);
        }
        const SceneRow& last = runs_.rows[to - 1];
        say("{:>8}{:>14}{:>12}{:>14}{:>14}{:>12}{:>14.5f}{:>14.5f}\n", to - 1, last.trees.nodes, last.counts.left_over,
            last.counts.fcl_colliding, requested, dropped, ours, fcl);
    }
}

void SceneReport::write_csv() const
{
    CsvFile csv(
        options_.csv,
        "frame,fcl_ms,fcl_transforms_ms,fcl_update_ms,fcl_pairs_ms,fcl_narrow_ms,fcl_candidates,fcl_colliding,"
        "ms,bounds_ms,delimitation_ms,broad_ms,ocst_ms,exact_ms,candidates,left_over,colliding,undecided,"
        "false_positives,missed,cells,cells_asked,cell_pairs,bytes,hash,regions,left,"
        "narrowed,by_gap,by_hull,by_inner_spheres,by_witness",
        shard_from(options_.shard)
            .line(fmt::format("bench scene {}, {} bodies, {} frames, pace {}, settings {:016x}, only {}", scene_.name,
                              scene_.size(), scene_.frames, scene_.pace, hash_of(settings_), options_.only)));
    for (std::size_t frame = 0; frame < runs_.rows.size(); ++frame) {
        const SceneRow& r = runs_.rows[frame];
        csv.rows().add(runs_.first + int(frame), with_fcl_ ? r.fcl_ms : 0);
        for (const double ms : r.fcl_parts) csv.rows().add(ms);
        csv.rows().add(r.fcl_candidates, r.counts.fcl_colliding, with_ours_ ? r.our_ms : 0);
        for (const double ms : r.our_parts) csv.rows().add(ms);
        csv.row(r.counts.pairs, r.counts.left_over, r.counts.colliding, r.counts.undecided, r.counts.false_positives,
                r.counts.missed, r.trees.nodes, r.trees.rows, r.trees.node_pairs, r.trees.bytes, Hex{r.hash}, r.regions,
                r.left, r.trees.narrowed, r.trees.by_gap, r.trees.by_hull, r.trees.by_inner_spheres, r.trees.by_witness);
    }
    csv.commit();
}

void SceneReport::write_summary() const
{
    std::vector<double> fcl, ours;
    Comparison sum;
    for (const SceneRow& row : counted()) fcl.push_back(row.fcl_ms), ours.push_back(row.our_ms), sum += row.counts;
    std::uint64_t missed = 0;
    for (const SceneRow& row : runs_.rows) missed += row.counts.missed + row.counts.wrong_exact;
    const double n = double(counted().size());
    CsvFile csv(options_.summary,
                "scene,bodies,triangles,exact,threads,frames,only,fcl_first_ms,fcl_ms,fcl_median_ms,fcl_mb,first_ms,"
                "ms,median_ms,slowest_ms,trees_mb,process_mb,colliding,false_positives,missed,hash");
    const auto of_fcl = [&](double value) { return with_fcl_ ? std::optional(value) : std::nullopt; };
    const auto of_ours = [&](double value) { return with_ours_ ? std::optional(value) : std::nullopt; };
    csv.row(Quoted{scene_.name}, scene_.size(), triangles(), name_of(settings_.exact), settings_.threads,
            counted().size(), options_.only, of_fcl(median(runs_.fcl_cold)), of_fcl(mean(fcl)), of_fcl(median(fcl)),
            of_fcl(double(runs_.fcl_bytes.obb) / 1e6), of_ours(median(runs_.our_cold)), of_ours(mean(ours)),
            of_ours(median(ours)), of_ours(*std::max_element(ours.begin(), ours.end())),
            of_ours(double(runs_.our_bytes) / 1e6), double(peak_memory()) / 1e6,
            double(with_fcl_ ? sum.fcl_colliding : sum.colliding) / n, double(sum.false_positives) / n, missed,
            Hex{runs_.hash});
    csv.commit();
}

} // namespace oncollide::tools

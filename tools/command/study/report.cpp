#include "study/report.hpp"

#include <algorithm>

#include <nlohmann/json.hpp>

#include <oncollide/runs/report.hpp>

#include "common/text.hpp"

namespace oncollide::tools {
namespace {

std::array<double, 5> mean_stages(const Study& study, const StudyRow& row)
{
    std::array<double, 5> mean{};
    for (std::size_t frame = std::size_t(study.warm_up); frame < row.stage_ms.size(); ++frame)
        for (std::size_t k = 0; k < mean.size(); ++k)
            mean[k] += row.stage_ms[frame][k] / double(row.stage_ms.size() - std::size_t(study.warm_up));
    return mean;
}

std::uint64_t count(const StudyRow& row, Verdict verdict)
{
    return row.verdicts[std::size_t(verdict)];
}

std::string false_positive_text(double distance, const StudyRow& row)
{
    return row.false_positives ? fmt::format("{:.3g}", distance) : "-";
}

nlohmann::ordered_json json_of(std::optional<double> number)
{
    return number ? nlohmann::ordered_json(*number) : nlohmann::ordered_json();
}

nlohmann::ordered_json json_of(const Study& study, const StudyPeer& peer)
{
    return {{"name", peer.name},
            {"ms_mean", study.mean_ms(peer.ms)},
            {"ms_median", study.median_ms(peer.ms)},
            {"times_fcl", json_of(study.ratio(peer.ms))},
            {"on_front", on_front(study, peer)},
            {"candidates", peer.candidates},
            {"colliding", peer.colliding},
            {"missed", peer.missed},
            {"invented", peer.invented},
            {"bytes", peer.bytes},
            {"errors", peer.errors}};
}

nlohmann::ordered_json json_of(const Study& study, const StudyRow& row)
{
    nlohmann::ordered_json stages;
    const std::array<double, 5> ms = mean_stages(study, row);
    for (std::size_t k = 0; k < row.stages.size(); ++k) {
        const StageStats& s = row.stages[k];
        stages.push_back({{"stage", s.stage}, {"ms", ms[k]}, {"in", s.in}, {"out", s.out}, {"skipped", s.skipped}});
    }
    return {{"variant", row.variant.name},
            {"backend", row.backend},
            {"certified", row.variant.certified()},
            {"error", row.error},
            {"ms_mean", study.mean_ms(row.ms)},
            {"ms_median", study.median_ms(row.ms)},
            {"times_fcl", json_of(study.ratio(row.ms))},
            {"on_front", on_front(study, row)},
            {"separate", count(row, Verdict::separate)},
            {"within", count(row, Verdict::within)},
            {"undecided", count(row, Verdict::undecided)},
            {"colliding", count(row, Verdict::colliding)},
            {"missed", row.missed},
            {"false_positives", row.false_positives},
            {"invented", row.wrong},
            {"bounds_broken", row.broken},
            {"false_positive_distance_median", false_positive_quantile(row, 0.5)},
            {"false_positive_distance_worst", false_positive_quantile(row, 1)},
            {"false_positives_by_tenth_of_bound", row.false_positives_by_share},
            {"node_pairs", row.trees.node_pairs},
            {"triangle_pairs", row.trees.triangle_pairs},
            {"queries", row.trees.queries},
            {"peak_bytes", row.trees.bytes},
            {"nodes_needed", row.nodes_needed},
            {"nodes_all", row.nodes_all ? nlohmann::ordered_json(*row.nodes_all) : nlohmann::ordered_json()},
            {"stages", stages}};
}

} // namespace

std::string needed_text(const StudyRow& row)
{
    if (!row.nodes_all || !*row.nodes_all) return "-";
    return fmt::format("{:.3g} %", 100 * double(row.nodes_needed) / double(*row.nodes_all));
}

std::string ratio_text(const Study& study, const std::vector<double>& ms)
{
    const std::optional<double> ratio = study.ratio(ms);
    return ratio ? fmt::format("{:.2f}", *ratio) : "-";
}

std::string error_text(const StudyRow& row)
{
    return fmt::format("{:.3g}", row.error);
}

double false_positive_quantile(const StudyRow& row, double q)
{
    if (row.false_positive_distances.empty()) return 0;
    std::vector<double> sorted = row.false_positive_distances;
    std::ranges::sort(sorted);
    return sorted[std::size_t(q * double(sorted.size() - 1))];
}

void print_study(const Study& study)
{
    const std::uint64_t n = std::uint64_t(study.frames);
    // Two tables: a single one would be wider than a terminal.
    say("{:<32}{:>10}{:>8}{:>11}{:>7}{:>10}{:>8}{:>8}\n", "speed and error", "error m", "% size", "ms mean", "x FCL",
        "left over", "false", "missed");
    for (const StudyRow& row : study.rows) {
        const std::uint64_t left_over =
            count(row, Verdict::within) + count(row, Verdict::undecided) + count(row, Verdict::colliding);
        say("{:<32}{:>10}{:>8.3g}{:>11.4f}{:>7}{:>10}{:>8}{:>8}{}\n", row.variant.name, error_text(row),
            100 * row.error / study.size, study.mean_ms(row.ms), ratio_text(study, row.ms), left_over,
            row.false_positives, row.missed, on_front(study, row) ? "  *" : "");
        if (row.wrong) say("FAULT      {}: {} collisions invented\n", row.variant.name, row.wrong);
        if (row.broken) say("FAULT      {}: {} bounds broken\n", row.variant.name, row.broken);
    }
    for (const StudyPeer& peer : study.peers)
        say("{:<32}{:>10}{:>8}{:>11.4f}{:>7}{:>10}{:>8}{:>8}{}\n", peer.name, 0, 0, study.mean_ms(peer.ms),
            ratio_text(study, peer.ms), peer.colliding, peer.invented, peer.missed, on_front(study, peer) ? "  *" : "");
    say("(left over: pairs that are not certified separate; false: pairs left over that are apart; * fastest at its "
        "error)\n\n");

    say("{:<32}{:>11}{:>10}{:>10}{:>11}{:>11}{:>9}{:>9}\n", "work per frame", "ms median", "at m", "worst m", "nodes",
        "triangles", "MB", "needed");
    for (const StudyRow& row : study.rows)
        say("{:<32}{:>11.4f}{:>10}{:>10}{:>11}{:>11}{:>9.3f}{:>9}\n", row.variant.name, study.median_ms(row.ms),
            false_positive_text(false_positive_quantile(row, 0.5), row),
            false_positive_text(false_positive_quantile(row, 1), row), mean_text(row.trees.node_pairs, n),
            mean_text(row.trees.triangle_pairs, n), double(row.trees.bytes) / 1e6, needed_text(row));
    for (const StudyPeer& peer : study.peers)
        say("{:<32}{:>11.4f}{:>51.3f}\n", peer.name, study.median_ms(peer.ms), double(peer.bytes) / 1e6);
    say("(at m: median distance of the false positives; nodes, triangles: tests; needed: share of the full trees that "
        "was reached)\n");
    for (const StudyPeer& peer : study.peers)
        for (const std::string& error : peer.errors) say("{:<10} {}\n", peer.name + " errs", error);
    if (study.contradicted)
        say("FAULT      the results in the pose file contradict the truth {} times\n", study.contradicted);
    say("(counts over all frames, tests: mean per frame)\n");
}

void write_study_csv(OutputFile& file, const Study& study)
{
    CsvWriter csv(
        file, "variant,backend,certified,error,ms_mean,ms_median,times_fcl,on_front,bounds_ms,delimitation_ms,broad_ms,"
              "ocst_ms,exact_ms,separate,within,undecided,colliding,missed,false_positives,invented,bounds_broken,"
              "false_positive_median,false_positive_worst,node_pairs,triangle_pairs,queries,peak_bytes,nodes_needed,"
              "nodes_all,truly_colliding");
    for (const StudyRow& row : study.rows) {
        csv.add(Quoted{row.variant.name}, Quoted{row.backend}, row.variant.certified(), row.error,
                study.mean_ms(row.ms), study.median_ms(row.ms), study.ratio(row.ms).value_or(0), on_front(study, row));
        for (const double ms : mean_stages(study, row)) csv.add(ms);
        csv.row(count(row, Verdict::separate), count(row, Verdict::within), count(row, Verdict::undecided),
                count(row, Verdict::colliding), row.missed, row.false_positives, row.wrong, row.broken,
                false_positive_quantile(row, 0.5), false_positive_quantile(row, 1), row.trees.node_pairs,
                row.trees.triangle_pairs, row.trees.queries, row.trees.bytes, row.nodes_needed, row.nodes_all,
                study.colliding);
    }
    const auto none = std::nullopt;
    for (const StudyPeer& peer : study.peers)
        csv.row(Quoted{peer.name}, Quoted{""}, 0, 0, study.mean_ms(peer.ms), study.median_ms(peer.ms),
                study.ratio(peer.ms).value_or(0), on_front(study, peer), none, none, none, none, none, none, none, none,
                peer.colliding, peer.missed, none, peer.invented, none, none, none, none, none, none, peer.bytes, none,
                none, study.colliding);
}

void write_study_json(OutputFile& file, const Study& study, const std::string& program)
{
    nlohmann::ordered_json json{{"schema", "oncollide.accuracy_study"},
                                {"schema_version", 1},
                                {"header",
                                 {{"version", version},
                                  {"title", study.title},
                                  {"program", program},
                                  {"bodies", study.bodies},
                                  {"frames", study.frames},
                                  {"warm_up", study.warm_up},
                                  {"size", study.size},
                                  {"colliding", study.colliding}}}};
    for (const StudyRow& row : study.rows) json["variants"].push_back(json_of(study, row));
    json["peers"] = nlohmann::ordered_json::array();
    for (const StudyPeer& peer : study.peers) json["peers"].push_back(json_of(study, peer));
    json["left_out"] = study.left_out;
    file.print("{}\n", json.dump(1, ' ', false, nlohmann::json::error_handler_t::replace));
}

} // namespace oncollide::tools

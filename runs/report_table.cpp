#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/runs/report_kept.hpp>

#include <oncollide/base/text/listed.hpp>
#include <oncollide/base/text/plain_number.hpp>
#include <oncollide/base/text/printable.hpp>

#include <algorithm>
#include <cmath>
#include <ostream>

#include <fmt/format.h>

namespace oncollide {
namespace {

/// The input of a stage in plain words, with the name used by --skip and results in brackets.
std::string plain_words(std::string_view stage)
{
    std::string_view words = stage;
    if (stage == "bounds") words = "boxes";
    if (stage == "delimitation") words = "regions";
    if (stage == "broad") words = "pairs of boxes";
    if (stage == "refine") words = "refinement";
    if (stage == "exact") words = "triangles";
    return fmt::format("{} ({})", words, stage);
}

/// `text` right-aligned in a column, with a leading space even if it is too wide.
std::string cell(const std::string& text)
{
    return fmt::format(" {:>10}", text);
}

} // namespace

std::string bytes_text(std::size_t bytes)
{
    if (bytes < 10'000) return fmt::format("{} bytes", bytes);
    if (bytes < 10'000'000) return fmt::format("{:.1f} kB", double(bytes) / 1e3);
    return fmt::format("{:.1f} MB", double(bytes) / 1e6);
}

namespace {

/// "a and b, crossing, from frame 12"
std::string pair_text(const Scene& scene, const PairList::Entry& entry, bool one_frame)
{
    const PairResult& pair = entry.pair;
    std::string text = fmt::format("'{}' and '{}'", shortened(scene.label(SceneBodyId{pair.a.slot})),
                                   shortened(scene.label(SceneBodyId{pair.b.slot})));
    if (pair.kind != ContactKind::unknown) text += fmt::format(", {}", name_of(pair.kind));
    if (pair.verdict == Verdict::undecided) text += ", undecided";
    if (pair.verdict != Verdict::colliding && std::isfinite(pair.bound))
        text += fmt::format(", at most {} m apart", plain_measure(pair.bound, 4));
    if (!one_frame) text += fmt::format(", from frame {}", entry.frame);
    return printable(text);
}

std::string list_text(const Scene& scene, const PairList& list, const char* one, const char* many, bool one_frame,
                      bool listed)
{
    if (list.size() == 0) return {};
    std::string text =
        fmt::format("\n{}{} {}\n", list.full() ? "at least " : "", grouped(list.size()), list.size() == 1 ? one : many);
    for (const PairList::Entry& entry : list.first()) text += "  " + pair_text(scene, entry, one_frame) + "\n";
    if (list.size() > list.first().size())
        text += fmt::format("  and {} more{}\n", grouped(list.size() - list.first().size()),
                            listed ? "" : "; --csv FILE writes them all");
    return text;
}

} // namespace

std::string stage_table(std::span<const StageStats> totals)
{
    std::string text = fmt::format("{:<24}{:<8}{:>11}{:>11}{:>11}{:>11}{:>11}\n", "stage, mean per frame", "counts",
                                   "in", "out", "ruled out", "undecided", "ms");
    for (const StageStats& s : totals) {
        text += fmt::format("{:<24}{:<8}{}{}{}{}{}{}\n", plain_words(s.stage), s.unit, cell(mean_text(s.in, s.frames)),
                            cell(mean_text(s.out, s.frames)), cell(mean_text(s.culled, s.frames)),
                            cell(mean_text(s.undecided, s.frames)),
                            cell(fmt::format("{:.3f}", s.frames ? s.cpu_ms / double(s.frames) : 0.0)),
                            s.skipped ? fmt::format("   skipped: {}", s.note.empty() ? "by request" : s.note) : "");
    }
    return text;
}

std::string verdict_line(const std::array<std::uint64_t, 4>& counts)
{
    return fmt::format("verdicts   {} colliding, {} within their bound, {} undecided, {} separate (over all frames)\n",
                       grouped(counts[int(Verdict::colliding)]), grouped(counts[int(Verdict::within)]),
                       grouped(counts[int(Verdict::undecided)]), grouped(counts[int(Verdict::separate)]));
}

void Report::print_table(std::ostream& out) const
{
    std::string text = printable(title()) + "\n\n";
    text += stage_table(totals_);
    text += fmt::format("\nframe      {:.3f} ms on average, {:.3f} ms the slowest\n",
                        frames_ == 0 ? 0.0 : ms_ / double(frames_), slowest_ms_);
    text += verdict_line(verdicts());
    if (kinds_[int(ContactKind::unknown)] < pairs_ || wants_kinds(pipeline_.settings()))
        text += fmt::format("contacts   {} touching{}, {} crossing, {} enclosed, {} near; others not classified\n",
                            grouped(kinds_[int(ContactKind::touching)]),
                            pipeline_.settings().ignore_touching ? " (ignored)" : "",
                            grouped(kinds_[int(ContactKind::crossing)]), grouped(kinds_[int(ContactKind::enclosed)]),
                            grouped(kinds_[int(ContactKind::near)]));
    if (trees_.narrowed)
        text += fmt::format(
            "pairs      {} in OBB trees or exact tests; decided by: gap of an earlier frame {}, outer hulls {}, "
            "inner spheres {}, last witness {}, traversal {}\n",
            grouped(trees_.narrowed), grouped(trees_.by_gap), grouped(trees_.by_hull), grouped(trees_.by_inner_spheres),
            grouped(trees_.by_witness),
            grouped(trees_.narrowed - trees_.by_gap - trees_.by_hull - trees_.by_inner_spheres - trees_.by_witness));
    if (trees_.kept)
        text += fmt::format("at rest    {} pairs kept the result of the last frame\n", grouped(trees_.kept));
    text += fmt::format("trees      {} cells requested in {} rounds; at the end {} cells, {}", grouped(trees_.rows),
                        grouped(trees_.rounds), grouped(trees_.nodes), bytes_text(trees_.bytes));
    text += trees_.refused ? fmt::format("; {} cells refused by a budget\n", grouped(trees_.refused)) : "\n";
    double gpu_ms = 0, wait_ms = 0;
    for (const StageStats& s : totals_) gpu_ms += s.gpu_ms, wait_ms += s.wait_ms;
    if (trees_.gpu_bytes) {
        const double n = double(frames_);
        text += fmt::format(
            "gpu        {:.3f} ms busy per frame, {:.3f} ms per frame waiting for it; {} transferred in total",
            gpu_ms / n, wait_ms / n, bytes_text(trees_.gpu_bytes));
        if (trees_.queries) text += fmt::format("; {} occlusion queries", grouped(trees_.queries));
        text +=
            trees_.repeats ? fmt::format("; {} batches repeated with larger buffers\n", grouped(trees_.repeats)) : "\n";
    }
    if (!backend_note_.empty()) text += "note       " + backend_note_ + "\n";
    text += fmt::format("hash       {:016x}\n", hash_);
    const bool listed = kept_->csv || kept_->json, exact = exact_runs(pipeline_.settings());
    text += list_text(scene_, kept_->colliding, "pair collides:", "different pairs collide:", frames_ == 1, listed);
    text += list_text(scene_, kept_->unsure,
                      exact ? "pair is close or undecided:" : "pair may or may not collide (--exact on decides):",
                      exact ? "different pairs are close or undecided:"
                            : "different pairs may or may not collide (--exact on decides):",
                      frames_ == 1, listed);
    out << text;
}

} // namespace oncollide

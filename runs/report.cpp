#include <oncollide/runs/report_kept.hpp>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/threads/parallel.hpp>

#include <algorithm>
#include <cmath>

#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/pipeline/settings_table.hpp>
#include <oncollide/pipeline/world/world_access.hpp>

namespace oncollide {
namespace {

constexpr Verdict verdict_order[] = {Verdict::separate, Verdict::within, Verdict::colliding, Verdict::undecided};
constexpr ContactKind kind_order[] = {ContactKind::near, ContactKind::touching, ContactKind::crossing,
                                      ContactKind::enclosed};

template <class Name, std::size_t shown, std::size_t all>
void write_counts(JsonWriter& json, const Name (&names)[shown], const std::array<std::uint64_t, all>& counts)
{
    json.begin_object();
    for (const Name name : names) json.members(name_of(name), counts[std::size_t(name)]);
    json.end_object();
}

/// The bodies' names, quoted once instead of once per row.
template <class Quote>
std::vector<std::string> quote_all(const Scene& scene, Quote quote)
{
    std::vector<std::string> result;
    for (std::uint32_t body = 0; body < scene.size(); ++body) result.push_back(quote(scene.label(SceneBodyId{body})));
    return result;
}

void refuse_unless(bool kept, std::string_view what)
{
    if (!kept) throw Error(ErrorKind::usage, fmt::format("report: {} was not requested in ReportParts", what));
}

void copy(const Spool& from, OutputFile& to)
{
    from.read([&](std::string_view piece) { to.write(piece); });
}

} // namespace

std::string settings_json(const Settings& s)
{
    std::string text = "{";
    for (const SettingRow& row : settings_table())
        text += fmt::format("{}\"{}\": {}", text.size() > 1 ? ", " : "", row.key, row.get(s));
    return text + "}";
}

void add_csv_cells(CsvWriter& csv, std::uint64_t frame, const std::string& a, const std::string& b,
                   const PairResult& pair, std::string_view stage, double max_error)
{
    csv.add(frame, CsvField{a}, CsvField{b}, name_of(pair.verdict),
            std::isfinite(pair.bound) ? std::optional(pair.bound) : std::nullopt, stage,
            pair.kind == ContactKind::unknown ? "" : name_of(pair.kind), max_error);
}

Report::Report(const Scene& scene, const Pipeline& pipeline, const ReportParts& parts)
    : scene_(scene), pipeline_(pipeline), separate_(parts.separate), kept_(std::make_unique<Kept>())
{
    if (parts.json) kept_->json.emplace(parts.folder).names = quote_all(scene, json_string);
    if (parts.csv)
        kept_->csv.emplace(parts.folder).names = quote_all(scene, [](const std::string& n) { return csv_field(n); });
    if (parts.trace) kept_->trace.emplace(parts.folder);
    look_at_pipeline(pipeline.inspect().totals);
}

Report::~Report() = default;

void Report::add(const FrameView& frame)
{
    Verdicts verdicts{};
    for (const PairResult& pair : frame.pairs) {
        ++verdicts[int(pair.verdict)], ++kinds_[int(pair.kind)];
        pairs_ += keeps(pair);
        if (pair.verdict != Verdict::separate)
            (pair.verdict == Verdict::colliding ? kept_->colliding : kept_->unsure).add(pair, frame.frame);
    }
    for (std::size_t k = 0; k < verdicts.size(); ++k) verdicts_[k] += verdicts[k];
    if (kept_->json) add_json(frame, verdicts);
    if (kept_->csv) add_csv(frame);
    if (kept_->trace) add_trace(frame, verdicts);
    add_sums(frame);
    look_at_pipeline(frame.totals);
}

void Report::look_at_pipeline(std::span<const StageStats> totals)
{
    hash_ = pipeline_.hash();
    totals_.assign(totals.begin(), totals.end());
    const World& world = pipeline_.world();
    backend_ = WorldAccess::backend(world), renderer_ = WorldAccess::renderer(world);
    backend_note_ = WorldAccess::backend_note(world);
}

void Report::add_sums(const FrameView& frame)
{
    ++frames_;
    ms_ += frame.ms, slowest_ms_ = std::max(slowest_ms_, frame.ms);
    const TreeStats& trees = frame.trees;
    trees_.rounds += trees.rounds, trees_.rows += trees.rows;
    trees_.node_pairs += trees.node_pairs, trees_.triangle_pairs += trees.triangle_pairs;
    trees_.unsure_pairs += trees.unsure_pairs;
    trees_.kept += trees.kept;
    trees_.narrowed += trees.narrowed, trees_.by_gap += trees.by_gap, trees_.by_hull += trees.by_hull,
        trees_.by_inner_spheres += trees.by_inner_spheres, trees_.by_witness += trees.by_witness;
    trees_.collapsed += trees.collapsed, trees_.refused += trees.refused;
    trees_.queries += trees.queries, trees_.gpu_bytes += trees.gpu_bytes;
    trees_.repeats += trees.repeats;
    trees_.nodes = trees.nodes, trees_.bytes = trees.bytes;
    peak_nodes_ = std::max(peak_nodes_, trees.nodes), peak_bytes_ = std::max(peak_bytes_, trees.bytes);
    kept_->stage_times.add(frame.stages, pipeline_.stages().size());
    delimitation_.resize(std::max(delimitation_.size(), frame.delimitation.size()));
    for (std::size_t level = 0; level < frame.delimitation.size(); ++level) {
        delimitation_[level].regions += frame.delimitation[level].regions;
        delimitation_[level].regions_rejected += frame.delimitation[level].regions_rejected;
        delimitation_[level].bodies_rejected += frame.delimitation[level].bodies_rejected;
        delimitation_[level].volume_rejected += frame.delimitation[level].volume_rejected;
        delimitation_[level].ms += frame.delimitation[level].ms;
    }
}

int Report::threads() const
{
    return thread_count(pipeline_.settings());
}

std::string Report::title() const
{
    return fmt::format("{}: {} bodies, {} frame{}{}; {}, {} thread{}{}", scene_.name.empty() ? "scene" : scene_.name,
                       scene_.size(), frames_, frames_ == 1 ? "" : "s", interrupted_ ? " (interrupted)" : "", backend_,
                       threads(), threads() == 1 ? "" : "s", certified(pipeline_.settings()) ? "" : "; not certified");
}

void Report::write_json(const std::filesystem::path& path) const
{
    refuse_unless(kept_->json.has_value(), "JSON");
    OutputFile file(path);
    JsonWriter json(file);
    json.begin_object(), json.schema("oncollide.results", 1);
    json.line(), json.key("header"), write_header(json);
    json.line(), json.key("stages"), write_stages(json);
    json.line(), json.key("delimitation"), write_delimitation(json);
    json.line(), json.key("frames"), json.begin_array();
    copy(kept_->json->text, file);
    json.end_array();
    json.line(), json.end_object();
    file.write("\n");
    file.commit();
}

void Report::write_header(JsonWriter& json) const
{
    const auto or_null = [](const std::string& text) { return text.empty() ? std::nullopt : std::optional(text); };
    const std::string settings = settings_json(pipeline_.settings());
    json.begin_object();
    json.members("version", version, "scene", scene_.name, "bodies", scene_.size());
    json.line(2), json.members("settings", JsonText{settings});
    json.line(2), json.members("threads", threads(), "backend", backend_, "backend_note", or_null(backend_note_),
                               "renderer", or_null(renderer_), "certified", certified(pipeline_.settings()), "hash",
                               Hex{hash_}, "interrupted", interrupted_, "frames", frames_);
    json.line(2);
    json.members(
        "verdicts", [&] { write_counts(json, verdict_order, verdicts()); }, "kinds",
        [&] { write_counts(json, kind_order, kinds()); });
    json.line(2), json.key("trees");
    json.object("rounds", trees_.rounds, "rows", trees_.rows, "node_pairs", trees_.node_pairs, "triangle_pairs",
                trees_.triangle_pairs, "unsure_pairs", trees_.unsure_pairs, "kept", trees_.kept, "narrowed",
                trees_.narrowed, "by_gap", trees_.by_gap, "by_hull", trees_.by_hull, "by_inner_spheres",
                trees_.by_inner_spheres, "by_witness", trees_.by_witness, "collapsed", trees_.collapsed, "refused",
                trees_.refused, "queries", trees_.queries, "gpu_bytes", trees_.gpu_bytes, "repeats", trees_.repeats,
                "nodes", trees_.nodes, "bytes", trees_.bytes, "peak_nodes", peak_nodes_, "peak_bytes", peak_bytes_);
    json.end_object();
}

void Report::write_stages(JsonWriter& json) const
{
    json.begin_array();
    for (const StageStats& s : totals_) {
        json.line(2);
        json.object("stage", s.stage, "unit", s.unit, "frames", s.frames, "in", s.in, "out", s.out, "culled", s.culled,
                    "undecided", s.undecided, "cpu_ms", Fixed{s.cpu_ms, 4}, "gpu_ms", Fixed{s.gpu_ms, 4}, "wait_ms",
                    Fixed{s.wait_ms, 4}, "skipped", s.skipped, "note", s.note);
    }
    json.end_array();
}

void Report::write_delimitation(JsonWriter& json) const
{
    json.begin_array();
    for (std::size_t level = 0; level < delimitation_.size(); ++level) {
        const DelimitationLevel& d = delimitation_[level];
        json.line(2);
        json.object("level", level, "regions", d.regions, "regions_rejected", d.regions_rejected, "bodies_rejected",
                    d.bodies_rejected, "volume_rejected", d.volume_rejected / double(frames_), "ms", Fixed{d.ms, 4});
    }
    json.end_array();
}

void Report::add_json(const FrameView& f, const Verdicts& verdicts)
{
    JsonWriter& json = kept_->json->writer;
    const std::vector<std::string>& names = kept_->json->names;
    json.line(2), json.begin_object();
    json.members("frame", f.frame, "ms", Fixed{f.ms, 4}, "hash", Hex{f.hash}, "rounds", f.trees.rounds, "rows",
                 f.trees.rows, "nodes", f.trees.nodes, "bytes", f.trees.bytes, "verdicts",
                 [&] { write_counts(json, verdict_order, verdicts); });
    json.key("pairs"), json.begin_array();
    for (const PairResult& pair : f.pairs)
        if (keeps(pair))
            json.array(JsonText{names[index(pair.a)]}, JsonText{names[index(pair.b)]}, name_of(pair.verdict),
                       pair.bound, name_of(pair.stage),
                       pair.kind == ContactKind::unknown ? std::nullopt : std::optional(name_of(pair.kind)),
                       pipeline_.world().pairs().max_error(pair.a, pair.b));
    json.end_array();
    if (pipeline_.continuous()) {
        json.key("sweeps"), json.begin_array();
        for (const PairSweep& sweep : f.sweeps)
            if (const PairResult& pair = f.pairs[sweep.pair]; keeps(pair))
                write_json_row(json, names[index(pair.a)], names[index(pair.b)], sweep);
        json.end_array();
    }
    json.end_object();
}

void Report::add_csv(const FrameView& f)
{
    const std::vector<std::string>& names = kept_->csv->names;
    CsvWriter& csv = kept_->csv->writer;
    SweepOfPair sweep_of(f);
    for (std::size_t i = 0; i < f.pairs.size(); ++i) {
        const PairResult& pair = f.pairs[i];
        if (!keeps(pair)) continue;
        add_csv_cells(csv, f.frame, names[index(pair.a)], names[index(pair.b)], pair, name_of(pair.stage),
                      pipeline_.world().pairs().max_error(pair.a, pair.b));
        if (pipeline_.continuous()) add_csv_cells(csv, sweep_of(i));
        csv.end_row();
    }
}

void Report::write_csv(const std::filesystem::path& path, std::string_view first_line) const
{
    refuse_unless(kept_->csv.has_value(), "CSV");
    OutputFile file(path);
    file.write(first_line);
    file.write(csv_first_line(pipeline_.continuous()));
    copy(kept_->csv->text, file);
    file.commit();
}

/// Frames follow each other without gaps, as do stages within a frame. Times are microseconds.
void Report::add_trace(const FrameView& f, const Verdicts& verdicts)
{
    const std::span<const std::string_view> stages = pipeline_.stages();
    JsonWriter json = JsonWriter::within(*kept_->trace);
    const auto span = [&](int thread, std::string_view name, double from, double duration, const auto&... more) {
        json.line(), json.object("ph", "X", "pid", 1, "tid", thread, "name", name, "ts", Fixed{from, 3}, "dur",
                                 Fixed{duration, 3}, more...);
    };
    const auto stage_us = [&](std::size_t k) { return k < f.stages.size() ? 1000 * f.stages[k].cpu_ms : 0; };
    const double begin = kept_->trace_us;
    double stages_end = begin;
    for (std::size_t k = 0; k < stages.size(); ++k) stages_end += stage_us(k);
    // Viewers nest by time, so a frame must last until the end of its last stage.
    const double end = kept_->trace_us = std::max(begin + 1000 * f.ms, stages_end);
    span(1, fmt::format("frame {}", f.frame), begin, end - begin, "args",
         [&] { json.object("rounds", f.trees.rounds, "rows", f.trees.rows, "node pairs", f.trees.node_pairs); });
    double stage_begin = begin;
    for (std::size_t k = 0; k < stages.size(); stage_begin += stage_us(k++))
        span(1, stages[k], stage_begin, stage_us(k));
    for (std::size_t k = 0; k < f.rounds.size(); ++k) {
        const Round& r = f.rounds[k];
        span(2, fmt::format("round {}", k), begin + 1000 * r.submitted_ms, 1000 * (r.done_ms - r.submitted_ms), "args",
             [&] {
                 json.object("rows", r.rows, "gpu_ms", Fixed{r.gpu_ms, 4}, "bytes", r.bytes);
             });
        if (r.wait_ms > 0) span(3, "wait", begin + 1000 * r.waited_ms, 1000 * r.wait_ms);
    }
    const auto counter = [&](std::string_view name, const auto& args) {
        json.line(), json.object("ph", "C", "pid", 1, "name", name, "ts", Fixed{begin, 3}, "args", args);
    };
    counter("nodes alive", [&] { json.object("nodes", f.trees.nodes); });
    counter("pairs", [&] { write_counts(json, verdict_order, verdicts); });
}

void Report::write_trace(const std::filesystem::path& path) const
{
    refuse_unless(kept_->trace.has_value(), "a trace");
    OutputFile file(path);
    JsonWriter json(file);
    json.begin_object(), json.schema("oncollide.trace", 1);
    json.members("displayTimeUnit", "ms");
    json.key("traceEvents"), json.begin_array();
    const auto name = [&](std::string_view what, std::string_view named, const auto&... thread) {
        json.line(),
            json.object("ph", "M", "pid", 1, thread..., "name", what, "args", [&] { json.object("name", named); });
    };
    name("process_name", "oncollide " + title());
    name("thread_name", "stages", "tid", 1);
    name("thread_name", "rounds", "tid", 2);
    name("thread_name", "waiting", "tid", 3);
    copy(*kept_->trace, file);
    json.line(), json.end_array();
    json.end_object();
    file.write("\n");
    file.commit();
}

} // namespace oncollide

#include <oncollide/pipeline/report_kept.hpp>

#include <oncollide/base/error.hpp>
#include <oncollide/base/output_file.hpp>
#include <oncollide/base/parallel.hpp>

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>
#include <oncollide/pipeline/world_access.hpp>
#include <oncollide/pipeline/settings_table.hpp>

namespace oncollide {
namespace {

constexpr Verdict verdict_order[] = {Verdict::separate, Verdict::within, Verdict::colliding, Verdict::undecided};
constexpr ContactKind kind_order[] = {ContactKind::near, ContactKind::touching, ContactKind::crossing,
                                      ContactKind::enclosed};

/// `text` as a quoted JSON string. Bytes that are not UTF-8 (possible in file names) become U+FFFD.
std::string json_string(std::string_view text)
{
    return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// Shortest text that parses to the same double; null for infinity, which JSON lacks.
std::string number(double value)
{
    return std::isfinite(value) ? fmt::format("{}", value) : "null";
}

template <class Name, std::size_t shown, std::size_t all>
std::string counts_json(const Name (&names)[shown], const std::array<std::uint64_t, all>& counts)
{
    std::string text = "{";
    for (Name name : names)
        text += fmt::format("{}\"{}\": {}", text.size() > 1 ? ", " : "", name_of(name), counts[int(name)]);
    return text + "}";
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

std::string csv_field(const std::string& text)
{
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string result = "\"";
    for (char c : text) result += c == '"' ? std::string("\"\"") : std::string(1, c);
    return result + "\"";
}

std::string csv_row(std::uint64_t frame, const std::string& a, const std::string& b, const PairResult& pair,
                    std::string_view stage, double max_error)
{
    return fmt::format("{},{},{},{},{},{},{},{}\n", frame, a, b, name_of(pair.verdict),
                       std::isfinite(pair.bound) ? number(pair.bound) : "", stage,
                       pair.kind == ContactKind::unknown ? "" : name_of(pair.kind), number(max_error));
}

Report::Report(const Scene& scene, const Pipeline& pipeline, const ReportParts& parts)
    : scene_(scene), pipeline_(pipeline), separate_(parts.separate), kept_(std::make_unique<Kept>())
{
    if (parts.json) kept_->json.emplace(Kept::Part{Spool(parts.folder), quote_all(scene, json_string)});
    if (parts.csv) kept_->csv.emplace(Kept::Part{Spool(parts.folder), quote_all(scene, csv_field)});
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
    trees_.narrowed += trees.narrowed, trees_.by_gap += trees.by_gap, trees_.by_hull += trees.by_hull,
        trees_.by_balls += trees.by_balls, trees_.by_witness += trees.by_witness;
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
    return fmt::format("{}: {} bodies, {} frame{}{}; {}, {} thread{}", scene_.name.empty() ? "scene" : scene_.name,
                       scene_.size(), frames_, frames_ == 1 ? "" : "s", interrupted_ ? " (interrupted)" : "", backend_,
                       threads(), threads() == 1 ? "" : "s");
}

void Report::write_json(const std::filesystem::path& path) const
{
    refuse_unless(kept_->json.has_value(), "JSON");
    OutputFile file(path);
    file.print("{{\n\"header\": ");
    print_header(file);
    file.print(",\n\"stages\": [");
    print_stages(file);
    file.print("],\n\"frames\": [");
    copy(kept_->json->text, file);
    file.print("]\n}}\n");
    file.commit();
}

void Report::print_header(OutputFile& file) const
{
    file.print("{{\"version\": \"{}\", \"scene\": {}, \"bodies\": {},\n  \"settings\": {},\n", version,
               json_string(scene_.name), scene_.size(), settings_json(pipeline_.settings()));
    file.print("  \"threads\": {}, \"backend\": {}, \"backend_note\": {}, \"renderer\": {}, \"hash\": \"{:016x}\", "
               "\"interrupted\": {}, "
               "\"frames\": {},\n",
               threads(), json_string(backend_), backend_note_.empty() ? "null" : json_string(backend_note_),
               renderer_.empty() ? "null" : json_string(renderer_), hash_, interrupted_, frames_);
    file.print("  \"verdicts\": {}, \"kinds\": {},\n", counts_json(verdict_order, verdicts()),
               counts_json(kind_order, kinds()));
    file.print("  \"trees\": {{\"rounds\": {}, \"rows\": {}, \"node_pairs\": {}, \"triangle_pairs\": {}, "
               "\"unsure_pairs\": {}, \"narrowed\": {}, \"by_gap\": {}, \"by_hull\": {}, \"by_balls\": {}, "
               "\"by_witness\": {}, "
               "\"collapsed\": {}, "
               "\"refused\": {}, "
               "\"queries\": {}, \"gpu_bytes\": {}, "
               "\"repeats\": {}, \"nodes\": {}, \"bytes\": {}, \"peak_nodes\": {}, \"peak_bytes\": {}}}}}",
               trees_.rounds, trees_.rows, trees_.node_pairs, trees_.triangle_pairs, trees_.unsure_pairs,
               trees_.narrowed, trees_.by_gap, trees_.by_hull, trees_.by_balls, trees_.by_witness, trees_.collapsed,
               trees_.refused, trees_.queries, trees_.gpu_bytes, trees_.repeats, trees_.nodes, trees_.bytes,
               peak_nodes_, peak_bytes_);
}

void Report::print_stages(OutputFile& file) const
{
    const char* comma = "";
    for (const StageStats& s : totals_) {
        file.print("{}\n  {{\"stage\": {}, \"unit\": {}, \"frames\": {}, \"in\": {}, \"out\": {}, \"culled\": {}, "
                   "\"undecided\": {}, \"cpu_ms\": {:.4f}, \"gpu_ms\": {:.4f}, \"wait_ms\": {:.4f}, \"skipped\": {}, "
                   "\"note\": {}}}",
                   std::exchange(comma, ","), json_string(s.stage), json_string(s.unit), s.frames, s.in, s.out,
                   s.culled, s.undecided, s.cpu_ms, s.gpu_ms, s.wait_ms, s.skipped, json_string(s.note));
    }
    file.print("],\n\"delimitation\": [");
    comma = "";
    for (std::size_t level = 0; level < delimitation_.size(); ++level) {
        const DelimitationLevel& d = delimitation_[level];
        file.print("{}\n  {{\"level\": {}, \"regions\": {}, \"regions_rejected\": {}, \"bodies_rejected\": {}, "
                   "\"volume_rejected\": {}, \"ms\": {:.4f}}}",
                   std::exchange(comma, ","), level, d.regions, d.regions_rejected, d.bodies_rejected,
                   number(d.volume_rejected / double(frames_)), d.ms);
    }
}

void Report::add_json(const FrameView& f, const Verdicts& verdicts)
{
    auto& [file, names] = *kept_->json;
    file.print("{}\n  {{\"frame\": {}, \"ms\": {:.4f}, \"hash\": \"{:016x}\", \"rounds\": {}, \"rows\": {}, "
               "\"nodes\": {}, \"bytes\": {}, \"verdicts\": {}, \"pairs\": [",
               frames_ ? "," : "", f.frame, f.ms, f.hash, f.trees.rounds, f.trees.rows, f.trees.nodes, f.trees.bytes,
               counts_json(verdict_order, verdicts));
    const char* comma = "";
    for (const PairResult& pair : f.pairs)
        if (keeps(pair))
            file.print("{}[{}, {}, \"{}\", {}, \"{}\", {}, {}]", std::exchange(comma, ", "), names[index(pair.a)],
                       names[index(pair.b)], name_of(pair.verdict), number(pair.bound), name_of(pair.stage),
                       pair.kind == ContactKind::unknown ? "null" : json_string(name_of(pair.kind)),
                       number(pipeline_.world().max_error(pair.a, pair.b)));
    file.print("]}}");
}

void Report::add_csv(const FrameView& f)
{
    auto& [file, names] = *kept_->csv;
    for (const PairResult& pair : f.pairs)
        if (keeps(pair))
            file.print("{}", csv_row(f.frame, names[index(pair.a)], names[index(pair.b)], pair, name_of(pair.stage),
                                     pipeline_.world().max_error(pair.a, pair.b)));
}

void Report::write_csv(const std::filesystem::path& path, std::string_view first_line) const
{
    refuse_unless(kept_->csv.has_value(), "CSV");
    OutputFile file(path);
    file.write(first_line), file.write(csv_header);
    copy(kept_->csv->text, file);
    file.commit();
}

/// Frames follow each other without gaps, as do stages within a frame. Times are microseconds.
void Report::add_trace(const FrameView& f, const Verdicts& verdicts)
{
    const std::span<const std::string_view> stages = pipeline_.stages();
    Spool& file = *kept_->trace;
    const double begin = kept_->trace_us;
    double stage_begin = begin;
    std::string inner;
    for (std::size_t k = 0; k < stages.size(); ++k) {
        const double us = k < f.stages.size() ? 1000 * f.stages[k].cpu_ms : 0;
        inner +=
            fmt::format(",\n{{\"ph\": \"X\", \"pid\": 1, \"tid\": 1, \"name\": {}, \"ts\": {:.3f}, \"dur\": {:.3f}}}",
                        json_string(stages[k]), stage_begin, us);
        stage_begin += us;
    }
    for (std::size_t k = 0; k < f.rounds.size(); ++k) {
        const Round& r = f.rounds[k];
        inner += fmt::format(",\n{{\"ph\": \"X\", \"pid\": 1, \"tid\": 2, \"name\": \"round {}\", \"ts\": {:.3f}, "
                             "\"dur\": {:.3f}, \"args\": {{\"rows\": {}, \"gpu_ms\": {:.4f}, \"bytes\": {}}}}}",
                             k, begin + 1000 * r.submitted_ms, 1000 * (r.done_ms - r.submitted_ms), r.rows, r.gpu_ms,
                             r.bytes);
        if (r.wait_ms > 0)
            inner += fmt::format(",\n{{\"ph\": \"X\", \"pid\": 1, \"tid\": 3, \"name\": \"wait\", \"ts\": {:.3f}, "
                                 "\"dur\": {:.3f}}}",
                                 begin + 1000 * r.waited_ms, 1000 * r.wait_ms);
    }
    // Viewers nest by time, so a frame must extend to the end of its last stage.
    const double end = kept_->trace_us = std::max(begin + 1000 * f.ms, stage_begin);
    file.print(",\n{{\"ph\": \"X\", \"pid\": 1, \"tid\": 1, \"name\": \"frame {}\", \"ts\": {:.3f}, \"dur\": {:.3f}, "
               "\"args\": {{\"rounds\": {}, \"rows\": {}, \"node pairs\": {}}}}}{}",
               f.frame, begin, end - begin, f.trees.rounds, f.trees.rows, f.trees.node_pairs, inner);
    file.print(
        ",\n{{\"ph\": \"C\", \"pid\": 1, \"name\": \"nodes alive\", \"ts\": {:.3f}, \"args\": {{\"nodes\": {}}}}}",
        begin, f.trees.nodes);
    file.print(",\n{{\"ph\": \"C\", \"pid\": 1, \"name\": \"pairs\", \"ts\": {:.3f}, \"args\": {}}}", begin,
               counts_json(verdict_order, verdicts));
}

void Report::write_trace(const std::filesystem::path& path) const
{
    refuse_unless(kept_->trace.has_value(), "a trace");
    OutputFile file(path);
    file.print(
        "{{\"displayTimeUnit\": \"ms\", \"traceEvents\": [\n"
        "{{\"ph\": \"M\", \"pid\": 1, \"name\": \"process_name\", \"args\": {{\"name\": {}}}}},\n"
        "{{\"ph\": \"M\", \"pid\": 1, \"tid\": 1, \"name\": \"thread_name\", \"args\": {{\"name\": \"stages\"}}}},\n"
        "{{\"ph\": \"M\", \"pid\": 1, \"tid\": 2, \"name\": \"thread_name\", \"args\": {{\"name\": \"rounds\"}}}},\n"
        "{{\"ph\": \"M\", \"pid\": 1, \"tid\": 3, \"name\": \"thread_name\", \"args\": {{\"name\": \"waiting\"}}}}",
        json_string("oncollide " + title()));
    copy(*kept_->trace, file);
    file.print("\n]}}\n");
    file.commit();
}

} // namespace oncollide

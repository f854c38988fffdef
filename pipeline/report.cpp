#include <oncollide/pipeline/report.hpp>

#include <oncollide/base/output_file.hpp>
#include <oncollide/base/parallel.hpp>

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

namespace oncollide {
namespace {

constexpr Verdict verdict_order[] = {Verdict::separate, Verdict::within, Verdict::colliding, Verdict::undecided};
constexpr ContactKind kind_order[] = {ContactKind::near, ContactKind::touching, ContactKind::crossing,
                                      ContactKind::enclosed};

/// `text` as a JSON string with its quotes. Bytes that are not UTF-8 (a file name may hold any) become U+FFFD.
std::string json_string(std::string_view text)
{
    return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// Shortest text that reads back as the same double; JSON has no infinity.
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

/// What bodies are called, quoted once, not once per row.
template <class Quote>
std::vector<std::string> quote_all(const Scene& scene, Quote quote)
{
    std::vector<std::string> result;
    for (std::uint32_t body = 0; body < scene.size(); ++body) result.push_back(quote(scene.label(BodyId{body})));
    return result;
}

/// RFC 4180: quotes only where a reader needs them.
std::string csv_field(const std::string& text)
{
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string result = "\"";
    for (char c : text) result += c == '"' ? std::string("\"\"") : std::string(1, c);
    return result + "\"";
}

std::string settings_json(const Settings& s)
{
    std::string skip;
    for (const std::string& stage : s.skip) skip += (skip.empty() ? "" : ", ") + json_string(stage);
    return fmt::format(
        R"({{"depth": {}, "max_error": {}, "clearance": {}, "exact": "{}", "kinds": {}, "ignore_touching": {}, "mode": "{}", "open_as_surface": {}, "backend": "{}", "broad": "{}", "bounding_volume": "{}", )"
        R"("gpu": {}, "viewport": {}, "threads": {}, "skip": [{}], "age": {}, "node_budget": {}, "memory_budget": {}, "coherence": {}}})",
        s.depth ? fmt::format("{}", *s.depth) : "null", s.max_error ? number(*s.max_error) : "null",
        number(s.clearance), name_of(s.exact), s.contact_kinds, s.ignore_touching, name_of(s.mode), s.open_as_surface,
        name_of(s.backend), name_of(s.broad_phase), name_of(s.bounding_volume), s.gpu, s.viewport, s.threads, skip,
        s.age_limit, s.node_budget, s.memory_budget, s.coherence);
}

} // namespace

Report::Report(const Scene& scene, const Pipeline& pipeline, bool separate)
    : scene_(scene), pipeline_(pipeline), separate_(separate)
{
}

void Report::add(const FrameView& frame)
{
    FrameRow row{.frame = frame.frame,
                 .ms = frame.ms,
                 .hash = frame.hash,
                 .first_pair = rows_.size(),
                 .pairs = 0,
                 .verdicts = {},
                 .trees = frame.trees,
                 .first_stage = stage_ms_.size(),
                 .first_round = rounds_.size()};
    rounds_.insert(rounds_.end(), frame.rounds.begin(), frame.rounds.end());
    for (const PairResult& pair : frame.pairs) {
        ++row.verdicts[int(pair.verdict)], ++kinds_[int(pair.kind)];
        if (pair.verdict == Verdict::separate && !separate_) continue;
        rows_.push_back({index(pair.a), index(pair.b), pair.verdict, pair.stage, pair.kind, pair.bound});
        ++row.pairs;
    }
    for (const StageStats& stage : frame.stages) stage_ms_.push_back(stage.cpu_ms);
    stage_ms_.resize(row.first_stage + pipeline_.stages().size());
    delimitation_.resize(std::max(delimitation_.size(), frame.delimitation.size()));
    for (std::size_t level = 0; level < frame.delimitation.size(); ++level) {
        delimitation_[level].regions += frame.delimitation[level].regions;
        delimitation_[level].regions_rejected += frame.delimitation[level].regions_rejected;
        delimitation_[level].bodies_rejected += frame.delimitation[level].bodies_rejected;
        delimitation_[level].volume_rejected += frame.delimitation[level].volume_rejected;
        delimitation_[level].ms += frame.delimitation[level].ms;
    }
    frames_.push_back(row);
}

std::array<std::uint64_t, 4> Report::verdicts() const
{
    std::array<std::uint64_t, 4> sum{};
    for (const FrameRow& frame : frames_)
        for (int k = 0; k < 4; ++k) sum[k] += frame.verdicts[k];
    return sum;
}

int Report::threads() const
{
    return thread_count(pipeline_.settings());
}

std::string Report::title() const
{
    return fmt::format("{}: {} bodies, {} frame{}{}; {}, {} thread{}", scene_.name.empty() ? "scene" : scene_.name,
                       scene_.size(), frames_.size(), frames_.size() == 1 ? "" : "s",
                       interrupted_ ? " (interrupted)" : "", pipeline_.backend(), threads(), threads() == 1 ? "" : "s");
}

void Report::write_json(const std::filesystem::path& path) const
{
    OutputFile file(path);
    file.print("{{\n\"header\": ");
    print_header(file);
    file.print(",\n\"stages\": [");
    print_stages(file);
    file.print("],\n\"frames\": [");
    print_frames(file);
    file.print("]\n}}\n");
    file.commit();
}

void Report::print_header(OutputFile& file) const
{
    TreeStats trees;
    std::size_t peak_nodes = 0, peak_bytes = 0;
    for (const FrameRow& frame : frames_) {
        trees.rounds += frame.trees.rounds, trees.rows += frame.trees.rows;
        trees.node_pairs += frame.trees.node_pairs, trees.triangle_pairs += frame.trees.triangle_pairs;
        trees.unsure_pairs += frame.trees.unsure_pairs;
        trees.collapsed += frame.trees.collapsed, trees.refused += frame.trees.refused;
        trees.queries += frame.trees.queries, trees.gpu_bytes += frame.trees.gpu_bytes;
        trees.repeats += frame.trees.repeats;
        trees.nodes = frame.trees.nodes, trees.bytes = frame.trees.bytes;
        peak_nodes = std::max<std::size_t>(peak_nodes, frame.trees.nodes);
        peak_bytes = std::max(peak_bytes, frame.trees.bytes);
    }
    file.print("{{\"version\": \"{}\", \"scene\": {}, \"bodies\": {},\n  \"settings\": {},\n", version,
               json_string(scene_.name), scene_.size(), settings_json(pipeline_.settings()));
    const std::string note = pipeline_.backend_note();
    file.print("  \"threads\": {}, \"backend\": {}, \"backend_note\": {}, \"renderer\": {}, \"hash\": \"{:016x}\", "
               "\"interrupted\": {}, "
               "\"frames\": {},\n",
               threads(), json_string(pipeline_.backend()), note.empty() ? "null" : json_string(note),
               pipeline_.renderer().empty() ? "null" : json_string(pipeline_.renderer()), pipeline_.hash(),
               interrupted_, frames_.size());
    file.print("  \"verdicts\": {}, \"kinds\": {},\n", counts_json(verdict_order, verdicts()),
               counts_json(kind_order, kinds()));
    file.print("  \"trees\": {{\"rounds\": {}, \"rows\": {}, \"node_pairs\": {}, \"triangle_pairs\": {}, "
               "\"unsure_pairs\": {}, \"collapsed\": {}, \"refused\": {}, "
               "\"queries\": {}, \"gpu_bytes\": {}, "
               "\"repeats\": {}, \"nodes\": {}, \"bytes\": {}, \"peak_nodes\": {}, \"peak_bytes\": {}}}}}",
               trees.rounds, trees.rows, trees.node_pairs, trees.triangle_pairs, trees.unsure_pairs, trees.collapsed,
               trees.refused, trees.queries, trees.gpu_bytes, trees.repeats, trees.nodes, trees.bytes, peak_nodes,
               peak_bytes);
}

void Report::print_stages(OutputFile& file) const
{
    const char* comma = "";
    for (const StageStats& s : pipeline_.totals()) {
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
                   number(d.volume_rejected / double(frames_.size())), d.ms);
    }
}

void Report::print_frames(OutputFile& file) const
{
    const std::vector<std::string> names = quote_all(scene_, json_string);
    const char* comma = "";
    for (const FrameRow& f : frames_) {
        file.print("{}\n  {{\"frame\": {}, \"ms\": {:.4f}, \"hash\": \"{:016x}\", \"rounds\": {}, \"rows\": {}, "
                   "\"nodes\": {}, \"bytes\": {}, \"verdicts\": {}, \"pairs\": [",
                   std::exchange(comma, ","), f.frame, f.ms, f.hash, f.trees.rounds, f.trees.rows, f.trees.nodes,
                   f.trees.bytes, counts_json(verdict_order, f.verdicts));
        for (std::size_t k = f.first_pair; k < f.first_pair + f.pairs; ++k) {
            const Row& row = rows_[k];
            file.print("{}[{}, {}, \"{}\", {}, \"{}\", {}]", k == f.first_pair ? "" : ", ", names[row.a], names[row.b],
                       name_of(row.verdict), number(row.bound), pipeline_.stages()[row.stage],
                       row.kind == ContactKind::unknown ? "null" : json_string(name_of(row.kind)));
        }
        file.print("]}}");
    }
}

void Report::write_csv(const std::filesystem::path& path) const
{
    OutputFile file(path);
    const std::vector<std::string> names = quote_all(scene_, csv_field);
    file.print("frame,a,b,verdict,gap_bound,stage,kind\n");
    for (const FrameRow& f : frames_)
        for (std::size_t k = f.first_pair; k < f.first_pair + f.pairs; ++k) {
            const Row& row = rows_[k];
            file.print("{},{},{},{},{},{},{}\n", f.frame, names[row.a], names[row.b], name_of(row.verdict),
                       std::isfinite(row.bound) ? number(row.bound) : "", pipeline_.stages()[row.stage],
                       row.kind == ContactKind::unknown ? "" : name_of(row.kind));
        }
    file.commit();
}

void Report::write_trace(const std::filesystem::path& path) const
{
    OutputFile file(path);
    file.print(
        "{{\"displayTimeUnit\": \"ms\", \"traceEvents\": [\n"
        "{{\"ph\": \"M\", \"pid\": 1, \"name\": \"process_name\", \"args\": {{\"name\": {}}}}},\n"
        "{{\"ph\": \"M\", \"pid\": 1, \"tid\": 1, \"name\": \"thread_name\", \"args\": {{\"name\": \"stages\"}}}},\n"
        "{{\"ph\": \"M\", \"pid\": 1, \"tid\": 2, \"name\": \"thread_name\", \"args\": {{\"name\": \"rounds\"}}}},\n"
        "{{\"ph\": \"M\", \"pid\": 1, \"tid\": 3, \"name\": \"thread_name\", \"args\": {{\"name\": \"waiting\"}}}}",
        json_string("oncollide " + title()));
    const std::span<const std::string_view> stages = pipeline_.stages();
    double begin = 0; // microseconds; frames stand end to end, and so do the stages in a frame
    for (const FrameRow& f : frames_) {
        double stage_begin = begin;
        std::string inner;
        for (std::size_t k = 0; k < stages.size(); ++k) {
            const double us = 1000 * stage_ms_[f.first_stage + k];
            inner += fmt::format(
                ",\n{{\"ph\": \"X\", \"pid\": 1, \"tid\": 1, \"name\": {}, \"ts\": {:.3f}, \"dur\": {:.3f}}}",
                json_string(stages[k]), stage_begin, us);
            stage_begin += us;
        }
        for (std::size_t k = 0; k < f.trees.rounds; ++k) {
            const Round& r = rounds_[f.first_round + k];
            inner += fmt::format(",\n{{\"ph\": \"X\", \"pid\": 1, \"tid\": 2, \"name\": \"round {}\", \"ts\": {:.3f}, "
                                 "\"dur\": {:.3f}, \"args\": {{\"rows\": {}, \"gpu_ms\": {:.4f}, \"bytes\": {}}}}}",
                                 k, begin + 1000 * r.submitted_ms, 1000 * (r.done_ms - r.submitted_ms), r.rows,
                                 r.gpu_ms, r.bytes);
            if (r.wait_ms > 0)
                inner += fmt::format(",\n{{\"ph\": \"X\", \"pid\": 1, \"tid\": 3, \"name\": \"wait\", \"ts\": {:.3f}, "
                                     "\"dur\": {:.3f}}}",
                                     begin + 1000 * r.waited_ms, 1000 * r.wait_ms);
        }
        // Viewers nest by time, so a frame must reach to the end of its last stage.
        const double end = std::max(begin + 1000 * f.ms, stage_begin);
        file.print(
            ",\n{{\"ph\": \"X\", \"pid\": 1, \"tid\": 1, \"name\": \"frame {}\", \"ts\": {:.3f}, \"dur\": {:.3f}, "
            "\"args\": {{\"rounds\": {}, \"rows\": {}, \"node pairs\": {}}}}}{}",
            f.frame, begin, end - begin, f.trees.rounds, f.trees.rows, f.trees.node_pairs, inner);
        file.print(
            ",\n{{\"ph\": \"C\", \"pid\": 1, \"name\": \"nodes alive\", \"ts\": {:.3f}, \"args\": {{\"nodes\": {}}}}}",
            begin, f.trees.nodes);
        file.print(",\n{{\"ph\": \"C\", \"pid\": 1, \"name\": \"pairs\", \"ts\": {:.3f}, \"args\": {}}}", begin,
                   counts_json(verdict_order, f.verdicts));
        begin = end;
    }
    file.print("\n]}}\n");
    file.commit();
}

} // namespace oncollide

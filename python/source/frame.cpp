// The result of a step.
#include <deque>

#include <fmt/format.h>

#include "held_world.hpp"

namespace oncollide::python {

namespace {

/// Copies of the results of one step, which the World will overwrite.
struct FrameResult {
    using InModule = void;
    std::uint64_t frame = 0, hash = 0;
    double ms = 0;
    std::vector<PairResult> pairs;
    std::vector<PairOfBodies> began, ended;
    std::vector<PairSweep> sweeps;
    std::vector<StageStats> stages;
    TreeStats trees;
    std::deque<std::string> texts; ///< texts of the stages of a frame that came from a pickle

    FrameResult() = default;
    explicit FrameResult(const FrameView& view)
        : frame(view.frame), hash(view.hash), ms(view.ms), pairs(view.pairs.begin(), view.pairs.end()),
          began(view.began.begin(), view.began.end()), ended(view.ended.begin(), view.ended.end()),
          sweeps(view.sweeps.begin(), view.sweeps.end()), stages(view.stages.begin(), view.stages.end()),
          trees(view.trees)
    {
        result_type<PairResult>().clear_gaps(pairs.data(), pairs.size());
        result_type<PairSweep>().clear_gaps(sweeps.data(), sweeps.size());
    }
};

py::dict stage_dict(const StageStats& s)
{
    using namespace py::literals;
    return py::dict("stage"_a = s.stage, "unit"_a = s.unit, "frames"_a = s.frames, "in"_a = s.in, "out"_a = s.out,
                    "culled"_a = s.culled, "undecided"_a = s.undecided, "cpu_ms"_a = s.cpu_ms, "gpu_ms"_a = s.gpu_ms,
                    "wait_ms"_a = s.wait_ms, "skipped"_a = s.skipped, "note"_a = s.note);
}

/// A frame as a tuple, for pickles, and back.
py::tuple state_of_frame(const FrameResult& frame)
{
    py::list stages;
    for (const StageStats& s : frame.stages)
        stages.append(py::make_tuple(std::string(s.stage), std::string(s.unit), std::string(s.note), s.frames, s.in,
                                     s.out, s.culled, s.undecided, s.cpu_ms, s.gpu_ms, s.wait_ms, s.skipped));
    return py::make_tuple(frame.frame, frame.hash, frame.ms, bytes_of(std::span<const PairResult>(frame.pairs)),
                          bytes_of(std::span<const PairOfBodies>(frame.began)),
                          bytes_of(std::span<const PairOfBodies>(frame.ended)),
                          bytes_of(std::span<const PairSweep>(frame.sweeps)), stages,
                          bytes_of(std::span<const TreeStats>(&frame.trees, 1)));
}

std::unique_ptr<FrameResult> frame_from(const py::tuple& state)
{
    auto frame = std::make_unique<FrameResult>();
    frame->frame = state[0].cast<std::uint64_t>(), frame->hash = state[1].cast<std::uint64_t>();
    frame->ms = state[2].cast<double>();
    frame->pairs = values_in<PairResult>(state[3]);
    frame->began = values_in<PairOfBodies>(state[4]), frame->ended = values_in<PairOfBodies>(state[5]);
    frame->sweeps = values_in<PairSweep>(state[6]);
    const auto text = [&](py::handle of) -> std::string_view {
        return frame->texts.emplace_back(of.cast<std::string>());
    };
    for (const py::handle each : state[7].cast<py::list>()) {
        const auto s = each.cast<py::tuple>();
        StageStats& stage = frame->stages.emplace_back();
        stage.stage = text(s[0]), stage.unit = text(s[1]), stage.note = text(s[2]);
        stage.frames = s[3].cast<std::uint64_t>(), stage.in = s[4].cast<std::uint64_t>();
        stage.out = s[5].cast<std::uint64_t>(), stage.culled = s[6].cast<std::uint64_t>();
        stage.undecided = s[7].cast<std::uint64_t>(), stage.cpu_ms = s[8].cast<double>();
        stage.gpu_ms = s[9].cast<double>(), stage.wait_ms = s[10].cast<double>(), stage.skipped = s[11].cast<bool>();
    }
    const std::vector<TreeStats> trees = values_in<TreeStats>(state[8]);
    if (!trees.empty()) frame->trees = trees[0];
    return frame;
}

std::unique_ptr<FrameResult> step(HeldWorld& held)
{
    std::unique_ptr<FrameResult> found;
    {
        const Inside inside(held, "World.step");
        const Released released(&held.interrupts);
        found = std::make_unique<FrameResult>(held.world.step());
    }
    held.interrupts.rethrow();
    return found;
}

} // namespace

py::list stage_list(std::span<const StageStats> stages)
{
    py::list made;
    for (const StageStats& stage : stages) made.append(stage_dict(stage));
    return made;
}

void bind_frames(py::module_& m, WorldClass& world)
{
    using namespace py::literals;
    py::class_<FrameResult>(
        m, "Frame", R"(The results of one World.step(). Later steps do not change its arrays. It can be pickled.)")
        .def_readonly("frame", &FrameResult::frame, "Counted from 0 by the World (int).")
        .def_readonly("ms", &FrameResult::ms, "Duration of the step, milliseconds (float).")
        .def_readonly("hash", &FrameResult::hash,
                      "Hash of the pairs that are not separate; equal input gives an equal hash (int).")
        .def_property_readonly("pairs", &column<FrameResult, &FrameResult::pairs>,
                               R"(Every pair whose AABBs overlap, including separate pairs, sorted by slots.

Structured (N,): a, b (uint64, ids of bodies), verdict (uint8, a Verdict), stage (uint8, a Stage), kind
(uint8, a ContactKind), bound (float64, metres; separate: certified lower bound on the distance; within and undecided:
certified upper bound; colliding: 0).)")
        .def_property_readonly(
            "began", &column<FrameResult, &FrameResult::began>,
            "Pairs that are not separate now, but were separate or absent in the step before: structured (N,), a, b "
            "(uint64).")
        .def_property_readonly("ended", &column<FrameResult, &FrameResult::ended>,
                               "The reverse, including pairs of removed bodies: structured (N,), a, b (uint64).")
        .def_property_readonly(
            "sweeps", &column<FrameResult, &FrameResult::sweeps>,
            R"(When the pairs in which a body moved by bodies.set_motion() first met, ascending by pair.

Structured (N,): pair (uint32, index into pairs), and the fields of World.pairs.sweep().)")
        .def_property_readonly(
            "stages", [](const FrameResult& f) { return stage_list(f.stages); },
            "Counts of each stage: dicts with stage, unit, in, out, culled, undecided, cpu_ms and others.")
        .def_property_readonly(
            "trees",
            [](const FrameResult& f) {
                const TreeStats& t = f.trees;
                return py::dict("rounds"_a = t.rounds, "rows"_a = t.rows, "node_pairs"_a = t.node_pairs,
                                "triangle_pairs"_a = t.triangle_pairs, "kept"_a = t.kept, "narrowed"_a = t.narrowed,
                                "by_gap"_a = t.by_gap, "by_witness"_a = t.by_witness, "nodes"_a = t.nodes,
                                "collapsed"_a = t.collapsed, "refused"_a = t.refused, "bytes"_a = t.bytes);
            },
            "Counts of refinement (dict).")
        .def("__repr__",
             [](const FrameResult& f) {
                 return fmt::format("<oncollide.Frame {}: {} pairs, {} began, {} ended>", f.frame, f.pairs.size(),
                                    f.began.size(), f.ended.size());
             })
        .def(py::pickle(&state_of_frame, &frame_from));

    define(world, "step", &step,
           R"(Finds all pairs at the bodies' present poses, and returns a Frame. Other Python threads can run meanwhile.

Ctrl-C ends it soon, between two pairs, with KeyboardInterrupt; the World stays valid, and the next step is complete.)");
}

} // namespace oncollide::python

// The result of a step.
#include <fmt/format.h>

#include "held_world.hpp"

namespace oncollide::python {

namespace {

/// Copies of the results of one step, which the World will overwrite.
struct FrameResult {
    std::uint64_t frame, hash;
    double ms;
    std::vector<PairResult> pairs;
    std::vector<PairOfBodies> began, ended;
    std::vector<PairSweep> sweeps;
    std::vector<StageStats> stages;
    TreeStats trees;

    explicit FrameResult(const FrameView& view)
        : frame(view.frame), hash(view.hash), ms(view.ms), pairs(view.pairs.begin(), view.pairs.end()),
          began(view.began.begin(), view.began.end()), ended(view.ended.begin(), view.ended.end()),
          sweeps(view.sweeps.begin(), view.sweeps.end()), stages(view.stages.begin(), view.stages.end()),
          trees(view.trees)
    {
    }
};

/// A view of an array of the frame; it keeps the frame alive.
template <auto member, auto type>
py::array column(py::object self)
{
    const auto& items = self.cast<const FrameResult&>().*member;
    return py::array(result_types().*type, {static_cast<py::ssize_t>(items.size())}, {}, items.data(), self);
}

py::dict stage_dict(const StageStats& s)
{
    using namespace py::literals;
    return py::dict("stage"_a = s.stage, "unit"_a = s.unit, "frames"_a = s.frames, "in"_a = s.in, "out"_a = s.out,
                    "culled"_a = s.culled, "undecided"_a = s.undecided, "cpu_ms"_a = s.cpu_ms, "gpu_ms"_a = s.gpu_ms,
                    "wait_ms"_a = s.wait_ms, "skipped"_a = s.skipped, "note"_a = s.note);
}

py::list stage_list(std::span<const StageStats> stages)
{
    py::list made;
    for (const StageStats& stage : stages) made.append(stage_dict(stage));
    return made;
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

void bind_frames(py::module_& m, WorldClass& world)
{
    using namespace py::literals;
    py::class_<FrameResult>(m, "Frame", R"(The results of one World.step(). Later steps do not change its arrays.)")
        .def_readonly("frame", &FrameResult::frame, "Counted from 0 by the World (int).")
        .def_readonly("ms", &FrameResult::ms, "Duration of the step, milliseconds (float).")
        .def_readonly("hash", &FrameResult::hash,
                      "Hash of the pairs that are not separate; equal input gives an equal hash (int).")
        .def_property_readonly("pairs", &column<&FrameResult::pairs, &ResultTypes::pair>,
                               R"(Every pair whose AABBs overlap, including separate pairs, sorted by slots.

Structured (N,): a, b (uint64, ids of bodies), verdict (uint8, a Verdict), stage (uint8, index into World.stages), kind
(uint8, a ContactKind), bound (float64, metres; separate: certified lower bound on the distance; within and undecided:
certified upper bound; colliding: 0).)")
        .def_property_readonly(
            "began", &column<&FrameResult::began, &ResultTypes::bodies>,
            "Pairs that are not separate now, but were separate or absent in the step before: structured (N,), a, b "
            "(uint64).")
        .def_property_readonly("ended", &column<&FrameResult::ended, &ResultTypes::bodies>,
                               "The reverse, including pairs of removed bodies: structured (N,), a, b (uint64).")
        .def_property_readonly("sweeps", &column<&FrameResult::sweeps, &ResultTypes::pair_sweep>,
                               R"(When the pairs in which a body moved by set_motions() first met, ascending by pair.

Structured (N,): pair (uint32, index into pairs), and the fields of World.sweep().)")
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
        .def("__repr__", [](const FrameResult& f) {
            return fmt::format("<oncollide.Frame {}: {} pairs, {} began, {} ended>", f.frame, f.pairs.size(),
                               f.began.size(), f.ended.size());
        });

    world.def("step", &step, R"(step(self)
--

Finds all pairs at the bodies' present poses, and returns a Frame. Other Python threads can run meanwhile.

Ctrl-C ends it soon, between two pairs, with KeyboardInterrupt; the World stays valid, and the next step is complete.)");

    world.def_property_readonly("stages",
                                look("World.stages",
                                     [](const World& w) {
                                         py::list names;
                                         for (const std::string_view name : w.stages()) names.append(name);
                                         return py::tuple(names);
                                     }),
                                "Names of the stages in order (tuple of str).");
    world.def_property_readonly("totals",
                                look("World.totals", [](const World& w) { return stage_list(w.inspect().totals); }),
                                "Sums over all frames so far, as Frame.stages.");
    world.def_property_readonly("hash", look("World.hash", [](const World& w) { return w.hash(); }),
                                "Hash of all frames so far; equal input gives an equal hash (int).");
}

} // namespace oncollide::python

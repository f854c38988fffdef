// The NumPy types of the library's results.
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <vector>

#include <oncollide/pipeline/results.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/robots/robot.hpp>

#include "bindings.hpp"

namespace oncollide::python {

namespace {

/// A field: its offset, and its type in NumPy's notation.
struct Field {
    const char* name;
    const char* type;
    std::size_t at;
};
using Fields = std::vector<Field>;

ResultType structure(std::size_t size, const Fields& fields)
{
    py::list names, formats, offsets;
    std::vector<bool> used(size);
    for (const Field& field : fields) {
        names.append(field.name), formats.append(field.type), offsets.append(field.at);
        const auto width = static_cast<std::size_t>(py::dtype(field.type).itemsize());
        std::fill_n(used.begin() + static_cast<std::ptrdiff_t>(field.at), width, true);
    }
    ResultType made{py::dtype(names, formats, offsets, static_cast<py::ssize_t>(size)), size, {}};
    for (std::size_t at = 0; at < size; ++at) {
        if (used[at]) continue;
        if (at == 0 || used[at - 1]) made.gaps.push_back({at, 0});
        ++made.gaps.back().size;
    }
    return made;
}

// An id is read as one number, and a cell as four.
static_assert(sizeof(BodyId) == 8 && sizeof(MapCell) == 16 && sizeof(Verdict) == 1 && sizeof(ContactKind) == 1);
static_assert(sizeof(Eigen::Vector3d) == 24 && std::endian::native == std::endian::little);

constexpr std::size_t cell_in_part = offsetof(BodyPart, cell);

// PairResult and QueryHit have their verdict in a base, where offsetof is GCC's and Clang's extension.
#pragma GCC diagnostic ignored "-Winvalid-offsetof"

template <class Found>
Fields finding_fields()
{
    return {{"verdict", "u1", offsetof(Found, verdict)},
            {"kind", "u1", offsetof(Found, kind)},
            {"bound", "f8", offsetof(Found, bound)}};
}

/// The fields of a Distance at `at`.
Fields distance_fields(std::size_t at)
{
    return {{"lower", "f8", at + offsetof(Distance, lower)},
            {"upper", "f8", at + offsetof(Distance, upper)},
            {"triangle_a", "u4", at + offsetof(Distance, a)},
            {"cell_a", "4i4", at + offsetof(Distance, a) + cell_in_part},
            {"triangle_b", "u4", at + offsetof(Distance, b)},
            {"cell_b", "4i4", at + offsetof(Distance, b) + cell_in_part},
            {"point_a", "3f8", at + offsetof(Distance, point_a)},
            {"point_b", "3f8", at + offsetof(Distance, point_b)}};
}

template <class Sweep>
Fields sweep_fields()
{
    constexpr std::size_t contact = offsetof(Sweep, contact);
    return {{"verdict", "u1", offsetof(Sweep, verdict)},
            {"kind", "u1", offsetof(Sweep, kind)},
            {"clear_until", "f8", offsetof(Sweep, clear_until)},
            {"grazes_until", "f8", offsetof(Sweep, grazes_until)},
            {"contact_by", "f8", offsetof(Sweep, contact_by)},
            {"gap", "f8", offsetof(Sweep, gap)},
            {"separating", "?", offsetof(Sweep, separating)},
            {"steps", "i4", offsetof(Sweep, steps)},
            {"triangle_a", "u4", contact + offsetof(Contact, a)},
            {"cell_a", "4i4", contact + offsetof(Contact, a) + cell_in_part},
            {"triangle_b", "u4", contact + offsetof(Contact, b)},
            {"cell_b", "4i4", contact + offsetof(Contact, b) + cell_in_part},
            {"ends", "(2,3)f8", contact + offsetof(Contact, ends)},
            {"normal", "3f8", offsetof(Sweep, normal)}};
}

template <class Result>
void make_type(Fields fields, const Fields& more = {})
{
    fields.insert(fields.end(), more.begin(), more.end());
    kept_type<Result> = new ResultType(structure(sizeof(Result), fields));
}

void make_manifold_types()
{
    make_type<ManifoldRegion>({{"kind", "u1", offsetof(ManifoldRegion, kind)},
                               {"open", "?", offsetof(ManifoldRegion, open)},
                               {"normal", "3f8", offsetof(ManifoldRegion, normal)},
                               {"normal_error", "f8", offsetof(ManifoldRegion, normal_error)},
                               {"area", "f8", offsetof(ManifoldRegion, area)},
                               {"volume", "f8", offsetof(ManifoldRegion, volume)},
                               {"centre", "3f8", offsetof(ManifoldRegion, centre)},
                               {"depth_lower", "f8", offsetof(ManifoldRegion, depth_lower)},
                               {"depth_upper", "f8", offsetof(ManifoldRegion, depth_upper)},
                               {"lost", "f8", offsetof(ManifoldRegion, lost)},
                               {"first", "u4", offsetof(ManifoldRegion, first)},
                               {"count", "u4", offsetof(ManifoldRegion, count)},
                               {"found", "u4", offsetof(ManifoldRegion, found)}});
    make_type<ManifoldPoint>({{"point_a", "3f8", offsetof(ManifoldPoint, point_a)},
                              {"point_b", "3f8", offsetof(ManifoldPoint, point_b)},
                              {"depth", "f8", offsetof(ManifoldPoint, depth)},
                              {"depth_error", "f8", offsetof(ManifoldPoint, depth_error)},
                              {"feature_a", "u8", offsetof(ManifoldPoint, feature_a)},
                              {"feature_b", "u8", offsetof(ManifoldPoint, feature_b)},
                              {"normal", "3f8", offsetof(ManifoldPoint, normal)}});
    make_type<NearFeatures>({{"a", "u8", offsetof(NearFeatures, a)},
                             {"b", "u8", offsetof(NearFeatures, b)},
                             {"lower", "f8", offsetof(NearFeatures, lower)},
                             {"upper", "f8", offsetof(NearFeatures, upper)},
                             {"point_a", "3f8", offsetof(NearFeatures, point_a)},
                             {"point_b", "3f8", offsetof(NearFeatures, point_b)}});
}

void make_robot_types()
{
    make_type<RobotFinding>({{"verdict", "u1", offsetof(RobotFinding, verdict)},
                             {"bound", "f8", offsetof(RobotFinding, bound)},
                             {"link", "i4", offsetof(RobotFinding, link)}, // no_link: -1
                             {"other", "i4", offsetof(RobotFinding, other)},
                             {"body", "u8", offsetof(RobotFinding, body)}});
    make_type<RobotDistance>({{"lower", "f8", offsetof(RobotDistance, lower)},
                              {"upper", "f8", offsetof(RobotDistance, upper)},
                              {"link", "i4", offsetof(RobotDistance, link)},
                              {"other", "i4", offsetof(RobotDistance, other)},
                              {"body", "u8", offsetof(RobotDistance, body)},
                              {"point", "(3,)f8", offsetof(RobotDistance, point)},
                              {"other_point", "(3,)f8", offsetof(RobotDistance, other_point)},
                              {"normal", "(3,)f8", offsetof(RobotDistance, normal)},
                              {"unique", "?", offsetof(RobotDistance, unique)}});
    make_type<RobotEdgeClearance>({{"lower", "f8", offsetof(RobotEdgeClearance, lower)},
                                   {"upper", "f8", offsetof(RobotEdgeClearance, upper)},
                                   {"at", "f8", offsetof(RobotEdgeClearance, at)},
                                   {"link", "i4", offsetof(RobotEdgeClearance, link)},
                                   {"other", "i4", offsetof(RobotEdgeClearance, other)},
                                   {"body", "u8", offsetof(RobotEdgeClearance, body)}});
    make_type<RobotEdgeFinding>({{"clear_until", "f8", offsetof(RobotEdgeFinding, clear_until)},
                                 {"contact_by", "f8", offsetof(RobotEdgeFinding, contact_by)},
                                 {"verdict", "u1", offsetof(RobotEdgeFinding, verdict)},
                                 {"link", "i4", offsetof(RobotEdgeFinding, link)},
                                 {"other", "i4", offsetof(RobotEdgeFinding, other)},
                                 {"body", "u8", offsetof(RobotEdgeFinding, body)}});
}

} // namespace

void make_result_types()
{
    make_type<Finding>(finding_fields<Finding>());
    make_type<QueryHit>({{"body", "u8", offsetof(QueryHit, body)}}, finding_fields<QueryHit>());
    make_type<PairOfBodies>({{"a", "u8", offsetof(PairOfBodies, a)}, {"b", "u8", offsetof(PairOfBodies, b)}});
    make_type<PairResult>({{"a", "u8", offsetof(PairResult, a)},
                           {"b", "u8", offsetof(PairResult, b)},
                           {"verdict", "u1", offsetof(PairResult, verdict)},
                           {"stage", "u1", offsetof(PairResult, stage)},
                           {"kind", "u1", offsetof(PairResult, kind)},
                           {"bound", "f8", offsetof(PairResult, bound)}});
    make_type<Distance>(distance_fields(0));
    make_type<BodyDistance>({{"body", "u8", offsetof(BodyDistance, body)}},
                            distance_fields(offsetof(BodyDistance, distance)));
    make_type<Contact>({{"triangle_a", "u4", offsetof(Contact, a)},
                        {"cell_a", "4i4", offsetof(Contact, a) + cell_in_part},
                        {"triangle_b", "u4", offsetof(Contact, b)},
                        {"cell_b", "4i4", offsetof(Contact, b) + cell_in_part},
                        {"kind", "u1", offsetof(Contact, kind)},
                        {"ends", "(2,3)f8", offsetof(Contact, ends)},
                        {"normal_a", "3f8", offsetof(Contact, normal_a)},
                        {"normal_b", "3f8", offsetof(Contact, normal_b)}});
    make_type<Penetration>({{"supported", "?", offsetof(Penetration, supported)},
                            {"depth", "f8", offsetof(Penetration, depth)},
                            {"depth_upper", "f8", offsetof(Penetration, depth_upper)},
                            {"deepest", "3f8", offsetof(Penetration, deepest)},
                            {"of_a", "?", offsetof(Penetration, of_a)},
                            {"contact", "(2,3)f8", offsetof(Penetration, contact)},
                            {"overlap", "(2,3)f8", offsetof(Penetration, overlap)},
                            {"vertex", "u4", offsetof(Penetration, vertex)},
                            {"thickness", "f8", offsetof(Penetration, thickness)},
                            {"thin_along", "3f8", offsetof(Penetration, thin_along)},
                            {"parting_lower", "f8", offsetof(Penetration, parting_lower)},
                            {"parting_upper", "f8", offsetof(Penetration, parting_upper)},
                            {"parting_along", "3f8", offsetof(Penetration, parting_along)}});
    make_type<SweepResult>(sweep_fields<SweepResult>());
    make_type<SweepHit>({{"body", "u8", offsetof(SweepHit, body)}}, sweep_fields<SweepHit>());
    make_type<PairSweep>({{"pair", "u4", offsetof(PairSweep, pair)}}, sweep_fields<PairSweep>());
    make_type<CastHit>({{"body", "u8", offsetof(CastHit, body)},
                        {"verdict", "u1", offsetof(CastHit, verdict)},
                        {"fraction_lower", "f8", offsetof(CastHit, fraction_lower)},
                        {"fraction_upper", "f8", offsetof(CastHit, fraction_upper)},
                        {"point", "3f8", offsetof(CastHit, point)},
                        {"normal", "3f8", offsetof(CastHit, normal)},
                        {"triangle", "u4", offsetof(CastHit, part)},
                        {"cell", "4i4", offsetof(CastHit, part) + cell_in_part}});
    make_manifold_types();
    make_robot_types();
}

void ResultType::clear_gaps(void* results, std::size_t count) const
{
    if (gaps.empty()) return;
    auto* at = static_cast<std::byte*>(results);
    for (std::size_t i = 0; i < count; ++i, at += size)
        for (const Gap& gap : gaps) std::memset(at + gap.at, 0, gap.size);
}

} // namespace oncollide::python

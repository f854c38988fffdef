// Sweeps in reports.
#include <cmath>

#include <fmt/format.h>

#include <oncollide/runs/report_kept.hpp>

namespace oncollide {
namespace {

std::optional<double> if_finite(double x)
{
    return std::isfinite(x) ? std::optional(x) : std::nullopt;
}

} // namespace

std::string csv_first_line(bool continuous)
{
    const std::string_view first = csv_header.substr(0, csv_header.size() - 1);
    return continuous ? fmt::format("{},{}\n", first, sweep_csv_header) : std::string(csv_header);
}

bool has_parts(const SweepResult& sweep)
{
    return std::isfinite(sweep.contact_by) && sweep.kind != ContactKind::enclosed;
}

std::string part_text(const BodyPart& part)
{
    const MapCell& c = part.cell;
    return c.side > 0 ? fmt::format("{}/{}/{}/{}", c.x, c.y, c.z, c.side) : std::to_string(part.triangle);
}

void add_csv_cells(CsvWriter& csv, const PairSweep* sweep)
{
    constexpr int columns = 12, of_time = 4, of_normal = 3;
    const auto add_empty = [&](int count) {
        for (; count > 0; --count) csv.add(std::nullopt);
    };
    if (!sweep) return add_empty(columns);
    csv.add(sweep->clear_until, if_finite(sweep->contact_by), if_finite(sweep->gap), sweep->separating);
    if (has_parts(*sweep)) {
        csv.add(part_text(sweep->contact.a), part_text(sweep->contact.b));
        for (const double x : sweep->contact.middle()) csv.add(x);
    } else {
        add_empty(columns - of_time - of_normal);
    }
    if (sweep->normal.isZero(0)) return add_empty(of_normal);
    for (const double x : sweep->normal) csv.add(x);
}

void write_json_row(JsonWriter& json, const std::string& a, const std::string& b, const PairSweep& sweep)
{
    const bool parts = has_parts(sweep);
    const auto part = [&](const BodyPart& p) { return parts ? std::optional(part_text(p)) : std::nullopt; };
    const auto vector = [&](bool known, const Eigen::Vector3d& v) {
        return [&json, known, v] { known ? json.array(v.x(), v.y(), v.z()) : json.value(nullptr); };
    };
    json.array(JsonText{a}, JsonText{b}, name_of(sweep.verdict), sweep.clear_until, sweep.contact_by, sweep.gap,
               sweep.separating, part(sweep.contact.a), part(sweep.contact.b), vector(parts, sweep.contact.middle()),
               vector(!sweep.normal.isZero(0), sweep.normal));
}

} // namespace oncollide

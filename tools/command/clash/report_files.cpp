// Machine-readable reports: JSON, CSV and JUnit XML.
#include <cmath>
#include <optional>

#include <oncollide/base/text/json_writer.hpp>
#include <oncollide/base/text/svg.hpp>

#include "clash/report.hpp"
#include "clash/report_json.hpp"
#include "common/text.hpp"

namespace oncollide::tools {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Eigen::Vector3d& v)
{
    return Json::array({v.x(), v.y(), v.z()});
}

Json json_of(const Aabb& box)
{
    if (box.empty()) return nullptr;
    return {{"min", json_of(box.min)}, {"max", json_of(box.max)}};
}

Json finite(double value)
{
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json json_of(const ClashReport& r, std::uint32_t number)
{
    const Part& part = r.parts.parts[number];
    Json j{{"name", part.name},
           {"path", part.path},
           {"file", part.file},
           {"deflection", part.details.deflection},
           {"group", part.group ? Json(r.parts.groups[part.group]) : Json(nullptr)}};
    const PartDetails& d = part.details;
    for (const auto& [key, text] :
         {std::pair("class", &d.part_class), std::pair("guid", &d.guid), std::pair("type", &d.type),
          std::pair("storey", &d.storey), std::pair("discipline", &d.discipline)})
        if (!text->empty()) j[key] = *text;
    return j;
}

Json json_of(const ClashReport& r, const Clash& c)
{
    Json j{{"id", c.id},
           {"status", c.status_text()},
           {"comment", c.comment},
           {"kind", name_of(c.kind)},
           {"was", c.was.empty() ? Json(nullptr) : Json(c.was)},
           {"a", json_of(r, c.a)},
           {"b", json_of(r, c.b)},
           {"where", json_of(c.where)}};
    if (c.apart()) {
        j["distance"] = {{"lower", c.lower}, {"upper", c.upper}};
        j["nearest"] = {json_of(c.nearest_a), json_of(c.nearest_b)};
        return j;
    }
    const Penetration& p = c.reach;
    j["ball"] = c.has_ball ? Json{{"diameter", {{"lower", c.ball_lower()}, {"upper", finite(c.ball_upper())}}},
                                  {"centre", c.ball.radius_lower > 0 ? json_of(c.ball.centre) : Json(nullptr)}}
                           : Json(nullptr);
    j["volume"] = c.has_volume() ? Json{{"lower", c.ball.volume_lower}, {"upper", c.ball.volume_upper}} : Json(nullptr);
    j["thickness"] = std::isfinite(p.thickness) ? Json(p.thickness) : Json(nullptr);
    j["depth"] = p.depth;
    j["deepest"] = p.depth > 0
                       ? Json{{"of", r.name(p.of_a ? c.a : c.b)}, {"vertex", p.vertex}, {"at", json_of(p.deepest)}}
                       : Json(nullptr);
    j["overlap"] = json_of(p.overlap);
    j["contact"] = json_of(p.contact);
    return j;
}

/// A name that known_pairs.hpp reads back: `#` may begin a comment there, and blanks around a field do not count.
std::string name_field(const std::string& part)
{
    return csv_field(part, part.find('#') != part.npos || part.starts_with(' ') || part.ends_with(' '));
}

/// A coordinate or length; empty unless `known`.
std::optional<Digits> length(double value, bool known = true)
{
    return known ? std::optional(Digits{value, 17}) : std::nullopt;
}

} // namespace

std::string json_text(const nlohmann::ordered_json& value)
{
    return value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

void write_report_lines(TextSink& out, const nlohmann::ordered_json& head, const std::vector<JsonList>& lists)
{
    const std::string begin = json_text(head);
    out.write(begin.substr(0, begin.size() - 1));
    JsonWriter json = JsonWriter::within(out);
    for (const JsonList& list : lists) {
        json.line(), json.key(list.name), json.begin_array();
        for (std::size_t i = 0; i < list.count; ++i) json.line(), json.raw(json_text(list.at(i)));
        json.end_array();
    }
    json.end_object();
    out.write("\n");
}

void write_json(TextSink& out, const ClashReport& r)
{
    Json head{{"schema", "oncollide.clash"},   {"schema_version", 1},    {"unit", r.unit.name},
              {"parts", r.parts.parts.size()}, {"files", r.parts.files}, {"triangles", r.parts.triangles}};
    head["clearance"] = r.settings.clearance, head["tolerance"] = r.settings.tolerance;
    head["deflection"] = r.parts.deflection();
    head["baseline"] = r.baseline.empty() ? Json(nullptr) : Json(r.baseline);
    head["settings"] = {{"tolerance", r.settings.from_files ? "precision of the files" : "as given"},
                        {"touching", r.settings.touching},
                        {"group", r.rules.groups},
                        {"set_a", r.rules.set_a},
                        {"set_b", r.rules.set_b}};
    for (const ClashStatus status :
         {ClashStatus::fresh, ClashStatus::active, ClashStatus::ignored, ClashStatus::contact}) {
        Json& counts = head["counts"][std::string(name_of(status))];
        for (const ClashKind kind : clash_kinds) counts[std::string(name_of(kind))] = r.count(status, kind);
    }
    if (r.settings.matrix) head["skipped"] = r.found.skipped;
    head["unreadable"] = r.parts.unreadable;
    head["warnings"] = r.warnings;
    head["mended"] = Json::array(), head["open"] = Json::array(), head["open_because"] = Json::array();
    for (const std::uint32_t part : r.found.open) {
        head["open"].push_back(r.name(part));
        head["open_because"].push_back(why_open(r, part));
    }
    for (const Part& part : r.parts.parts)
        if (!r.parts.mending.empty() && r.parts.mending[part.mesh].changed()) {
            const Mending& m = r.parts.mending[part.mesh];
            head["mended"].push_back({{"name", part.name},
                                      {"welded", m.welded},
                                      {"split", m.split},
                                      {"turned", m.turned},
                                      {"moved", m.moved}});
        }
    head["self"] = r.settings.self ? Json::array() : Json(nullptr);
    for (const PartMeetsItself& of : r.found.self) {
        Json j = json_of(r, of.part);
        j["pairs"] = of.pairs, j["triangles"] = of.worst, j["where"] = json_of(of.where);
        head["self"].push_back(std::move(j));
    }
    if (!r.group_by.empty()) {
        head["group_by"] = Json::array(), head["groups"] = Json::array();
        for (const GroupKey key : r.group_by) head["group_by"].push_back(name_of(key));
        for (const ClashGroup& group : r.groups()) {
            Json ids = Json::array();
            for (const std::size_t i : group.rows) ids.push_back(r.found.list[i].id);
            head["groups"].push_back({{"name", group.name}, {"count", group.rows.size()}, {"clashes", ids}});
        }
    }
    write_report_lines(
        out, head,
        {{"clashes", r.found.list.size(), [&](std::size_t i) { return json_of(r, r.found.list[i]); }},
         {"resolved", r.resolved.size(), [&](std::size_t i) {
              const ResolvedClash& c = r.resolved[i];
              return Json{{"id", c.id}, {"status", "resolved"}, {"comment", c.comment}, {"kind", c.kind}, {"a", c.a},
                          {"b", c.b}};
          }}});
}

void write_csv(OutputFile& file, const ClashReport& r)
{
    // Names come first, so that rows of this report can be used as a list of pairs to ignore.
    CsvWriter csv(file, "a,b,status,kind,ball_lower,ball_upper,volume_lower,volume_upper,thickness,depth,distance,x,y,"
                        "z,contact_min_x,contact_min_y,contact_min_z,"
                        "contact_max_x,contact_max_y,contact_max_z,group_a,group_b,unit,id,comment,path_a,path_b");
    const auto group = [&](std::uint32_t part) { return name_field(r.parts.groups[r.parts.parts[part].group]); };
    for (const Clash& c : r.found.list) {
        const bool near = c.apart();
        const Aabb& contact = c.reach.contact;
        csv.add(CsvField{name_field(r.name(c.a))}, CsvField{name_field(r.name(c.b))},
                CsvField{name_field(std::string(c.status_text()))}, name_of(c.kind), length(c.ball_lower(), c.has_ball),
                length(c.ball_upper(), c.has_ball && std::isfinite(c.ball_upper())),
                length(c.ball.volume_lower, c.has_volume()), length(c.ball.volume_upper, c.has_volume()),
                length(c.reach.thickness, !near && std::isfinite(c.reach.thickness)), length(c.reach.depth, !near),
                length(c.upper, near));
        for (const double x : c.where) csv.add(length(x));
        for (const Eigen::Vector3d& corner : {contact.min, contact.max})
            for (const double x : corner) csv.add(length(x, !contact.empty()));
        csv.row(CsvField{group(c.a)}, CsvField{group(c.b)}, r.unit.name, c.id, CsvField{name_field(c.comment)},
                CsvField{name_field(r.parts.parts[c.a].path)}, CsvField{name_field(r.parts.parts[c.b].path)});
    }
    for (const ResolvedClash& c : r.resolved) {
        csv.add(CsvField{name_field(c.a)}, CsvField{name_field(c.b)}, "resolved", CsvField{name_field(c.kind)});
        for (int k = 0; k < 18; ++k) csv.add("");
        csv.row(r.unit.name, CsvField{name_field(c.id)}, CsvField{name_field(c.comment)}, "", "");
    }
}

void write_junit(OutputFile& file, const ClashReport& r)
{
    const std::size_t fresh = r.count(ClashStatus::fresh),
                      known = r.count(ClashStatus::active) + r.count(ClashStatus::ignored);
    // The first test always passes: some readers reject a suite without tests.
    file.print("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
               "<testsuites>\n<testsuite name=\"oncollide clash\" tests=\"{}\" failures=\"{}\" errors=\"{}\" "
               "skipped=\"{}\">\n<testcase classname=\"clash\" name=\"{} parts were compared\"/>\n",
               1 + r.parts.unreadable.size() + fresh + known + r.resolved.size(), fresh, r.parts.unreadable.size(),
               known, r.parts.parts.size());
    for (const std::string& why : r.parts.unreadable)
        file.print("<testcase classname=\"clash.files\" name=\"{0}\"><error message=\"{0}\"/></testcase>\n",
                   xml_escaped(why));
    for (const Clash& c : r.found.list) {
        if (c.status == ClashStatus::contact) continue;
        const std::string pair = xml_escaped(fmt::format("{} and {}", r.name(c.a), r.name(c.b)));
        const std::string what =
            xml_escaped(fmt::format("{}: {}, at {}", name_of(c.kind), measure_text(r, c), r.position(c.where)));
        file.print("<testcase classname=\"clash.{}\" name=\"{}\">", name_of(c.kind), pair);
        if (c.status == ClashStatus::fresh)
            file.print("<failure type=\"{}\" message=\"{}\"/>", name_of(c.kind), what);
        else
            file.print("<skipped message=\"{}: {}\"/>",
                       c.status == ClashStatus::ignored ? "ignored"
                       : c.review.empty()               ? "also in the baseline"
                                                        : xml_escaped(c.review),
                       what);
        file.print("</testcase>\n");
    }
    for (const ResolvedClash& c : r.resolved)
        file.print("<testcase classname=\"clash.resolved\" name=\"{} and {}\"/>\n", xml_escaped(c.a), xml_escaped(c.b));
    file.print("</testsuite>\n</testsuites>\n");
}

} // namespace oncollide::tools

#include "clash/report.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/text/listed.hpp>
#include <oncollide/base/text/plain_number.hpp>
#include <oncollide/base/text/printable.hpp>

#include "common/text.hpp"

namespace oncollide::tools {
namespace {

std::string plural(std::size_t count, std::string_view one)
{
    return fmt::format("{} {}{}", grouped(count), one, count == 1 ? "" : one.ends_with("sh") ? "es" : "s");
}

/// " (2 approved, 1 reviewed)": active clashes that a user has given a status.
std::string reviews_text(const ClashReport& r)
{
    std::map<std::string, std::size_t> counts;
    for (const Clash& clash : r.found.list)
        if (!clash.review.empty()) ++counts[clash.review];
    std::vector<std::string> texts;
    for (const auto& [review, count] : counts) texts.push_back(fmt::format("{} {}", grouped(count), review));
    return texts.empty() ? "" : fmt::format(" ({})", fmt::join(texts, ", "));
}

/// "2 parts meet themselves: 'bolt' (3 pairs of triangles, around 10 0 5), ..."
std::string self_text(const ClashReport& r)
{
    constexpr std::size_t most = 5;
    std::vector<std::string> texts;
    for (const PartMeetsItself& of : r.found.self) {
        texts.push_back(texts.size() < most
                            ? fmt::format("'{}' ({}, around {})", r.name(of.part),
                                          plural(of.pairs, "pair") + " of triangles", r.position(of.where))
                            : "...");
        if (texts.size() > most) break;
    }
    if (texts.empty()) return "no part meets itself";
    return fmt::format("{} {}: {}", plural(r.found.self.size(), "part"),
                       r.found.self.size() == 1 ? "meets itself" : "meet themselves", fmt::join(texts, ", "));
}

/// "25 pairs touch: 20 exactly, 4 with an overlap within the tolerance of 0.04 mm (the precision of the files), ..."
std::string touching_text(const ClashReport& r, std::size_t count)
{
    std::size_t overlap = 0, apart = 0;
    for (const Clash& c : r.found.list)
        if (c.status == ClashStatus::contact && c.kind == ClashKind::touching)
            overlap += c.overlapped, apart += c.tolerated && !c.overlapped;
    std::string text = fmt::format("{} {}", plural(count, "pair"), count == 1 ? "touches" : "touch");
    if (r.settings.tolerance > 0) {
        std::vector<std::string> ways;
        if (count > overlap + apart) ways.push_back(fmt::format("{} exactly", grouped(count - overlap - apart)));
        const std::string limit = r.settings.matrix
                                      ? "their tolerance"
                                      : fmt::format("the tolerance of {}{}", r.length(r.settings.tolerance),
                                                    r.settings.from_files ? " (the precision of the files)" : "");
        if (overlap) ways.push_back(fmt::format("{} with an overlap within {}", grouped(overlap), limit));
        if (apart) ways.push_back(fmt::format("{} with a gap within {}", grouped(apart), overlap ? "it" : limit));
        text += fmt::format(": {}", fmt::join(ways, ", "));
    } else
        text += " without overlapping";
    return text + "; this is a clash only if --touching is given";
}

/// "12 parts were mended ('wall': 36 vertices welded, ...): their surfaces moved by at most 0.01 mm"
std::string mended_text(const ClashReport& r)
{
    std::size_t count = 0;
    double moved = 0;
    const Part* first = nullptr;
    for (const Part& part : r.parts.parts) {
        if (r.parts.mending.empty() || !r.parts.mending[part.mesh].changed()) continue;
        if (!first) first = &part;
        ++count, moved = std::max(moved, r.parts.mending[part.mesh].moved);
    }
    if (!first) return "";
    return fmt::format("{} mended ('{}': {}{}); surfaces moved by at most {}",
                       count == 1 ? "1 part was" : grouped(count) + " parts were", first->name,
                       r.parts.mending[first->mesh].done(), count > 1 ? "; ..." : "", r.length(moved));
}

} // namespace

std::string why_open(const ClashReport& r, std::uint32_t part, std::string_view before)
{
    if (r.parts.mending.empty()) return "";
    const Mending& mending = r.parts.mending[r.parts.parts[part].mesh];
    return fmt::format("{}{}{}", before, mending.why_open(),
                       mending.open_edges ? fmt::format(", {} long", r.length(mending.open_length)) : "");
}

std::size_t ClashReport::count(ClashStatus status) const
{
    return std::size_t(std::ranges::count(found.list, status, &Clash::status));
}

std::size_t ClashReport::count(ClashStatus status, ClashKind kind) const
{
    return std::size_t(
        std::ranges::count_if(found.list, [&](const Clash& c) { return c.status == status && c.kind == kind; }));
}

std::vector<std::size_t> ClashReport::open_clashes() const
{
    std::vector<std::size_t> rows;
    for (const ClashStatus status : {ClashStatus::fresh, ClashStatus::active})
        for (std::size_t i = 0; i < found.list.size(); ++i)
            if (found.list[i].status == status) rows.push_back(i);
    return rows;
}

std::string ClashReport::length(double value) const
{
    // Lengths below 0.1 m or 0.1 cm are easier to read in millimetres.
    const bool small = std::abs(value) < 0.1 && value != 0 && (unit.name == "m" || unit.name == "cm");
    const std::string_view name = small ? "mm" : unit.name;
    if (small) value *= unit.millimetres;
    constexpr double least = 1e-9;
    const double size = std::abs(value);
    if (size == 0 || size >= 1e-4) return fmt::format("{} {}", plain_measure(value, 4), name);
    if (size < least) return fmt::format("under {:.9f} {}", least, name);
    const std::string text = fmt::format("{:.{}f}", value, 1 - int(std::floor(std::log10(size)))); // two digits
    return fmt::format("{} {}", text.substr(0, text.find_last_not_of('0') + 1), name);
}

std::string ClashReport::position(const Eigen::Vector3d& point) const
{
    const double size = (parts.bounds.max - parts.bounds.min).maxCoeff();
    const int decimals = std::clamp(int(std::ceil(-std::log10(1e-6 * std::max(size, 1e-9)))), 0, 12);
    std::vector<std::string> texts;
    for (const double x : point) {
        std::string& text = texts.emplace_back(fmt::format("{:.{}f}", x, decimals));
        if (decimals > 0) text.erase(text.find_last_not_of('0') + 1);
        if (text.ends_with('.')) text.pop_back();
        if (text == "-0") text = "0";
    }
    return fmt::format("{}", fmt::join(texts, " "));
}

std::string time_text(std::int64_t seconds)
{
    return fmt::format("{:%Y-%m-%d %H:%M UTC}", fmt::gmtime(std::time_t(seconds)));
}

std::vector<std::string> summary(const ClashReport& r)
{
    const Eigen::Vector3d size = r.parts.bounds.max - r.parts.bounds.min;
    std::vector<std::string> lines{fmt::format("{} of {}, {}, {} x {} x {} {}", plural(r.parts.parts.size(), "part"),
                                               plural(r.parts.files.size(), "file"),
                                               plural(r.parts.triangles, "triangle"), plain_measure(size.x(), 4),
                                               plain_measure(size.y(), 4), plain_measure(size.z(), 4), r.unit.name)};
    if (const std::size_t n = r.parts.unreadable.size())
        lines.push_back(fmt::format("{} could not be read: clashes of {} parts are missing", plural(n, "file"),
                                    n == 1 ? "its" : "their"));
    if (const double deflection = r.parts.deflection(); deflection > 0)
        lines.push_back(fmt::format("the meshes deviate from the true surfaces by at most {}", r.length(deflection)));
    std::vector<std::string> kinds;
    for (const ClashKind kind : clash_kinds)
        if (const std::size_t n = r.count(ClashStatus::fresh, kind))
            kinds.push_back(fmt::format("{} {}", grouped(n), name_of(kind)));
    const std::size_t fresh = r.count(ClashStatus::fresh);
    lines.push_back(
        fresh ? fmt::format("{}: {}", plural(fresh, r.baseline.empty() ? "clash" : "new clash"), fmt::join(kinds, ", "))
        : r.baseline.empty() ? "no clashes"
                             : "no new clashes");
    if (!r.baseline.empty())
        lines.push_back(fmt::format("{} active, also in {}{}; {} resolved",
                                    plural(r.count(ClashStatus::active), "clash"), r.baseline, reviews_text(r),
                                    grouped(r.resolved.size())));
    if (!r.ignore.empty())
        lines.push_back(
            fmt::format("{} ignored, listed in {}", plural(r.count(ClashStatus::ignored), "pair"), r.ignore));
    if (const std::size_t n = r.count(ClashStatus::contact, ClashKind::touching)) lines.push_back(touching_text(r, n));
    if (const std::string text = mended_text(r); !text.empty()) lines.push_back(text);
    if (const std::size_t n = r.count(ClashStatus::contact, ClashKind::within))
        lines.push_back(
            fmt::format("{} {} by less than the meshes show (within); this is a clash only if --touching is "
                        "given, and a smaller --deflection decides more",
                        plural(n, "pair"), n == 1 ? "overlaps or is apart" : "overlap or are apart"));
    if (!r.found.open.empty())
        lines.push_back(
            fmt::format("{} not closed ('{}'{}{}): parts wholly inside {} are not found",
                        r.found.open.size() == 1 ? "1 part is" : grouped(r.found.open.size()) + " parts are",
                        r.name(r.found.open.front()), why_open(r, r.found.open.front(), ": "),
                        r.found.open.size() > 1 ? ", ..." : "", r.found.open.size() == 1 ? "it" : "them"));
    if (r.found.skipped)
        lines.push_back(fmt::format("{} not compared, as the clash matrix says",
                                    r.found.skipped == 1 ? "1 pair is" : grouped(r.found.skipped) + " pairs are"));
    if (r.settings.self) lines.push_back(self_text(r));
    return lines;
}

std::string measure_text(const ClashReport& r, const Clash& c)
{
    if (c.kind == ClashKind::duplicate) return "same geometry, same place";
    if (c.apart()) return fmt::format("{} apart", r.length(c.upper));
    if (c.kind == ClashKind::touching && !c.tolerated) return "0 deep";
    if (c.has_ball)
        return c.ball_lower() > 0 ? fmt::format("ball of {}", r.length(c.ball_lower()))
                                  : fmt::format("ball of at most {}", r.length(c.ball_upper()));
    return fmt::format("along {}", r.length(c.reach.contact.empty() ? 0 : c.reach.contact.diagonal()));
}

std::string clash_table(const ClashReport& r, std::size_t most)
{
    using Row = std::array<std::string, 6>;
    std::vector<Row> rows{{"", "kind", "overlap or gap", "part", "part", fmt::format("where ({})", r.unit.name)}};
    std::map<std::size_t, std::string> headings; // by the row that follows
    std::size_t all = 0;
    for (const ClashGroup& group : r.groups()) {
        if (!r.group_by.empty() && rows.size() <= most)
            headings[rows.size()] =
                fmt::format("\n{}: {}\n", printable(group.name), plural(group.rows.size(), "clash"));
        all += group.rows.size();
        for (const std::size_t i : group.rows) {
            if (rows.size() > most) break;
            const Clash& c = r.found.list[i];
            const std::string note = c.status == ClashStatus::active ? fmt::format(" ({})", printable(c.status_text()))
                                     : c.was.empty()                 ? ""
                                                                     : fmt::format(" (was {})", printable(c.was));
            rows.push_back({std::to_string(rows.size()), std::string(name_of(c.kind)) + note, measure_text(r, c),
                            shortened(printable(r.label(c.a)), 40), shortened(printable(r.label(c.b)), 40),
                            r.position(c.where)});
        }
    }
    if (rows.size() == 1) return "";
    std::array<std::size_t, 6> widths{};
    for (const Row& row : rows)
        for (std::size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], row[k].size());
    std::string text;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const Row& row = rows[i];
        text += headings[i] + fmt::format("{:>{}}  {:<{}}  {:<{}}  {:<{}}  {:<{}}  {}\n", row[0], widths[0], row[1],
                                          widths[1], row[2], widths[2], row[3], widths[3], row[4], widths[4], row[5]);
    }
    if (rows.size() - 1 < all)
        text += fmt::format("and {} more (--list N prints more)\n", grouped(all - rows.size() + 1));
    return text;
}

} // namespace oncollide::tools

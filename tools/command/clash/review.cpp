// oncollide clash review: sets statuses and comments of the clashes in a JSON report.
#include "clash/review.hpp"

#include <algorithm>
#include <map>
#include <memory>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/text/listed.hpp>
#include <oncollide/base/text/printable.hpp>

#include "clash/report_json.hpp"
#include "cli/standard_output.hpp"
#include "common/text.hpp"

namespace oncollide::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uintmax_t most_report_bytes = std::uintmax_t(1) << 30;

struct ReviewOptions {
    std::string report;
    std::vector<std::string> set;
};

/// "ID=STATUS" or "ID=STATUS,COMMENT".
struct Review {
    std::string id, status, comment;
    bool has_comment;
};

Review review_from(const std::string& text)
{
    const std::size_t at = text.find('='), comma = text.find(',', at == text.npos ? 0 : at);
    const auto fail = [&](const std::string& why) {
        usage(fmt::format("--set {}: {}; expected ID=STATUS or ID=STATUS,COMMENT", text, why));
    };
    if (at == 0 || at == text.npos) fail("no id");
    Review review{text.substr(0, at), text.substr(at + 1, comma == text.npos ? comma : comma - at - 1),
                  comma == text.npos ? "" : text.substr(comma + 1), comma != text.npos};
    if (review.status.find_first_not_of(' ') == review.status.npos) fail("no status");
    if (review.status.size() > 100 || printable(review.status) != review.status)
        fail("the status must be at most 100 bytes without control characters");
    for (const char* own : {"ignored", "contact", "resolved"})
        if (review.status == own) fail(fmt::format("'{}' is not for users to set", own));
    return review;
}

/// Throws Error{bad_data} unless the file is a report with clashes.
Json read_report_to_review(const std::string& file)
{
    const auto fail = [&] { refuse(file, "not a valid report; expected a JSON report of 'oncollide clash'"); };
    Json report = Json::parse(read_file(file, most_report_bytes), nullptr, false);
    if (!report.is_object() || report.value("schema", Json()) != "oncollide.clash" || !report.contains("clashes") ||
        !report["clashes"].is_array() || !report.contains("resolved") || !report["resolved"].is_array())
        fail();
    for (const Json& clash : report["clashes"]) {
        for (const char* key : {"id", "status", "kind"})
            if (!clash.is_object() || !clash.contains(key) || !clash[key].is_string()) fail();
        for (const char* part : {"a", "b"})
            if (!clash.contains(part) || !clash[part].is_object() || !clash[part].value("name", Json()).is_string())
                fail();
    }
    return report;
}

/// Counts of new and active clashes by kind; a status of a user counts as active.
void count_again(Json& report)
{
    if (!report.contains("counts") || !report["counts"].is_object()) return;
    for (const char* status : {"new", "active"})
        for (auto& count : report["counts"][status]) count = 0;
    for (const Json& clash : report["clashes"]) {
        const std::string status = clash["status"];
        if (status == "ignored" || status == "contact") continue;
        Json& count = report["counts"][status == "new" ? "new" : "active"][clash["kind"].get<std::string>()];
        count = count.is_number() ? count.get<std::size_t>() + 1 : 1;
    }
}

void write_reviewed(const std::string& file, Json report)
{
    const Json clashes = std::move(report["clashes"]), resolved = std::move(report["resolved"]);
    report.erase("clashes"), report.erase("resolved");
    OutputFile out(file);
    write_report_lines(out, report,
                       {{"clashes", clashes.size(), [&](std::size_t i) { return clashes[i]; }},
                        {"resolved", resolved.size(), [&](std::size_t i) { return resolved[i]; }}});
    out.commit();
}

/// A line per clash, in the order of the report.
void list_reviews(const Json& report)
{
    std::map<std::string, std::size_t> counts;
    std::string text;
    for (const Json& clash : report["clashes"]) {
        const std::string status = clash["status"];
        ++counts[status];
        if (status == "contact") continue;
        const auto name = [&](const char* part) { return shortened(clash[part]["name"].get<std::string>(), 40); };
        const std::string comment = clash.value("comment", "");
        text += printable(fmt::format("{}  {}  {}  {} and {}{}", clash["id"].get<std::string>(), status,
                                      clash["kind"].get<std::string>(), name("a"), name("b"),
                                      comment.empty() ? "" : ": " + shortened(comment, 200))) +
                "\n";
    }
    std::vector<std::string> texts;
    for (const auto& [status, count] : counts) texts.push_back(fmt::format("{} {}", grouped(count), printable(status)));
    write_to_stdout(text + (texts.empty() ? "no clashes" : fmt::format("{}", fmt::join(texts, ", "))) + "\n");
    flush_stdout();
}

int review(const ReviewOptions& o)
{
    std::vector<Review> reviews;
    for (const std::string& text : o.set) reviews.push_back(review_from(text));
    Json report = read_report_to_review(o.report);
    if (reviews.empty()) return list_reviews(report), 0;
    std::map<std::string, Json*> by_id;
    for (Json& clash : report["clashes"]) by_id.emplace(clash["id"].get<std::string>(), &clash);
    for (const Review& of : reviews) {
        const auto at = by_id.find(of.id);
        if (at == by_id.end())
            usage(fmt::format("--set {}={}: {} has no clash with this id", of.id, of.status, o.report));
        Json& clash = *at->second;
        if (clash["status"] == "ignored" || clash["status"] == "contact")
            usage(fmt::format("--set {}={}: this pair is no clash, its status is '{}'", of.id, of.status,
                              clash["status"].get<std::string>()));
        clash["status"] = of.status;
        if (of.has_comment) clash["comment"] = of.comment;
    }
    count_again(report);
    write_reviewed(o.report, std::move(report));
    return 0;
}

} // namespace

void add_clash_review(Arguments clash)
{
    Arguments sub =
        clash.add_command("review", "Set statuses and comments of the clashes in a JSON report, or list them");
    auto o = std::make_shared<ReviewOptions>();
    sub.add_option("report REPORT.json", o->report, "JSON report of oncollide clash; it is changed in place")
        .required();
    sub.add_option("--set ID=STATUS[,COMMENT]", o->set,
                   "the status of a clash, such as approved, and a comment (repeatable); without --set the clashes are "
                   "listed")
        .repeatable();
    sub.footer("The next run with --baseline REPORT.json takes statuses and comments over.\n"
               "Example:\n"
               "  oncollide clash review report.json --set c9472b5f36b063be6=approved,'sleeve is planned'");
    sub.action([o] { return review(*o); });
}

} // namespace oncollide::tools

// oncollide clash from run to run: ids, statuses and comments, and the files in which others review clashes.
#include "tools/command/clash/clash_fixture.hpp"
#include "tools/csv_rows.hpp"
#include "tools/zip_files.hpp"

namespace oncollide::test {
namespace {

using nlohmann::json;

class ClashReview : public ClashCommand {
protected:
    std::map<std::string, std::string> ids(const std::string& file)
    {
        std::map<std::string, std::string> found;
        const json report = read_json(file);
        for (const json& c : report["clashes"]) {
            const std::string a = c["a"]["name"], b = c["b"]["name"];
            found[std::min(a, b) + " " + std::max(a, b)] = c["id"];
        }
        return found;
    }
};

TEST_F(ClashReview, IdsDependOnThePartsAlone)
{
    clash({"--clearance", "1", "--threads", "1", "-o", "r.json"});
    const auto before = ids("r.json");
    std::set<std::string> different;
    for (const auto& [names, id] : before) different.insert(id);
    EXPECT_EQ(different.size(), 4u);
    std::ranges::reverse(files_);
    clash({"--clearance", "1", "--threads", "2", "-o", "r.json"});
    EXPECT_EQ(ids("r.json"), before);
    std::filesystem::create_directories(folder_ / "elsewhere");
    for (const std::string& file : files_) std::filesystem::rename(folder_ / file, folder_ / ("elsewhere/" + file));
    write_box("elsewhere/g.off", {200, 0, 0}, {201, 1, 1});
    run({"clash", "elsewhere", "--clearance", "1", "-o", "r.json"});
    EXPECT_EQ(ids("r.json"), before);
    // Parts with equal paths differ in their geometry.
    for (const char* folder : {"l", "r", "m"}) std::filesystem::create_directories(folder_ / folder);
    write_box("l/bolt.off", {0, 0, 0}, {1, 1, 1}), write_box("r/bolt.off", {0.5, 0, 0}, {2, 1, 1});
    write_box("m/bolt.off", {0.6, 0, 0}, {3, 1, 1});
    run({"clash", "l/bolt.off", "r/bolt.off", "m/bolt.off", "-o", "r.json"});
    const auto bolts = ids("r.json");
    run({"clash", "m/bolt.off", "r/bolt.off", "l/bolt.off", "-o", "r.json"});
    EXPECT_EQ(ids("r.json"), bolts);
    EXPECT_EQ(bolts.size(), 3u);
    EXPECT_NE(bolts.at("l/bolt.off r/bolt.off"), bolts.at("m/bolt.off r/bolt.off"));
}

TEST_F(ClashReview, StatusesAndCommentsOfUsersAreTakenOver)
{
    clash({"--clearance", "1", "-o", "1.json"});
    json edited = read_json("1.json");
    EXPECT_EQ(edited["schema"], "oncollide.clash");
    EXPECT_EQ(edited["schema_version"], 1);
    const auto edit = [&](const char* kind, const char* status, const char* comment) {
        for (json& c : edited["clashes"])
            if (c["kind"] == kind) c["status"] = status, c["comment"] = comment;
    };
    edit("crossing", "approved", "press fit, =Eva"), edit("near", "new", "ask Ben");
    edit("enclosed", "reviewed", "a <hidden> part");
    folder_.write("1.json", edited.dump());
    Outcome outcome = clash(
        {"--clearance", "1", "--baseline", "1.json", "-o", "2.json", "-o", "2.csv", "-o", "2.html", "-o", "2.xml"});
    EXPECT_EQ(outcome.code, 0) << outcome.out;
    EXPECT_NE(outcome.out.find("3 clashes active, also in 1.json (1 approved, 1 reviewed); 0 resolved"),
              std::string::npos)
        << outcome.out;
    EXPECT_NE(outcome.out.find("crossing (approved)"), std::string::npos) << outcome.out;
    EXPECT_EQ(pairs("2.json"),
              (Pairs{"b e enclosed reviewed", "a b crossing approved", "a c touching contact", "a d near active"}));
    EXPECT_EQ(read_json("2.json")["clashes"][1]["comment"], "press fit, =Eva");
    EXPECT_EQ(read_json("2.json")["counts"]["active"]["crossing"], 1);
    const auto csv = read_csv(folder_.read("2.csv"));
    EXPECT_EQ(csv.at(1).at("status"), "approved");
    EXPECT_EQ(csv.at(1).at("comment"), "press fit, =Eva");
    EXPECT_EQ(csv.at(1).at("id"), read_json("2.json")["clashes"][1]["id"]);
    EXPECT_NE(folder_.read("2.html").find("a &lt;hidden&gt; part"), std::string::npos);
    EXPECT_NE(folder_.read("2.html").find("(approved)"), std::string::npos);
    EXPECT_NE(folder_.read("2.xml").find("<skipped message=\"approved: crossing"), std::string::npos);

    // b leaves, so two clashes are resolved; d comes nearer and is new again, with its comment.
    write_box("b.off", {300, 0, 0}, {301, 1, 1}), write_box("d.off", {-10, 0, 0}, {0.5, 10, 10});
    outcome = clash({"--clearance", "1", "--baseline", "2.json", "-o", "3.json", "-o", "3.csv", "-o", "3.html"});
    EXPECT_EQ(outcome.code, 1);
    EXPECT_NE(outcome.out.find("2 resolved"), std::string::npos) << outcome.out;
    EXPECT_EQ(pairs("3.json"), (Pairs{"a c touching contact", "a d crossing new"}));
    json report = read_json("3.json");
    EXPECT_EQ(report["clashes"][0]["comment"], "ask Ben");
    ASSERT_EQ(report["resolved"].size(), 2u);
    EXPECT_EQ(report["resolved"][0]["status"], "resolved");
    EXPECT_EQ(report["resolved"][0]["comment"], "press fit, =Eva");
    EXPECT_EQ(report["resolved"][0]["id"], edited["clashes"][1]["id"]);
    EXPECT_EQ(read_csv(folder_.read("3.csv")).at(2).at("status"), "resolved");
    EXPECT_NE(folder_.read("3.html").find("a and b (crossing): press fit, =Eva"), std::string::npos);

    // They stay resolved; one that comes back is new, with its comment, and the report does not hide it.
    write_box("b.off", {9, -5, -5}, {30, 15, 15});
    write_box("e.off", {500, 0, 0}, {501, 5, 5});
    outcome = clash({"--clearance", "1", "--baseline", "3.json", "--ignore", "3.csv", "-o", "4.json"});
    EXPECT_EQ(outcome.code, 1) << outcome.out;
    EXPECT_TRUE(pairs("4.json").contains("a b crossing new"));
    report = read_json("4.json");
    ASSERT_EQ(report["resolved"].size(), 1u);
    EXPECT_EQ(report["resolved"][0]["comment"], "a <hidden> part");
    for (const json& c : report["clashes"])
        EXPECT_EQ(c["comment"], c["b"]["name"] == "b"   ? "press fit, =Eva"
                                : c["b"]["name"] == "d" ? "ask Ben"
                                                        : "")
            << c;
}

TEST_F(ClashReview, ABaselineNeedsNoIdsAndNoComments)
{
    clash({"--clearance", "1", "-o", "1.json"});
    json written = read_json("1.json"); // as a script may write it
    for (json& c : written["clashes"]) c.erase("id"), c.erase("comment");
    folder_.write("1.json", written.dump());
    const Outcome outcome = clash({"--clearance", "1", "--baseline", "1.json", "-o", "2.json"});
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    EXPECT_EQ(pairs("2.json"),
              (Pairs{"b e enclosed active", "a b crossing active", "a c touching contact", "a d near active"}));
}

TEST_F(ClashReview, ThePageShowsItsSettingsAndLinksInto3D)
{
    std::filesystem::create_directories(folder_ / "lib/examples/js/controls");
    std::filesystem::create_directories(folder_ / "a b");
    for (const char* script : {"lib/three.min.js", "lib/examples/js/controls/OrbitControls.js"})
        folder_.write(script, "/* three */");
    files_ = small_assembly();
    std::vector<std::string> arguments{"clash",  "--clearance",  "1mm", "--set-a", "a",          "--group", "[ef]",
                                       "--view", "a b/v&1.html", "-o",  "r.html",  "--pictures", "0"};
    arguments.insert(arguments.begin() + 1, files_.begin(), files_.end());
    Surroundings around;
    around.environment = {{"ONCOLLIDE_THREE", (folder_.path() / "lib").string()}, {"SOURCE_DATE_EPOCH", "1772366400"}};
    const Outcome outcome = run(arguments, around);
    EXPECT_EQ(outcome.code, 1) << outcome.err;
    const std::string page = folder_.read("r.html"), view = folder_.read("a b/v&1.html");
    for (const char* row :
         {"<dt>Date</dt><dd>2026-03-01 12:00 UTC</dd>",
          "<dt>Input</dt><dd>a.off, b.off, c.off, d.off, e.off, f.off</dd>", "<dt>Clearance</dt><dd>1 mm</dd>",
          "<dt>Set A</dt><dd>a</dd>", "<dt>Set B</dt><dd>all other parts</dd>"})
        EXPECT_NE(page.find(row), std::string::npos) << row;
    const std::size_t begin = view.find("id=\"header\">") + 12, end = view.find("</script>", begin);
    const json header = json::parse(view.substr(begin, end - begin));
    EXPECT_EQ(header["labels"], (json{"a", "b", "c", "d", "e", "f"}));
    EXPECT_EQ(header["metres"], 0.001);
    ASSERT_EQ(header["clashes"].size(), 2) << "b crosses and d is near a; c touches it";
    const json& row = header["clashes"][0];
    EXPECT_EQ(row["where"], "9.5 5 5");
    EXPECT_NE(page.find(fmt::format("<a target=\"clash-3d\" href=\"./a%20b/v%261.html#clash={}\">3D</a>",
                                    row["id"].get<std::string>())),
              std::string::npos);
    around.environment[1].second = "yesterday";
    EXPECT_EQ(run(arguments, around).code, 64);
}

#ifdef ONCOLLIDE_XML

TEST_F(ClashReview, BcfHasATopicForEachClash)
{
    clash({"--clearance", "1mm", "-o", "1.json"});
    json edited = read_json("1.json");
    edited["clashes"][1]["comment"] = "see drawing 7";
    folder_.write("1.json", edited.dump());
    Surroundings around;
    around.environment = {{"SOURCE_DATE_EPOCH", "1772366400"}};
    std::vector<std::string> arguments{"clash",    "--clearance", "1mm",   "--baseline", "1.json", "--bcf",
                                       "r.bcfzip", "-o",          "2.bcf", "-o",         "r.json"};
    arguments.insert(arguments.begin() + 1, files_.begin(), files_.end());
    const Outcome outcome = run(arguments, around);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(folder_.read("r.bcfzip"), folder_.read("2.bcf")) << "the same at the same time";
    const auto files = read_zip(folder_.read("r.bcfzip"));
    ASSERT_TRUE(files.contains("bcf.version"));
    EXPECT_EQ(bcf_faults(files), std::vector<std::string>());
    std::size_t topics = 0, lines = 0;
    std::string all;
    for (const auto& [name, text] : files) {
        if (name.ends_with("markup.bcf")) ++topics, all += text;
        if (name.ends_with(".bcfv")) lines += text.find("<Line>") != text.npos;
        if (name.ends_with(".png")) {
            EXPECT_TRUE(text.starts_with("\x89PNG")) << name;
        }
    }
    EXPECT_EQ(topics, 3u) << "a pair that only touches is none";
    EXPECT_EQ(lines, 1u) << "between parts that are near";
    for (const char* text : {"<Title>crossing: a and b</Title>", "TopicStatus=\"active\"",
                             "<Comment>see drawing 7</Comment>", "<CreationDate>2026-03-01T12:00:00Z</CreationDate>"})
        EXPECT_NE(all.find(text), std::string::npos) << text;
    const bool drawn = run({"doctor"}).out.find("llvmpipe") != std::string::npos;
    EXPECT_EQ(all.find("<Snapshot>snapshot.png</Snapshot>") != all.npos, drawn);

    // BCF 3.0 has the same topics.
    arguments.insert(arguments.end(), {"--bcf-version", "3.0"});
    EXPECT_EQ(run(arguments, around).code, 0);
    auto newer = read_zip(folder_.read("r.bcfzip"));
    EXPECT_EQ(bcf_faults(newer), std::vector<std::string>());
    for (const char* text : {"<TopicStatus>active</TopicStatus>", "<TopicLabel>enclosed</TopicLabel>"})
        EXPECT_NE(newer["extensions.xml"].find(text), std::string::npos) << text;
    EXPECT_EQ(newer.erase("extensions.xml"), 1u);
    EXPECT_EQ(newer.size(), files.size());
    for (const auto& [name, text] : newer) EXPECT_TRUE(files.contains(name)) << name;
    arguments.resize(arguments.size() - 2);

    // The same clashes are the same topics in the next run; without a renderer there is no picture.
    around.environment = {{"__EGL_VENDOR_LIBRARY_FILENAMES", "/nowhere"}};
    const Outcome blind = run(arguments, around);
    EXPECT_NE(blind.err.find("No pictures: "), std::string::npos) << blind.err;
    const auto again = read_zip(folder_.read("r.bcfzip"));
    EXPECT_EQ(bcf_faults(again), std::vector<std::string>());
    for (const auto& [name, text] : files) EXPECT_EQ(again.contains(name), !name.ends_with(".png")) << name;
}

TEST_F(ClashReview, BcfFaultsAreSeen)
{
    const std::string ok =
        "<Markup><Topic "
        "Guid='1'><Title>t</Title><CreationDate>d</CreationDate><CreationAuthor>a</CreationAuthor></Topic></Markup>";
    EXPECT_EQ(bcf_faults({{"x/markup.bcf", ok}}), std::vector<std::string>());
    EXPECT_EQ(bcf_faults({{"x/markup.bcf", ok.substr(0, 60)}}).size(), 1u);
    std::string wrong = ok;
    wrong.replace(wrong.find("<Title>t</Title>"), 16, ""), wrong.insert(wrong.find("</Topic>"), "<Title>t</Title>");
    EXPECT_EQ(bcf_faults({{"x/markup.bcf", wrong}}),
              (std::vector<std::string>{"x/markup.bcf: Title after CreationAuthor in Topic"}));
    EXPECT_EQ(bcf_faults({{"x/markup.bcf", "<Markup><Topics/></Markup>"}}),
              (std::vector<std::string>{"x/markup.bcf: Topics in Markup"}));
}

#endif

} // namespace
} // namespace oncollide::test

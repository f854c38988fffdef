// oncollide clash: groups, and reviews in the terminal and on the page.
#include "tools/browser.hpp"
#include "tools/command/clash/building_fixture.hpp"

namespace oncollide::test {
namespace {

using nlohmann::json;

class ClashGroups : public BuildingModel {
protected:
    /// A beam that crosses three pipes, and two pipes on another storey that cross each other.
    void write_storeys()
    {
        write_model({{"IfcPipeSegment", "p", "", "Level 1", 0.1},
                     {"IfcPipeSegment", "q", "", "Level 1", 2.9},
                     {"IfcBeam", "beam", "", "Level 1", 1, 2},
                     {"IfcPipeSegment", "r", "", "Level 2", 20},
                     {"IfcPipeSegment", "s", "", "Level 2", 20.75},
                     {"IfcPipeSegment", "t", "", "Level 1", 2.8}});
    }
    /// "Beam and PipeSegment 3" of each group.
    std::vector<std::string> groups(const std::string& keys, std::vector<std::string> more = {})
    {
        more.insert(more.end(), {"--group-by", keys, "-o", "r.json"});
        const Outcome outcome = clash_model(more);
        EXPECT_EQ(outcome.code, 1) << outcome.err;
        std::vector<std::string> found;
        std::size_t ids = 0;
        const json report = read_json("r.json");
        for (const json& group : report["groups"]) {
            found.push_back(fmt::format("{} {}", group["name"].get<std::string>(), group["count"].get<int>()));
            ids += group["clashes"].size();
            const std::string heading =
                fmt::format("\n{}: {} clash", group["name"].get<std::string>(), group["count"].get<int>());
            EXPECT_NE(outcome.out.find(heading), std::string::npos) << heading << "\n" << outcome.out;
        }
        EXPECT_EQ(ids, report["counts"]["new"]["crossing"].get<std::size_t>()) << "each clash is in one group";
        return found;
    }
    using Texts = std::vector<std::string>;
};

TEST_F(ClashGroups, AreByClassStoreyAndPart)
{
    write_storeys();
    auto sorted = [](Texts texts) { return std::ranges::sort(texts), texts; };
    EXPECT_EQ(sorted(groups("class")), (Texts{"Beam and PipeSegment 3", "PipeSegment 2"}));
    EXPECT_EQ(sorted(groups("storey")), (Texts{"Level 1 4", "Level 2 1"}));
    EXPECT_EQ(sorted(groups("discipline")), (Texts{"model 5"}));
    EXPECT_EQ(sorted(groups("storey,class")),
              (Texts{"Level 1, Beam and PipeSegment 3", "Level 1, PipeSegment 1", "Level 2, PipeSegment 1"}));
    EXPECT_EQ(sorted(groups("part")).front(), "Beam beam 3");
    EXPECT_EQ(sorted(groups("class", {"--set-a", "p", "--set-a", "q", "--set-a", "t"})),
              (Texts{"PipeSegment and Beam 3"}))
        << "the side of set A comes first";
    for (const char* keys : {"colour", "class,class", "class,"})
        expect_error(64, {"clash", "model.ifc", "--group-by", keys}, {"--group-by", "expected some of class, storey"});
}

TEST_F(ClashGroups, AMatrixSetsLimitsByClass)
{
    // Two walls cross by 0.1 m, a pipe is 0.5 m from the second one and crosses a duct by 0.2 m.
    write_model({{"IfcWall", "wall", "", "", 0},
                 {"IfcWallStandardCase", "wall 2", "", "", 0.9},
                 {"IfcPipeSegment", "pipe", "", "", 2.4},
                 {"IfcDuctSegment", "duct", "", "", 3.2}});
    const auto pairs_with = [&](const std::string& rules, int code) {
        folder_.write("m.json", "{\"by\": \"class\", \"rules\": [" + rules + "]}");
        const Outcome outcome = clash_model({"--matrix", "m.json", "--tolerance", "0", "-o", "r.json"});
        EXPECT_EQ(outcome.code, code) << outcome.err << outcome.out;
        return pairs("r.json");
    };
    const std::string walls = R"({"a": "Wall", "b": "IfcWall*", "skip": true})",
                      pipes = R"({"a": "Wall", "b": "Pipe*", "clearance": "600mm"})",
                      ducts = R"({"a": "Duct*", "b": "*", "tolerance": "0.3"})";
    EXPECT_EQ(pairs_with("", 1), (Pairs{"wall wall 2 crossing new", "pipe duct crossing new"}));
    EXPECT_EQ(pairs_with(walls, 1), (Pairs{"pipe duct crossing new"}));
    EXPECT_EQ(read_json("r.json")["skipped"], 1);
    EXPECT_EQ(pairs_with(walls + "," + pipes, 1), (Pairs{"pipe duct crossing new", "wall 2 pipe near new"}));
    EXPECT_EQ(pairs_with(walls + "," + ducts, 0), (Pairs{"pipe duct touching contact"}));
    EXPECT_EQ(pairs_with(R"({"a": "*", "b": "*", "skip": true},)" + pipes, 0), Pairs{}) << "the first rule that fits";
    EXPECT_EQ(read_json("r.json")["skipped"], 3) << "two that cross, and one within the largest clearance";

    folder_.write("m.json", R"({"rules": [{"a": "MEP*", "b": "model", "skip": true}]})");
    EXPECT_NE(clash_model({"--matrix", "m.json"}).err.find("m.json: no parts for rule 1 ('MEP*' and 'model')"),
              std::string::npos);
    EXPECT_EQ(clash_model({"--matrix", "m.json", "--strict"}).code, 65);
    for (const char* text :
         {"", "[]", "{", R"({"rules": [{"a": "x"}]})", R"({"rules": [{"a": "x", "b": "y", "clearance": "far"}]})",
          R"({"rules": [{"a": "x", "b": "y", "skip": 1}]})", R"({"rules": [], "by": "colour"})",
          R"({"rules": [], "rule": 1})"}) {
        folder_.write("m.json", text);
        const Outcome outcome = clash_model({"--matrix", "m.json"});
        EXPECT_EQ(outcome.code, 65) << text;
        EXPECT_NE(outcome.err.find("m.json: "), std::string::npos) << outcome.err;
    }
}

TEST_F(ClashGroups, StatusesAreSetInTheTerminal)
{
    clash({"--clearance", "1", "-o", "r.json"});
    const json before = read_json("r.json");
    const std::string id = before["clashes"][0]["id"], other = before["clashes"][1]["id"];
    EXPECT_EQ(
        run({"clash", "review", "r.json", "--set", id + "=approved,as planned, in \"7\"", "--set", other + "=reviewed"})
            .code,
        0);
    json after = read_json("r.json");
    EXPECT_EQ(after["clashes"][0]["status"], "approved");
    EXPECT_EQ(after["clashes"][0]["comment"], "as planned, in \"7\"");
    EXPECT_EQ(after["clashes"][1]["status"], "reviewed");
    EXPECT_EQ(after["counts"]["new"],
              (json{{"duplicate", 0}, {"enclosed", 0}, {"crossing", 0}, {"within", 0}, {"touching", 0}, {"near", 1}}));
    EXPECT_EQ(after["counts"]["active"]["enclosed"], 1);
    const std::string text = folder_.read("r.json");
    EXPECT_EQ(std::ranges::count(text, '\n'), 7) << "a line per clash";

    // The next run takes them over; the rest of the report has not changed.
    clash({"--clearance", "1", "--baseline", "r.json", "-o", "next.json"});
    EXPECT_EQ(read_json("next.json")["clashes"][0]["status"], "approved");
    for (const char* key : {"status", "comment"})
        for (const int i : {0, 1}) after["clashes"][i][key] = before["clashes"][i][key];
    after["counts"] = before["counts"];
    EXPECT_EQ(after, before);

    const Outcome listed = run({"clash", "review", "r.json"});
    EXPECT_EQ(listed.code, 0);
    EXPECT_NE(listed.out.find(id + "  approved  enclosed  b and e: as planned, in \"7\"\n"), std::string::npos)
        << listed.out;
    EXPECT_NE(listed.out.find("1 approved, 1 contact, 1 new, 1 reviewed\n"), std::string::npos) << listed.out;
    EXPECT_EQ(run({"clash", "review", "r.json", "--set", id + "=new,"}).code, 0);
    EXPECT_EQ(read_json("r.json")["clashes"][0]["comment"], "");

    const auto refused = [&](const std::string& set, const char* words) {
        const std::string kept = folder_.read("r.json");
        expect_error(64, {"clash", "review", "r.json", "--set", set}, {"--set", words});
        EXPECT_EQ(folder_.read("r.json"), kept);
    };
    refused("c0000000000000000=approved", "r.json has no clash with this id");
    refused(id, "no id"), refused("=approved", "no id"), refused(id + "= ,x", "no status");
    refused(id + "=resolved", "is not for users to set");
    refused(read_json("r.json")["clashes"][2]["id"].get<std::string>() + "=approved", "this pair is no clash");
    for (const char* content : {"[]", "{\"schema\": \"oncollide.clash\"}",
                                "{\"schema\": \"oncollide.clash\", \"clashes\": [1], \"resolved\": []}"}) {
        folder_.write("bad.json", content);
        expect_error(65, {"clash", "review", "bad.json"}, {"bad.json", "JSON report of 'oncollide clash'"});
    }
    expect_error(66, {"clash", "review", "absent.json"}, {"absent.json"});
    expect_error(64, {"clash"}, {"give part files"});
}

TEST_F(ClashGroups, ThePageFiltersAndSavesReviews)
{
    if (!std::filesystem::exists(chromium)) GTEST_SKIP() << chromium << " is absent";
    write_storeys();
    clash_model({"-o", "r.html", "-o", "r.json", "--pictures", "0", "--group-by", "class"});
    // A reader approves the first clash, then shows approved ones only, and saves.
    std::string page = folder_.read("r.html");
    page += R"(<script>
window.Blob = class { constructor(parts) { const out = document.createElement("pre"); out.id = "saved";
  out.textContent = btoa(parts.join("")); document.body.append(out); } };
URL.createObjectURL = () => "blob:none";
const bar = document.getElementById("filters"), row = document.querySelector("tr[data-status]");
const status = row.querySelector("select"); status.value = "approved"; status.dispatchEvent(new Event("change"));
const comment = row.querySelector("input"); comment.value = "ok </script"; comment.dispatchEvent(new Event("input"));
const filter = bar.querySelector("select[aria-label=status]"); filter.value = "approved"; filter.dispatchEvent(new Event("change"));
document.body.dataset.visible = [...document.querySelectorAll("tr[data-status]")].filter(row => !row.hidden).length;
document.body.dataset.choices = [...bar.querySelectorAll("select")].map(select => select.getAttribute("aria-label")).join();
bar.querySelector("button").click();
</script>)";
    page.replace(page.find("ok </script"), 11, "ok <\\/script");
    folder_.write("driven.html", page);
    const Outcome outcome =
        browse(folder_, {"--dump-dom", "--virtual-time-budget=5000", "file://" + (folder_ / "driven.html").string()});
    EXPECT_NE(outcome.out.find("data-visible=\"1\""), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.out.find("data-choices=\"status,class,storey\""), std::string::npos) << "others have one value";
    const std::size_t at = outcome.out.find("<pre id=\"saved\">");
    ASSERT_NE(at, std::string::npos) << outcome.err;
    std::string encoded = outcome.out.substr(at + 16, outcome.out.find("</pre>", at) - at - 16), saved;
    unsigned bits = 0, held = 0;
    for (const char c : encoded) {
        const std::size_t digit =
            std::string_view("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/").find(c);
        if (digit == std::string_view::npos) break;
        bits = bits << 6 | unsigned(digit), held += 6;
        if (held >= 8) held -= 8, saved += char(bits >> held & 0xff);
    }
    json expected = read_json("r.json");
    expected["clashes"][0]["status"] = "approved", expected["clashes"][0]["comment"] = "ok </script";
    json& counts = expected["counts"];
    counts["new"]["crossing"] = counts["new"]["crossing"].get<int>() - 1, counts["active"]["crossing"] = 1;
    EXPECT_EQ(json::parse(saved), expected);
    folder_.write("saved.json", saved);
    EXPECT_EQ(clash_model({"--baseline", "saved.json", "-o", "next.json"}).code, 0);
    EXPECT_EQ(read_json("next.json")["clashes"].back()["comment"].get<std::string>() +
                  read_json("next.json")["clashes"][0]["comment"].get<std::string>(),
              "ok </script");
}

} // namespace
} // namespace oncollide::test

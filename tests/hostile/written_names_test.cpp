// Names that contain the syntax of JSON, CSV, XML and HTML, in every file that a command writes; each file is parsed.
#include "tools/command_fixture.hpp"
#include "tools/csv_rows.hpp"
#include "tools/zip_files.hpp"
#include <oncollide/base/text/printable.hpp>
#include <oncollide/base/utf8.hpp>

namespace oncollide::test {
namespace {

/// Without a slash, for file names.
const std::string hostile = "a\"b\\c\nd\r<img src=x onerror=alert(1)>\x01\x1b[31m, #e\xe2\x80\xa8\xc3\xa4'&]]>--> ";
const std::string hostile_name = "</script></style></title>" + hostile;
const std::string hostile_file = hostile + "\xff\xfe";

/// True if every element is closed and no raw markup character is left. Reads only the subset of XML that the writers
/// use.
bool well_formed(std::string_view xml)
{
    std::vector<std::string> open;
    for (std::size_t at = 0; at < xml.size();) {
        if (static_cast<unsigned char>(xml[at]) < 0x20 && xml[at] != '\n') return false;
        if (xml[at] == '&') {
            const auto entities = {"&lt;", "&gt;", "&amp;", "&quot;"};
            if (std::ranges::none_of(entities, [&](const char* e) { return xml.substr(at).starts_with(e); }))
                return false;
        }
        if (xml[at++] != '<') continue;
        const std::size_t end = xml.find('>', at);
        if (end == xml.npos) return false;
        const std::string_view tag = xml.substr(at, end - at);
        if (std::ranges::count(tag, '"') % 2 || tag.find('<') != tag.npos) return false;
        const std::string name(tag.substr(0, tag.find_first_of(" \n/", 1)));
        at = end + 1;
        if (tag.starts_with('?') || tag.ends_with('/')) continue;
        if (!tag.starts_with('/'))
            open.push_back(name);
        else if (open.empty() || "/" + open.back() != name)
            return false;
        else
            open.pop_back();
    }
    return open.empty();
}

class WrittenNames : public CommandLine {
protected:
    void SetUp() override
    {
        nlohmann::json scene{{"name", hostile_name}, {"frames", 2}};
        write_cube("cube.off");
        scene["geometries"][hostile_name]["mesh"]["file"] = "cube.off";
        scene["bodies"] = {{{"name", hostile_name}, {"geometry", hostile_name}},
                           {{"name", hostile_name + "2"}, {"geometry", hostile_name}, {"position", {0.5, 0.2, 0.1}}}};
        folder_.write(scene_, scene.dump());
        write_cube(mesh_a_), write_cube(mesh_b_);
    }

    /// Runs a command that must not fail, whichever verdict it finds.
    void write(const std::vector<std::string>& arguments)
    {
        const Outcome outcome = run(arguments);
        EXPECT_LE(outcome.code, 2) << arguments[0] << ": " << outcome.err;
        EXPECT_EQ(printable_lines(outcome.out), outcome.out) << arguments[0];
    }
    std::vector<std::map<std::string, std::string>> csv(const std::string& name)
    {
        const std::string text = folder_.read(name);
        EXPECT_TRUE(as_utf8(text) == text) << name;
        return read_csv(text);
    }
    void expect_page(const std::string& name)
    {
        const std::string page = folder_.read(name);
        EXPECT_FALSE(page.empty());
        EXPECT_TRUE(as_utf8(page) == page) << name;
        EXPECT_EQ(page.find("<img src=x"), std::string::npos) << name << ": a name became an element";
        for (const std::string element : {"script", "style", "title"}) {
            std::size_t begins = 0, ends = 0;
            for (std::size_t at = 0; (at = page.find("<" + element, at)) != page.npos; ++at) ++begins;
            for (std::size_t at = 0; (at = page.find("</" + element, at)) != page.npos; ++at) ++ends;
            EXPECT_EQ(begins, ends) << name << ": a name ended a " << element;
        }
    }

    const std::string scene_ = "s" + hostile_file + ".json", mesh_a_ = hostile_file + ".off", mesh_b_ = "b" + mesh_a_;
    const std::string stem_a_ = as_utf8(hostile_file), stem_b_ = "b" + stem_a_;
};

TEST_F(WrittenNames, OfAScene)
{
    write({"run", scene_, "--json", "r.json", "--csv", "r.csv", "--trace", "t.json", "--picture", "p.svg"});
    const nlohmann::json results = read_json("r.json");
    EXPECT_EQ(results["header"]["scene"], hostile_name);
    EXPECT_EQ(results["frames"][0]["pairs"][0][0], hostile_name);
    EXPECT_EQ(results["frames"][1]["pairs"][0][1], hostile_name + "2");
    ASSERT_EQ(csv("r.csv").size(), 2u);
    EXPECT_EQ(csv("r.csv")[0]["a"], hostile_name);
    EXPECT_EQ(csv("r.csv")[1]["b"], hostile_name + "2");
    const std::string title = read_json("t.json")["traceEvents"][0]["args"]["name"];
    EXPECT_NE(title.find(hostile_name), std::string::npos);
    EXPECT_TRUE(well_formed(folder_.read("p.svg")));
    write({"scene", scene_, "--out", "s.json"});
    EXPECT_EQ(read_json("s.json")["name"], hostile_name);
    EXPECT_TRUE(read_json("s.json")["geometries"].contains(hostile_name));
    EXPECT_EQ(read_json("s.json")["bodies"][0]["name"], hostile_name);
}

TEST_F(WrittenNames, OfASceneInParts)
{
    write({"run", scene_, "--csv", "whole.csv"});
    for (const std::string part : {"1", "2"}) write({"run", scene_, "--csv", part + ".csv", "--shard", part + "/2"});
    write({"merge", "1.csv", "2.csv", "--out", "merged.csv"});
    EXPECT_EQ(folder_.read("merged.csv"), folder_.read("whole.csv"));
}

TEST_F(WrittenNames, OfASceneThatIsJudged)
{
    write({"accuracy", scene_, "--depths", "2", "--json", "a.json", "--csv", "a.csv"});
    EXPECT_EQ(read_json("a.json")["header"]["scene"], hostile_name);
    EXPECT_EQ(csv("a.csv").size(), 1u);
    write(
        {"accuracy", "study", scene_, "--max-errors", "0.1", "--json", "s.json", "--csv", "s.csv", "--html", "s.html"});
    EXPECT_EQ(read_json("s.json")["header"]["title"], hostile_name);
    EXPECT_GE(csv("s.csv").size(), 2u);
    expect_page("s.html");
    write({"bench", "scene", scene_, "--csv", "b.csv", "--summary", "b2.csv"});
    EXPECT_EQ(csv("b.csv").size(), 2u);
    EXPECT_EQ(csv("b2.csv").at(0)["scene"], hostile_name);
}

TEST_F(WrittenNames, OfAPage)
{
    std::filesystem::create_directories(folder_ / "lib/examples/js/controls");
    for (const char* script : {"lib/three.min.js", "lib/examples/js/controls/OrbitControls.js"})
        folder_.write(script, "/* three </script> */");
    Surroundings around;
    around.environment.emplace_back("ONCOLLIDE_THREE", (folder_.path() / "lib").string());
    const Outcome outcome = run({"run", scene_, "--quiet", "--view", "v.html"}, around);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    expect_page("v.html");
}

TEST_F(WrittenNames, OfFiles)
{
    write({"check", mesh_a_, mesh_b_, "--json", "c.json", "--contacts", "c.csv"});
    EXPECT_NE(read_json("c.json")["frames"][0]["pairs"][0][0].get<std::string>().find(stem_a_), std::string::npos);
    EXPECT_GT(csv("c.csv").size(), 0u);
    write({"spheres", mesh_a_, "--depth", "2", "--directions", "10", "--json", "s.json", "--csv", "s.csv", "--levels",
           "l.csv"});
    EXPECT_EQ(read_json("s.json")["header"]["mesh"], stem_a_ + ".off");
    EXPECT_GT(csv("s.csv").size(), 0u);
    EXPECT_GT(csv("l.csv").size(), 0u);
    write({"bench", "narrow", mesh_a_, mesh_b_, "--distances", "0", "--repeats", "1", "--csv", "n.csv", "--plot",
           "n.svg"});
    EXPECT_EQ(csv("n.csv").at(0)["mesh_a"], stem_a_);
    EXPECT_EQ(csv("n.csv").at(0)["mesh_b"], stem_b_);
    EXPECT_TRUE(well_formed(folder_.read("n.svg")));
    write({"bench", "planner", mesh_a_, mesh_b_, "--poses", "100", "--csv", "p.csv"});
    EXPECT_EQ(csv("p.csv").at(0)["fixed"], stem_a_);
    write({"bench", "read", mesh_a_, "--csv", "r.csv"});
    EXPECT_EQ(csv("r.csv").at(0)["style"], stem_a_ + ".off");
}

TEST_F(WrittenNames, OfPartsThatClash)
{
    write({"clash", mesh_a_, mesh_b_, "--units", "m", "-o", "r.json", "-o", "r.csv", "-o", "r.xml", "-o", "r.html"});
    EXPECT_EQ(read_json("r.json")["clashes"][0]["a"]["name"], stem_a_);
    EXPECT_EQ(csv("r.csv").at(0)["a"], stem_a_);
    EXPECT_TRUE(well_formed(folder_.read("r.xml")));
    expect_page("r.html");
    const Outcome outcome = run({"clash", mesh_a_, mesh_b_, "--units", "m", "--ignore", "r.csv"});
    EXPECT_EQ(outcome.code, 0) << "the report, read as a list of known pairs, names both parts: " << outcome.out;
    EXPECT_EQ(run({"clash", mesh_a_, mesh_b_, "--units", "m", "--baseline", "r.json"}).code, 0);
    // A status and a comment that a user wrote, and all names in BCF.
    nlohmann::json edited = read_json("r.json");
    edited["clashes"][0]["status"] = edited["clashes"][0]["comment"] = "=" + hostile_name;
    folder_.write("edited.json", edited.dump());
    write({"clash", mesh_a_, mesh_b_, "--units", "m", "--baseline", "edited.json", "-o", "e.json", "-o", "e.csv", "-o",
           "e.xml", "-o", "e.html"});
    EXPECT_EQ(read_json("e.json")["clashes"][0]["comment"], "=" + hostile_name);
    EXPECT_EQ(csv("e.csv").at(0)["comment"], "'=" + hostile_name);
    EXPECT_EQ(csv("e.csv").at(0)["status"], "'=" + hostile_name);
    EXPECT_TRUE(well_formed(folder_.read("e.xml")));
    expect_page("e.html");
#ifdef ONCOLLIDE_XML
    write({"clash", mesh_a_, mesh_b_, "--units", "m", "--baseline", "edited.json", "--bcf", "r.bcfzip"});
    const auto files = read_zip(folder_.read("r.bcfzip"));
    EXPECT_GE(files.size(), 3u);
    EXPECT_EQ(bcf_faults(files), std::vector<std::string>());
    for (const auto& [name, text] : files) {
        if (name.ends_with(".png")) continue;
        EXPECT_TRUE(well_formed(text)) << name;
        EXPECT_TRUE(as_utf8(text) == text) << name;
    }
#endif
}

} // namespace
} // namespace oncollide::test

// oncollide clash on building models.
#include <regex>

#include "tools/command/clash/building_fixture.hpp"
#include "tools/zip_files.hpp"

namespace oncollide::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class ClashOfBuildings : public BuildingModel {
protected:
    void write_house()
    {
        write_model({{"IfcWallStandardCase", "Basic Wall:Exterior - Brick on Block:143478", "0WALL$_000000000000001",
                      "Level 1", 0},
                     {"IfcBeam", "HEA 200", "0BEAM00000000000000001", "Level 1", 0.75},
                     {"IfcBeam", "HEA 200", "0BEAM00000000000000002", "Level 2", 5},
                     {"IfcMember", "IfcMember 0MEMB00000000000000001", "not a guid", "Level 2", 5.99}});
    }
};

TEST_F(ClashOfBuildings, ReportsNameElementsByClassAndName)
{
    write_house();
    const Outcome outcome = clash_model({"-o", "r.json"});
    EXPECT_EQ(outcome.code, 1) << outcome.err;
    for (const char* text : {"Wall Basic Wall:Exte...k on Block:143478", "  Beam HEA 200 (1)  ", "  Beam HEA 200 (2)  ",
                             "  Member 0MEMB00000000000000001  "})
        EXPECT_NE(outcome.out.find(text), std::string::npos) << outcome.out;
    EXPECT_TRUE(std::regex_search(outcome.out, std::regex("ball of (10|9[.]9[0-9]*) mm"))) << outcome.out;
    EXPECT_TRUE(std::regex_search(outcome.out, std::regex("ball of 0[.]2[45][0-9]* m "))) << outcome.out;
    const json wall = read_json("r.json")["clashes"][0]["a"];
    EXPECT_EQ(wall["name"], "Basic Wall:Exterior - Brick on Block:143478");
    EXPECT_EQ(wall["class"], "IfcWallStandardCase");
    EXPECT_EQ(wall["guid"], "0WALL$_000000000000001");
    EXPECT_EQ(wall["storey"], "Level 1");
    EXPECT_EQ(wall["discipline"], "model");
    EXPECT_FALSE(wall.contains("type")) << "it has none";
}

TEST_F(ClashOfBuildings, LengthsAndPositionsHaveTheDigitsThatCount)
{
    write_model({{"IfcSlab", "a", "", "", 0}, {"IfcSlab", "b", "", "", 1 - 1e-8}, {"IfcSlab", "c", "", "", 12345.5}});
    const Outcome outcome = clash_model({"--tolerance", "0"});
    EXPECT_TRUE(std::regex_search(outcome.out, std::regex("ball of (at most )?0[.]0000[0-9]+ mm"))) << outcome.out;
    EXPECT_NE(outcome.out.find("12,346 x 1 x 1 m"), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find("  1 0.5 0.5\n"), std::string::npos) << outcome.out;
    EXPECT_EQ(outcome.out.find("e-"), std::string::npos) << outcome.out;
}

TEST_F(ClashOfBuildings, ManyEqualNamesAreOneWarning)
{
    std::vector<Element> elements;
    for (int i = 0; i < 12; ++i) elements.push_back({"IfcPlate", std::string(1, char('a' + i / 2)), "", "", 2.0 * i});
    write_model(elements);
    EXPECT_EQ(clash_model({}).err,
              "oncollide: warning: 6 names occur several times, such as 'a'; the report adds their "
              "parent nodes, folders or numbers: 'a', 'a (2)'\n");
}

#ifdef ONCOLLIDE_XML
TEST_F(ClashOfBuildings, BcfNamesElementsByTheirGlobalId)
{
    write_house();
    for (const char* version : {"2.1", "3.0"}) {
        EXPECT_EQ(clash_model({"--bcf", "r.bcfzip", "--bcf-version", version, "--quiet"}).code, 1);
        const auto files = read_zip(folder_.read("r.bcfzip"));
        EXPECT_EQ(bcf_faults(files), std::vector<std::string>());
        std::string views;
        for (const auto& [name, text] : files)
            if (name.ends_with(".bcfv")) views += text;
        for (const char* text : {"<Component IfcGuid=\"0WALL$_000000000000001\">", "<Component>\n<OriginatingSystem>"})
            EXPECT_NE(views.find(text), std::string::npos) << views;
        EXPECT_EQ(views.find("not a guid"), std::string::npos) << "the schema does not allow it";
    }
    expect_error(64, {"clash", "model.ifc", "--bcf-version", "2.0"}, {"--bcf-version 2.0: expected 2.1 or 3.0"});
}
#endif

TEST_F(ClashOfBuildings, RealModelsGoThroughTheirConverter)
{
    const fs::path model = fs::path(ONCOLLIDE_SOURCE_DIR) / "clients/ifc/tests/house.ifc";
    const Outcome outcome = run({"clash", model.string(), "--units", "m", "-o", "r.json"});
    if (outcome.code == 66 && outcome.err.find("npm ci") != outcome.err.npos) GTEST_SKIP() << outcome.err;
    EXPECT_EQ(outcome.code, 1) << outcome.err;
    EXPECT_NE(outcome.err.find("left out: 1 IfcOpeningElement, 1 IfcSpace"), std::string::npos) << outcome.err;
    const json report = read_json("r.json");
    EXPECT_EQ(report["parts"], 5);
    const json& clash = report["clashes"][0];
    EXPECT_EQ(clash["a"]["class"], "IfcWall");
    EXPECT_EQ(clash["b"]["type"], "HEA 200");
    EXPECT_EQ(clash["a"]["path"], "house.ifc:Plot 7/House/Ground floor/IfcWall/Wall/north: 300 mm \u00fcber");
    EXPECT_NEAR(clash["where"][0].get<double>(), 452000.6, 1e-6);
    EXPECT_NEAR(clash["where"][1].get<double>(), 5411000, 1e-6);
    EXPECT_NEAR(clash["thickness"].get<double>(), 0.2, 1e-6);
}

} // namespace
} // namespace oncollide::test

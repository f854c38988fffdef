// oncollide-cad, and `oncollide clash` on files that these tests write: boxes, and shafts in bores, at known gaps.
#include <cmath>
#include <map>
#include <numbers>

#include <BRepAlgoAPI_Cut.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <BRepTools.hxx>
#include <IGESControl_Controller.hxx>
#include <IGESControl_Writer.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Writer.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <gp_Trsf.hxx>

#include "tools/command_fixture.hpp"

namespace oncollide::test {
namespace {

TopLoc_Location moved(double x, double y, double z, double turn = 0)
{
    gp_Trsf turned, shifted;
    turned.SetRotation(gp::OZ(), turn), shifted.SetTranslation({x, y, z});
    return shifted * turned;
}

/// An assembly that becomes a STEP file, in millimetres.
class Assembly {
public:
    Assembly()
    {
        Message::DefaultMessenger()->ChangePrinters().Clear();
        XCAFApp_Application::GetApplication()->NewDocument("MDTV-XCAF", document_);
        tool_ = XCAFDoc_DocumentTool::ShapeTool(document_->Main());
        root_ = tool_->NewShape();
        name(root_, "cell");
    }
    TDF_Label product(const TopoDS_Shape& shape, const char* called)
    {
        const TDF_Label label = tool_->AddShape(shape, false);
        name(label, called);
        return label;
    }
    TDF_Label group(const char* called)
    {
        const TDF_Label label = tool_->NewShape();
        name(label, called);
        return label;
    }
    void place(const TDF_Label& product, const TopLoc_Location& at, const char* called, const TDF_Label* in = nullptr)
    {
        name(tool_->AddComponent(in ? *in : root_, product, at), called);
    }
    void colour(const TDF_Label& product, double red, double green, double blue)
    {
        XCAFDoc_DocumentTool::ColorTool(document_->Main())
            ->SetColor(product, Quantity_Color(red, green, blue, Quantity_TOC_RGB), XCAFDoc_ColorSurf);
    }
    void write(const std::filesystem::path& file, const char* unit = "MM")
    {
        tool_->UpdateAssemblies();
        STEPCAFControl_Writer writer;
        Interface_Static::SetCVal("write.step.unit", unit);
        ASSERT_TRUE(writer.Transfer(document_, STEPControl_AsIs));
        ASSERT_EQ(writer.Write(file.c_str()), IFSelect_RetDone);
        Interface_Static::SetCVal("write.step.unit", "MM");
    }

private:
    static void name(const TDF_Label& label, const char* text)
    {
        TDataStd_Name::Set(label, TCollection_ExtendedString(text, true));
    }

    Handle(TDocStd_Document) document_;
    Handle(XCAFDoc_ShapeTool) tool_;
    TDF_Label root_;
};

/// A GLB file, read without oncollide.
struct Glb {
    nlohmann::json file;
    std::string bytes;

    explicit Glb(const std::string& content)
    {
        const auto word = [&](std::size_t at) { return *reinterpret_cast<const std::uint32_t*>(content.data() + at); };
        file = nlohmann::json::parse(content.substr(20, word(12)));
        bytes = content.substr(28 + word(12));
    }
    template <class Number>
    const Number* column(std::size_t accessor) const
    {
        const auto& view = file["bufferViews"][file["accessors"][accessor]["bufferView"].get<std::size_t>()];
        return reinterpret_cast<const Number*>(bytes.data() + view["byteOffset"].get<std::size_t>());
    }
    std::size_t count(std::size_t accessor) const { return file["accessors"][accessor]["count"]; }
    nlohmann::json node(const std::string& name) const
    {
        for (const auto& node : file["nodes"])
            if (node["name"] == name) return node;
        return {};
    }
    /// Directed edges without their reverse.
    std::size_t open_edges(std::size_t mesh) const
    {
        const std::size_t indices = file["meshes"][mesh]["primitives"][0]["indices"];
        const auto* at = column<std::uint32_t>(indices);
        std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
        for (std::size_t t = 0; t < count(indices); t += 3)
            for (int k = 0; k < 3; ++k)
                ++edges[{at[t + k], at[t + (k + 1) % 3]}], --edges[{at[t + (k + 1) % 3], at[t + k]}];
        return std::ranges::count_if(edges, [](const auto& edge) { return edge.second != 0; });
    }
    double volume(std::size_t mesh) const
    {
        const auto& primitive = file["meshes"][mesh]["primitives"][0];
        const auto* at = column<std::uint32_t>(primitive["indices"]);
        const auto* p = column<float>(primitive["attributes"]["POSITION"]);
        double six = 0;
        for (std::size_t t = 0; t < count(primitive["indices"]); t += 3) {
            const float *a = p + 3 * at[t], *b = p + 3 * at[t + 1], *c = p + 3 * at[t + 2];
            six += a[0] * (double(b[1]) * c[2] - double(b[2]) * c[1]) +
                   a[1] * (double(b[2]) * c[0] - double(b[0]) * c[2]) +
                   a[2] * (double(b[0]) * c[1] - double(b[1]) * c[0]);
        }
        return six / 6;
    }
};

class Cad : public CommandLine {
protected:
    Outcome convert(std::vector<std::string> arguments)
    {
        Surroundings around;
        around.folder = folder_.path();
        return run_program(ONCOLLIDE_CAD, std::move(arguments), around);
    }
    Glb converted(const std::string& file, std::vector<std::string> more = {})
    {
        more.insert(more.begin(), {file, "-o", "out.glb"});
        const Outcome outcome = convert(more);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_EQ(outcome.err, "");
        return Glb(folder_.read("out.glb"));
    }
    std::filesystem::path at(const char* name) { return folder_ / name; }

    /// Runs clash; returns the kind of each pair, "new" or "contact" behind it.
    std::map<std::string, std::string> kinds(const std::string& file, std::vector<std::string> more = {}, int code = -1)
    {
        more.insert(more.begin(), {"clash", file, "-o", "r.json"});
        const Outcome outcome = run(more);
        if (code >= 0) EXPECT_EQ(outcome.code, code) << outcome.out << outcome.err;
        EXPECT_LT(outcome.code, 2) << outcome.err;
        std::map<std::string, std::string> found;
        const nlohmann::json report = read_json("r.json");
        for (const auto& c : report["clashes"])
            found[c["a"]["name"].get<std::string>() + " " + c["b"]["name"].get<std::string>()] =
                c["kind"].get<std::string>() + " " + c["status"].get<std::string>();
        return found;
    }
};

TEST_F(Cad, AssembliesKeepTheirNamesInstancesColoursAndUnits)
{
    Assembly cell;
    const TDF_Label bolt = cell.product(BRepPrimAPI_MakeCylinder(4, 30).Shape(), "bolt M8");
    const TDF_Label plate = cell.product(BRepPrimAPI_MakeBox(100, 50, 10).Shape(), "plate \xc3\x84");
    cell.colour(plate, 1, 0, 0);
    const TDF_Label motor = cell.group("motor");
    cell.place(bolt, moved(1, 2, 3), "bolt-1", &motor);
    cell.place(bolt, moved(0, 0, 50, std::numbers::pi / 2), "bolt-2", &motor);
    cell.place(motor, moved(1000, 0, 0), "motor left");
    cell.place(motor, moved(-1000, 0, 0), "motor right");
    cell.place(plate, moved(0, 0, 0), "NAUO7");
    for (const auto& [unit, size] : {std::pair{"MM", 1.}, {"M", 1000.}, {"INCH", 25.4}}) { // the same numbers in each
        SCOPED_TRACE(unit);
        cell.write(at("cell.step"), unit);
        const Glb glb = converted("cell.step");
        EXPECT_EQ(glb.file["meshes"].size(), 2u) << "instances share their mesh";
        EXPECT_EQ(glb.file["nodes"].size(), 8u);
        const auto left = glb.node("motor left"), first = glb.node("bolt-1"), of_plate = glb.node("plate \xc3\x84");
        EXPECT_NEAR(left["matrix"][12].get<double>(), size, 1e-12 * size);
        EXPECT_NEAR(first["matrix"][13].get<double>(), 0.002 * size, 1e-14 * size);
        EXPECT_EQ(left["children"].size(), 2u);
        ASSERT_TRUE(of_plate.contains("mesh")) << "the name of the part replaces a generated name of the instance";
        const auto& red = glb.file["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"];
        EXPECT_NEAR(red[0].get<double>(), 1, 1e-6);
        EXPECT_NEAR(red[1].get<double>(), 0, 1e-6);
        EXPECT_NEAR(glb.volume(of_plate["mesh"]), 5e-5 * std::pow(size, 3), 1e-11 * std::pow(size, 3));
        EXPECT_LT(of_plate["extras"]["deflection"].get<double>(), 1e-7 * size) << "planes are exact up to rounding";
    }
    const std::string again = folder_.read("out.glb");
    converted("cell.step");
    EXPECT_EQ(folder_.read("out.glb"), again);
}

TEST_F(Cad, SolidsAreClosedAndNoFartherFromTheirSurfaceThanStated)
{
    const std::map<std::string, TopoDS_Shape> shapes{
        {"sphere", BRepPrimAPI_MakeSphere(20).Shape()},
        {"torus", BRepPrimAPI_MakeTorus(20, 5).Shape()},
        {"cylinder", BRepPrimAPI_MakeCylinder(10, 40).Shape()},
        {"bored", BRepAlgoAPI_Cut(BRepPrimAPI_MakeBox(gp_Pnt(-20, -20, 0), 40, 40, 20).Shape(),
                                  BRepPrimAPI_MakeCylinder(10, 20).Shape())
                      .Shape()}};
    // The distance of a point, in millimetres, from the curved surface of the shape, or from its planes.
    const std::map<std::string, std::function<double(double, double, double)>> distance{
        {"sphere", [](double x, double y, double z) { return std::abs(std::hypot(x, y, z) - 20); }},
        {"torus", [](double x, double y, double z) { return std::abs(std::hypot(std::hypot(x, y) - 20, z) - 5); }},
        {"cylinder",
         [](double x, double y, double z) {
             return std::min({std::abs(std::hypot(x, y) - 10), std::abs(z), std::abs(z - 40)});
         }},
        {"bored", [](double x, double y, double z) {
             return std::min({std::abs(std::hypot(x, y) - 10), std::abs(z), std::abs(z - 20),
                              std::abs(std::abs(x) - 20), std::abs(std::abs(y) - 20)});
         }}};
    for (const auto& [name, shape] : shapes)
        for (const double wanted : {0.5, 0.1, 0.02}) {
            SCOPED_TRACE(fmt::format("{} {}", name, wanted));
            BRepTools::Write(shape, at("s.brep").c_str());
            const Glb glb = converted("s.brep", {"--deflection", fmt::format("{}mm", wanted)});
            ASSERT_EQ(glb.file["meshes"].size(), 1u);
            EXPECT_EQ(glb.open_edges(0), 0u);
            EXPECT_GT(glb.volume(0), 0) << "the outside is out";
            const double stated = 1e3 * glb.node("s")["extras"]["deflection"].get<double>();
            EXPECT_LE(stated, wanted * 1.001);
            EXPECT_GT(stated, wanted / 100) << "a mesh a hundred times as fine as requested";
            const auto& primitive = glb.file["meshes"][0]["primitives"][0];
            const auto* triangle = glb.column<std::uint32_t>(primitive["indices"]);
            const auto* p = glb.column<float>(primitive["attributes"]["POSITION"]);
            double most = 0; // a finer grid of points than the program measures
            constexpr int grid = 12;
            for (std::size_t t = 0; t < glb.count(primitive["indices"]); t += 3)
                for (int i = 0; i <= grid; ++i)
                    for (int j = 0; i + j <= grid; ++j) {
                        double at[3];
                        for (int k = 0; k < 3; ++k)
                            at[k] = 1e3 *
                                    (i * double(p[3 * triangle[t] + k]) + j * double(p[3 * triangle[t + 1] + k]) +
                                     (grid - i - j) * double(p[3 * triangle[t + 2] + k])) /
                                    grid;
                        most = std::max(most, distance.at(name)(at[0], at[1], at[2]));
                    }
            EXPECT_LE(most, stated);
        }
}

/// A block with a bore of 20 mm and its core, a shaft below, and two plates.
void write_fit(const std::filesystem::path& file, double gap)
{
    Assembly fit;
    const TopoDS_Shape block = BRepAlgoAPI_Cut(BRepPrimAPI_MakeBox(gp_Pnt(-30, -30, 0), 60, 60, 40).Shape(),
                                               BRepPrimAPI_MakeCylinder(10, 40).Shape())
                                   .Shape();
    fit.place(fit.product(block, "block"), {}, "block");
    fit.place(fit.product(BRepPrimAPI_MakeCylinder(10 - gap, 60).Shape(), "shaft"), moved(0, 0, -70, 0.3),
              "below"); // 10 mm away
    fit.place(fit.product(BRepPrimAPI_MakeCylinder(10 - gap, 38).Shape(), "core"), moved(0, 0, 1, 0.3), "core");
    const TDF_Label plate = fit.product(BRepPrimAPI_MakeBox(60, 60, 5).Shape(), "plate"); // planes have no deflection
    fit.place(plate, moved(100, 0, 0), "low");
    fit.place(plate, moved(100, 0, 5 + gap), "high");
    fit.write(file);
}

TEST_F(Cad, GapsThatTheMeshesCannotTellAreWithin)
{
    // Negative: an overlap. The deflection of a part is at most the one requested.
    for (const double gap : {0., 0.01, 0.1, 1., -0.01, -0.1, -1.})
        for (const double deflection : {0.2, 0.02, 0.002}) {
            SCOPED_TRACE(fmt::format("gap {} mm, deflection {} mm", gap, deflection));
            write_fit(at("fit.step"), gap);
            const auto found =
                kinds("fit.step", {"--tolerance", "0.00001mm", "--deflection", fmt::format("{}mm", deflection)});
            const auto kind = [&](const char* pair) { return found.contains(pair) ? found.at(pair) : "apart"; };
            EXPECT_EQ(kind("low high"), gap < 0 ? "crossing new" : gap > 0 ? "apart" : "touching contact");
            EXPECT_EQ(kind("below block"), "apart");
            EXPECT_EQ(kind("below core"), "apart");
            const std::string shaft = kind("block core");
            if (gap > 4 * deflection)
                EXPECT_EQ(shaft, "apart");
            else if (-gap > 4 * deflection)
                EXPECT_EQ(shaft, "crossing new");
            else if (std::abs(gap) <= 0.2 * deflection)
                EXPECT_EQ(shaft, "within contact");
            else
                EXPECT_TRUE(shaft == "within contact" || shaft == (gap > 0 ? "apart" : "crossing new")) << shaft;
        }
}

TEST_F(Cad, AReportStatesTheDeflections)
{
    write_fit(at("fit.step"), 0);
    EXPECT_EQ(kinds("fit.step", {"--deflection", "0.1mm"}, 0)["block core"], "within contact");
    const auto report = read_json("r.json");
    EXPECT_GT(report["deflection"], 0.01);
    EXPECT_LE(report["deflection"], 0.1001);
    for (const auto& c : report["clashes"])
        if (c["kind"] == "within")
            EXPECT_GT(c["a"]["deflection"].get<double>() + c["b"]["deflection"].get<double>(), 0);
    const Outcome plain = run({"clash", "fit.step"});
    EXPECT_NE(plain.out.find("the meshes deviate from the true surfaces by at most 0.0"), plain.out.npos) << plain.out;
    EXPECT_NE(plain.out.find("(within)"), plain.out.npos) << plain.out;
    EXPECT_EQ(kinds("fit.step", {"--touching"}, 1)["block core"], "within new");
    // A clearance that is certainly kept, and one that certainly is not.
    write_fit(at("fit.step"), 0.5);
    EXPECT_EQ(kinds("fit.step", {"--deflection", "0.01mm", "--clearance", "0.4mm"}, 0).size(), 0u);
    EXPECT_EQ(kinds("fit.step", {"--deflection", "0.01mm", "--clearance", "0.6mm"}, 1)["block core"], "near new");
    EXPECT_EQ(kinds("fit.step", {"--deflection", "0.2mm", "--clearance", "0.4mm"}, 0)["block core"], "within contact");
}

TEST_F(Cad, SolidsOfOneShapeAreParts)
{
    BRep_Builder builder;
    TopoDS_Compound both;
    builder.MakeCompound(both);
    builder.Add(both, BRepPrimAPI_MakeBox(10, 10, 10).Shape());
    builder.Add(both, BRepPrimAPI_MakeBox(gp_Pnt(5, 5, 5), 10, 10, 10).Shape());
    BRepTools::Write(both, at("both.brep").c_str());
    EXPECT_EQ(kinds("both.brep", {}, 1), (std::map<std::string, std::string>{{"solid 1 solid 2", "crossing new"}}));
    IGESControl_Controller::Init();
    IGESControl_Writer writer("MM", 0); // faces alone
    writer.AddShape(both);
    ASSERT_TRUE(writer.Write(at("both.igs").c_str()));
    EXPECT_EQ(kinds("both.igs", {}, 1).size(), 1u) << "loose faces are joined to solids";
    EXPECT_EQ(read_json("r.json")["open"].size(), 0u);
}

TEST_F(Cad, FaultyFilesAreOneErrorThatNamesThem)
{
    write_fit(at("fit.step"), 1);
    const std::string whole = folder_.read("fit.step");
    BRepTools::Write(BRepPrimAPI_MakeBox(10, 10, 10).Shape(), at("box.brep").c_str());
    const std::string brep = folder_.read("box.brep");
    folder_.write("cut.step", whole.substr(0, whole.size() / 2));
    folder_.write("empty.step", "");
    folder_.write("noise.step", "\x01\xff noise");
    folder_.write("header.step", whole.substr(0, whole.find("DATA;")) + "DATA;\nENDSEC;\nEND-ISO-10303-21;\n");
    folder_.write("noise.igs", "no IGES\n");
    folder_.write("noise.brep", "no BREP\n");
    folder_.write("cut.brep", brep.substr(0, brep.size() / 2));
    BRepTools::Write(BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 0), gp_Pnt(1, 0, 0)).Shape(), at("wire.brep").c_str());
    BRepTools::Write(BRepPrimAPI_MakeBox(1e12, 1e12, 1e12).Shape(), at("huge.brep").c_str());
    for (const char* file : {"cut.step", "empty.step", "noise.step", "header.step", "noise.igs", "noise.brep",
                             "cut.brep", "wire.brep", "huge.brep"}) {
        SCOPED_TRACE(file);
        const Outcome outcome = run({"clash", file});
        EXPECT_TRUE(outcome.code == 65 || outcome.code == 66) << outcome.code;
        EXPECT_TRUE(outcome.err.starts_with(fmt::format("oncollide: {}: ", file))) << outcome.err;
        EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
    }
    EXPECT_EQ(convert({}).code, 64);
    EXPECT_EQ(convert({"none.step", "-o", "x.glb"}).code, 66);
    EXPECT_EQ(convert({"fit.step", "-o", "x.glb", "--deflection", "-1mm"}).code, 64);
    EXPECT_EQ(convert({"fit.step", "-o", "no/folder/x.glb"}).code, 73);
    EXPECT_EQ(convert({"fit.txt", "-o", "x.glb"}).code, 64);
    EXPECT_NE(convert({"--version"}).out.find("Open CASCADE 7"), std::string::npos);
}

TEST_F(Cad, FilesOfDebianAreRead)
{
    const std::filesystem::path data = "/usr/share/opencascade/data";
    if (std::error_code error; !std::filesystem::exists(data / "step/linkrods.step", error))
        GTEST_SKIP() << "Debian's occt-misc is not installed";
    for (const char* file : {"step/linkrods.step", "step/screw.step", "iges/bearing.iges", "occ/Motor-c.brep"}) {
        SCOPED_TRACE(file);
        EXPECT_EQ(convert({(data / file).string(), "-o", "out.glb"}).code, 0);
        EXPECT_GT(Glb(folder_.read("out.glb")).file["meshes"].size(), 0u);
    }
}

} // namespace
} // namespace oncollide::test

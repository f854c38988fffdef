// COLLADA and 3MF files: as meshes, as assemblies, as scenes, and their errors.
#include <gtest/gtest.h>
#ifdef ONCOLLIDE_XML
#include <zip.h>
#endif

#include "allocations.hpp"
#include "scenes/files/xml_writers.hpp"
#include "scenes/test_files.hpp"
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/files/scene_file.hpp>
#include <oncollide/scenes/files/threemf/zip_archive.hpp>

namespace oncollide {
namespace {

using Eigen::Vector3d;
using test::as_3mf;
using test::as_dae;
using test::expect_error;
using test::model_xml;
using test::object_xml;

class XmlAssembly : public ::testing::Test {
protected:
    void SetUp() override
    {
#ifndef ONCOLLIDE_XML
        GTEST_SKIP() << "skipped: a build without COLLADA and 3MF";
#endif
    }
    Assembly dae(const std::string& nodes, const std::string& asset = "<up_axis>Z_UP</up_axis>",
                 const std::string& libraries = "", double scale = 1)
    {
        return load_assembly(folder_.write("a.dae", as_dae(box_, nodes, asset, libraries)),
                             {.scale = scale, .threads = 2});
    }
    Assembly threemf(const std::string& resources, const std::string& build, const std::string& unit = "meter")
    {
        return load_assembly(folder_.write("a.3mf", as_3mf(model_xml(resources, build, unit), other_)));
    }
    void expect_bad(const std::string& name, const std::string& bytes, std::string_view part)
    {
        SCOPED_TRACE(part);
        const auto path = folder_.write(name, bytes);
        expect_error(
            ErrorKind::bad_data, [&] { load_assembly(path); }, path.string() + ": ", part);
        expect_error(
            ErrorKind::bad_data, [&] { load_mesh(path); }, path.string() + ": ", part);
    }
    /// The same file with a piece replaced.
    void expect_bad_dae(const std::string& from, const std::string& to, std::string_view part)
    {
        std::string text = as_dae(box_);
        ASSERT_NE(text.find(from), text.npos) << from;
        expect_bad("a.dae", text.replace(text.find(from), from.size(), to), part);
    }
    void expect_bad_model(const std::string& resources, const std::string& build, std::string_view part)
    {
        expect_bad("a.3mf", as_3mf(model_xml(resources, build)), part);
    }
    static const Mesh& mesh_of(const Assembly& assembly, std::size_t part)
    {
        return std::get<Mesh>(assembly.meshes[assembly.parts[part].mesh]->data);
    }

    const Mesh box_ = make_box_mesh({1, 2, 3});
    const std::string shown_ = R"(<instance_geometry url="#g"/>)";
    const std::string box_object_ = object_xml(box_, 7, R"(name="bolt")");
    std::string other_;
    test::TemporaryFolder folder_;
};

TEST_F(XmlAssembly, KeepsEveryDigitOfEveryCoordinate)
{
    Mesh mesh = make_soup_mesh(5, 0.3, 1, 7);
    for (const auto& path :
         {folder_.write("a.dae", as_dae(mesh)),
          folder_.write("a.3mf", as_3mf(model_xml(object_xml(mesh, 1), R"(<item objectid="1"/>)")))}) {
        const Mesh found = load_mesh(path);
        ASSERT_EQ(found.triangles.size(), mesh.triangles.size());
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
            for (std::size_t k = 0; k < 3; ++k)
                EXPECT_EQ(found.vertices[found.triangles[i][k]], mesh.vertices[mesh.triangles[i][k]]);
    }
}

TEST_F(XmlAssembly, ColladaNodesArePartsAtTheirPlacesAndShareTheirMesh)
{
    const Assembly found =
        dae(R"(<node name="plant"><translate>10 0 0</translate><node name="left">)" + shown_ +
                R"(</node><node id="turned"><rotate>0 0 1 90</rotate><translate>0 20 0</translate>)" + shown_ +
                R"(</node><instance_node url="#cell"/></node>)",
            "<up_axis>Z_UP</up_axis>",
            R"(<library_nodes><node id="cell"><matrix>1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1</matrix>)" + shown_ +
                R"(<node><scale>1 1 2</scale>)" + shown_ + "</node></node></library_nodes>");
    ASSERT_EQ(found.parts.size(), 4u);
    EXPECT_EQ(found.meshes.size(), 2u) << "a scaled mesh is a separate mesh";
    EXPECT_EQ(found.parts[0].path, "plant/left");
    EXPECT_EQ(found.parts[0].above, 0u);
    EXPECT_EQ(found.parts[0].pose.translation(), Vector3d(10, 0, 0));
    EXPECT_EQ(found.parts[1].name, "turned");
    EXPECT_EQ(found.parts[1].pose.translation(), Vector3d(-10, 0, 0)) << "quarter turns are exact";
    EXPECT_EQ(found.parts[1].pose.linear().col(0), Vector3d(0, 1, 0));
    EXPECT_EQ(found.parts[2].path, "plant/cell");
    EXPECT_EQ(found.parts[2].pose.translation(), Vector3d(15, 6, 7));
    EXPECT_EQ(found.parts[3].path, "plant/cell/thing") << "a node without a name gets its mesh's name";
    EXPECT_EQ(mesh_of(found, 3).bounds.max, Vector3d(1, 2, 6));
}

TEST_F(XmlAssembly, ColladaUnitsAndAxesBecomeMetresAndZUp)
{
    const std::string node = "<node><translate>100 200 300</translate>" + shown_ + "</node>";
    const auto place = [&](const std::string& asset, double scale = 1) {
        const Assembly found = dae(node, asset, "", scale);
        return Vector3d(found.parts[0].pose * mesh_of(found, 0).bounds.max);
    };
    EXPECT_EQ(place("<up_axis>Z_UP</up_axis>"), Vector3d(101, 202, 303));
    EXPECT_TRUE(place("<unit meter=\"0.01\"/><up_axis> Z_UP\n</up_axis>").isApprox(Vector3d(1.01, 2.02, 3.03), 1e-15));
    // In rotated boxes another corner has the largest coordinates.
    EXPECT_EQ(dae(node, "").parts[0].pose.translation(), Vector3d(100, -300, 200)) << "y is up by default";
    EXPECT_EQ(dae(node, "<up_axis>X_UP</up_axis>").parts[0].pose.translation(), Vector3d(-200, -300, 100));
    EXPECT_EQ(place("<unit meter=\"1\"/><up_axis>Z_UP</up_axis>", 1000), Vector3d(101000, 202000, 303000));
    expect_bad_dae("<up_axis>Z_UP", "<up_axis>NORTH", "<up_axis> is 'NORTH'");
    expect_bad_dae("<up_axis>", "<unit meter=\"0,01\"/><up_axis>", "<unit> is of '0,01' metres");
}

TEST_F(XmlAssembly, ColladaFacesOfAllKindsAreRead)
{
    const auto triangles = [&](const std::string& faces) {
        std::string text = as_dae(box_);
        const std::size_t begin = text.find("<triangles"), end = text.find("</triangles>");
        text.replace(begin, end + 12 - begin, faces);
        return load_mesh(folder_.write("a.dae", text)).triangles.size();
    };
    const std::string corner = R"(<input semantic="VERTEX" source="#v" offset="0"/>)";
    EXPECT_EQ(triangles("<polylist count=\"2\">" + corner + "<vcount>4 3</vcount><p>0 1 3 2 4 5 6</p></polylist>"), 3u);
    EXPECT_EQ(triangles("<polygons count=\"2\">" + corner + "<p>0 1 3 2</p><p>4 5 6</p></polygons>"), 3u);
    EXPECT_EQ(triangles("<tristrips count=\"1\">" + corner + "<p>0 1 2 3 4</p></tristrips>"), 3u);
    EXPECT_EQ(triangles("<trifans count=\"1\">" + corner + "<p>0 1 2 3 4</p></trifans>"), 3u);
    EXPECT_EQ(triangles("<lines count=\"1\">" + corner + "<p>0 1</p></lines><triangles count=\"1\">" + corner +
                        "<p>0 1 2</p></triangles>"),
              1u)
        << "lines are ignored";
}

TEST_F(XmlAssembly, ColladaControllersShowWhatTheyDeform)
{
    const std::string skin = R"(<library_controllers><controller id="c"><skin source="#g"><bind_shape_matrix>)"
                             R"(1 0 0 5 0 1 0 0 0 0 1 0 0 0 0 1</bind_shape_matrix></skin></controller>)"
                             R"(<controller id="m"><morph source="#c"/></controller></library_controllers>)";
    static std::vector<std::string> warnings;
    warnings.clear();
    on_file_warning([](const std::string& line) { warnings.push_back(line); });
    const Assembly found = dae(R"(<node><instance_controller url="#m"/></node>)", "<up_axis>Z_UP</up_axis>", skin);
    on_file_warning(nullptr);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_NE(warnings[0].find("a.dae: 1 mesh has a skin or a morph, which is not applied"), std::string::npos)
        << warnings[0];
    ASSERT_EQ(found.parts.size(), 1u);
    EXPECT_EQ(found.parts[0].pose.translation(), Vector3d(5, 0, 0));
}

TEST_F(XmlAssembly, BadColladaIsRefusedWithItsLine)
{
    expect_bad_dae("<p>0 0 ", "<p>8 0 ", "line 16: <p> uses vertex 8, but there are 8 vertices");
    expect_bad_dae("<p>0 0 ", "<p>-1 0 ", "<p> holds '-1'");
    expect_bad_dae("<p>0 0 ", "<p>0 ", "has 71 numbers, but 2 make a corner");
    expect_bad_dae("<p>0 0 ", "<p>0 0 0 0 ", "1 corners too many");
    expect_bad_dae("<triangles count=\"12\"", "<triangles count=\"13\"", "announces 13 faces, but has 12");
    expect_bad_dae("count=\"24\">", "count=\"25\">", "announces 25 numbers, but has 24");
    expect_bad_dae("count=\"24\">", "count=\"24\">NaN ", "<float_array> holds 'NaN' at 0");
    expect_bad_dae("count=\"8\" stride=\"3\"", "count=\"9\" stride=\"3\"", "announces 9 positions");
    expect_bad_dae("count=\"8\" stride=\"3\"", "count=\"6148914691236517206\" stride=\"3\"", "announces");
    expect_bad_dae("count=\"8\" stride=\"3\"", "count=\"8\" stride=\"2\"", "announces 8 positions of 2 numbers");
    expect_bad_dae("url=\"#g\"", "url=\"#h\"", "<instance_geometry> refers to '#h', which is no element of that kind");
    expect_bad_dae("url=\"#g\"", "url=\"b.dae#g\"", "must be '#' and an id of this file");
    expect_bad_dae("url=\"#s\"", "url=\"#t\"", "refers to '#t'");
    expect_bad_dae("<node>", "<node><matrix>1 0 0 0</matrix>", "<matrix> has 4 numbers; it must have 16");
    expect_bad_dae("<node>", "<node><skew>45 0 1 0 1 0 0</skew>", "<skew> is not supported");
    expect_bad_dae("<node>", "<node><rotate>0 0 0 30</rotate>", "axis without direction");
    expect_bad_dae("<node>", "<node><scale>1e300 1 1</scale><scale>1e300 1 1</scale>", "");
    expect_bad_dae("<node>", "<node id=\"n\"><instance_node url=\"#n\"/>", "does 'n' instance itself?");
    expect_bad_dae("<node>", "<node id=\"n\"/><node id=\"n\">", "a second <node> has the id 'n'");
    expect_bad_dae("<COLLADA", "<!DOCTYPE COLLADA [<!ENTITY a \"b\">]><COLLADA", "the entity 'a' is declared");
    expect_bad_dae("</COLLADA>", "", "not well-formed XML: no element found");
    expect_bad_dae("</mesh>", "", "not well-formed XML: mismatched tag");
    expect_bad("a.dae", "<x/>", "not a COLLADA file: it holds <x>");
    expect_bad("a.dae", "<COLLADA/>", "the file has no <visual_scene>");
    expect_bad("a.dae", as_dae(box_, ""), "the file holds no triangle");
    std::string deep;
    for (int i = 0; i < 2000; ++i) deep += "<node>";
    expect_bad_dae("<node>", deep, "nested deeper than 1000 levels");
    const std::string whole = as_dae(box_);
    for (std::size_t size = 0; size < whole.size(); size += 97) expect_bad("a.dae", whole.substr(0, size), "");
}

TEST_F(XmlAssembly, ObjectsThatA3mfBuildPlacesAreParts)
{
    other_ = model_xml(object_xml(make_box_mesh({1, 1, 1}), 7, R"(name="nut")"), "", "centimeter");
    const Assembly found =
        threemf(box_object_ + R"(<object id="8" name="pair"><components><component objectid="7"/>)"
                              R"(<component objectid="7" transform="0 1 0 -1 0 0 0 0 1 1000 0 0"/>)"
                              R"(<component objectid="7" p:path="/3D/other.model"/></components></object>)",
                R"(<item objectid="7"/><item objectid="8" transform="1 0 0 0 1 0 0 0 1 0 0 2000"/>)", "millimeter");
    ASSERT_EQ(found.parts.size(), 4u);
    EXPECT_EQ(found.meshes.size(), 2u);
    EXPECT_EQ(found.parts[0].name, "bolt");
    EXPECT_EQ(found.parts[0].above, no_node_above);
    EXPECT_EQ(found.parts[2].path, "pair/bolt");
    EXPECT_EQ(mesh_of(found, 0).bounds.max, Vector3d(0.001, 0.002, 0.003)) << "millimetres become metres";
    EXPECT_TRUE(found.parts[2].pose.translation().isApprox(Vector3d(1, 0, 2), 1e-15));
    // Row vectors times the matrix: x becomes y.
    EXPECT_TRUE((found.parts[2].pose.linear() * Vector3d(1, 0, 0)).isApprox(Vector3d(0, 1, 0), 1e-15));
    EXPECT_EQ(found.parts[3].path, "pair/nut");
    EXPECT_NEAR(mesh_of(found, 3).bounds.max.x(), 0.01, 1e-17) << "of a model in centimetres";
}

TEST_F(XmlAssembly, Bad3mfIsRefusedWithItsLine)
{
    const std::string item = R"(<item objectid="7"/>)", zip = as_3mf(model_xml(box_object_, item));
    const auto changed = [&](const std::string& from, const std::string& to) {
        std::string text = box_object_;
        return text.replace(text.find(from), from.size(), to);
    };
    EXPECT_EQ(load_assembly(folder_.write("a.3mf", zip)).parts.size(), 1u);
    expect_bad_model(changed("v1=\"", "v1=\"9"), item, "a.3mf: 3D/3dmodel.model: line 4: the triangle uses vertex");
    expect_bad_model(changed("v1=\"", "v1=\"-"), item, "v1 of <triangle> is '-");
    expect_bad_model(changed("x=\"", "x=\"nan"), item, "coordinate x is 'nan");
    expect_bad_model(changed("x=\"", "w=\""), item, "<vertex> has no x");
    expect_bad_model(box_object_ + box_object_, item, "a second object has the id 7");
    expect_bad_model(box_object_, R"(<item objectid="9"/>)", "there is no object 9 in 3D/3dmodel.model");
    expect_bad_model(box_object_, R"(<item objectid="7" transform="1 0 0"/>)", "the transform has 3 numbers");
    expect_bad_model(box_object_, R"(<item objectid="7" p:path="/3D/none.model"/>)",
                     "3D/none.model: the archive has no such file");
    expect_bad_model(box_object_, "", "the file holds no triangle");
    expect_bad_model(R"(<object id="7"><components><component objectid="7"/></components></object>)", item,
                     "is object 7 a component of itself?");
    expect_bad_model(box_object_ + R"(<object id="8"><components><component objectid="7"/><component objectid="8"/>)"
                                   "</components></object>",
                     R"(<item objectid="8"/>)", "is object 8 a component of itself?");
    expect_bad("a.3mf", as_3mf(model_xml(box_object_, item, "mile")), "the unit is 'mile'");
    std::string model = model_xml(box_object_, item);
    model.insert(model.find(" unit"), R"( requiredextensions="b" xmlns:b="http://example.org/beams")");
    expect_bad("a.3mf", as_3mf(model), "the extension 'b' ('http://example.org/beams') is not supported");
    expect_bad("a.3mf", as_3mf("<x/>"), "not a 3MF model: it holds <x>");
    expect_bad("a.3mf", test::as_zip({{"a", "b"}}), "_rels/.rels: the archive has no such file");
    expect_bad("a.3mf", test::as_zip({{"_rels/.rels", "<a/>"}}), "it names no 3D model");
    expect_bad("a.3mf", "no archive", "not a valid zip archive");
    std::string damaged = zip;
    damaged[damaged.find("<vertex x=\"") + 11] ^= 1;
    expect_bad("a.3mf", damaged, "3D/3dmodel.model: ");
    for (std::size_t size = 0; size < zip.size(); size += 101) expect_bad("a.3mf", zip.substr(0, size), "");
}

/// Files of `levels` objects or nodes, each two instances of the next; the last has the content.
std::string doubling_3mf(int levels, const std::string& content)
{
    std::string objects = fmt::format(R"(<object id="{}">{}</object>)", levels, content);
    for (int i = levels - 1; i > 0; --i)
        objects += fmt::format(R"(<object id="{0}"><components><component objectid="{1}"/><component objectid="{1}"/>)"
                               "</components></object>",
                               i, i + 1);
    return as_3mf(model_xml(objects, R"(<item objectid="1"/>)"));
}
std::string doubling_dae(int levels, const Mesh& mesh, const std::string& content)
{
    std::string nodes = fmt::format(R"(<node id="n{}">{}</node>)", levels, content);
    for (int i = levels - 1; i > 0; --i)
        nodes +=
            fmt::format(R"(<node id="n{0}"><instance_node url="#n{1}"/><instance_node url="#n{1}"/></node>)", i, i + 1);
    return as_dae(mesh, R"(<node><instance_node url="#n1"/></node>)", "<up_axis>Z_UP</up_axis>",
                  "<library_nodes>" + nodes + "</library_nodes>");
}

TEST_F(XmlAssembly, InstancesAreCountedBeforeAnyOfThemIsMade)
{
    const std::string object = object_xml(box_, 7), mesh = object.substr(object.find('>') + 1);
    const std::string box = mesh.substr(0, mesh.find("</object>"));
    EXPECT_EQ(load_assembly(folder_.write("a.3mf", doubling_3mf(10, box))).parts.size(), 512u);
    EXPECT_EQ(load_assembly(folder_.write("a.dae", doubling_dae(10, box_, shown_))).parts.size(), 512u);
    const auto refuse = [&](const std::string& name, const std::string& bytes, const auto& load,
                            std::string_view part) {
        SCOPED_TRACE(name + ": " + std::string(part));
        const auto path = folder_.write(name, bytes);
        const std::size_t before = allocated_bytes;
        expect_error(
            ErrorKind::bad_data, [&] { load(path); }, path.string() + ": ", part);
        EXPECT_LT(allocated_bytes - before, 4'000'000u) << "nodes were made before they were counted";
    };
    const auto whole = [](const std::filesystem::path& path) { load_mesh(path); };
    const auto parts = [](const std::filesystem::path& path) { load_assembly(path); };
    const std::string limit =
        "expand to more than 10000000 triangles, vertices and parts of meshes; the limit is the size "
        "of its files in bytes, but at least 10000000 and at most 200000000";
    for (const int levels : {24, 60, 900}) { // at 24 and above the parts alone are too many
        refuse("a.3mf", doubling_3mf(levels, box), parts, limit);
        refuse("a.dae", doubling_dae(levels, box_, shown_), parts, limit);
        refuse("a.3mf", doubling_3mf(levels, box), whole, limit);
    }
    refuse("a.3mf", doubling_3mf(20, box), whole, limit); // a million nodes, and 21 pieces each
    refuse("a.dae", doubling_dae(20, box_, shown_), whole, limit);
    refuse("a.3mf", doubling_3mf(23, ""), parts, "the file holds no triangle");
    refuse("a.3mf", doubling_3mf(1001, box), parts, "nested deeper than 1000 levels");
}

TEST_F(XmlAssembly, InstancesMakeNoMorePartsThanAllowed)
{
    const std::string object = object_xml(box_, 7), mesh = object.substr(object.find('>') + 1);
    const std::string box = mesh.substr(0, mesh.find("</object>"));
    for (const auto& [name, eighteen, eight] :
         {std::tuple("a.3mf", doubling_3mf(18, box), doubling_3mf(8, box)),
          {"a.dae", doubling_dae(18, box_, shown_), doubling_dae(8, box_, shown_)}}) {
        const auto large = folder_.write(name, eighteen);
        expect_error(
            ErrorKind::bad_data, [&] { load_assembly(large); },
            std::string(name) + ": its instances make 131072 parts or more; the limit is 100000 (--max-parts)");
        const auto path = folder_.write(name, eight);
        expect_error(
            ErrorKind::bad_data, [&] { load_assembly(path, {.most_parts = 127}); }, "128 parts");
        const Assembly found = load_assembly(path, {.most_parts = 128});
        EXPECT_EQ(found.parts.size(), 128u);
        EXPECT_EQ(found.meshes.size(), 1u) << "instances share their geometry";
    }
    std::string items, nodes;
    for (int i = 0; i < 20; ++i) items += R"(<item objectid="7"/>)", nodes += "<node>" + shown_ + "</node>";
    const AssemblyOptions few{.most_parts = 3};
    EXPECT_EQ(load_assembly(folder_.write("a.3mf", as_3mf(model_xml(box_object_, items))), few).parts.size(), 20u)
        << "a file may have as many parts as it writes";
    EXPECT_EQ(load_assembly(folder_.write("a.dae", as_dae(box_, nodes)), few).parts.size(), 20u);
}

TEST_F(XmlAssembly, AnotherModelOf3mfHasItsOwnUnitAndNoReferences)
{
    // The object is in inches and stands 100 mm from the component's place, which is 10 mm from the item's.
    other_ = model_xml(object_xml(box_, 7) + R"(<object id="9"><components><component objectid="7" )"
                                             R"(transform="1 0 0 0 1 0 0 0 1 2 0 0"/></components></object>)",
                       R"(<item objectid="8"/>)", "inch"); // the specification: such a build is ignored
    const std::string pair = R"(<object id="8"><components><component objectid="9" p:path="/3D/other.model" )"
                             R"(transform="0 1 0 -1 0 0 0 0 1 0 10 0"/></components></object>)";
    const Assembly found =
        threemf(pair, R"(<item objectid="8" transform="1 0 0 0 1 0 0 0 1 1000 0 0"/>)", "millimeter");
    ASSERT_EQ(found.parts.size(), 1u);
    // A shift of 2 inches along x becomes one along y, from (1000, 10, 0) mm on.
    EXPECT_TRUE(found.parts[0].pose.translation().isApprox(Vector3d(1, 0.01 + 2 * 0.0254, 0), 1e-12));
    const Mesh whole = load_mesh(folder_.path() / "a.3mf");
    EXPECT_NEAR(whole.bounds.max.y() - whole.bounds.min.y(), 2 * 0.0254, 1e-12) << "the box's x, turned";
    other_ =
        model_xml(box_object_ + R"(<object id="9"><components><component objectid="7" p:path="/3D/3dmodel.model"/>)"
                                "</components></object>",
                  "", "inch");
    expect_error(
        ErrorKind::bad_data, [&] { threemf(pair, R"(<item objectid="8"/>)"); }, "a.3mf: 3D/other.model: line ",
        "only the root model may refer to another model");
}

#ifdef ONCOLLIDE_XML
TEST_F(XmlAssembly, AnArchiveThatUnpacksToAMultipleIsRefusedBeforeItIsRead)
{
    const std::filesystem::path path = folder_.path() / "bomb.3mf";
    zip_t* const archive = zip_open(path.c_str(), ZIP_CREATE, nullptr);
    const std::string files[] = {test::relationships_xml(),
                                 model_xml(box_object_ + std::string(100'000'000, ' '), R"(<item objectid="7"/>)")};
    const auto add = [&](const char* name, const std::string& text) {
        zip_file_add(archive, name, zip_source_buffer(archive, text.data(), text.size(), 0), 0);
    };
    add("_rels/.rels", files[0]), add("3D/3dmodel.model", files[1]);
    ASSERT_EQ(zip_close(archive), 0);
    ASSERT_LT(std::filesystem::file_size(path), 200'000u);
    expect_error(
        ErrorKind::bad_data, [&] { load_mesh(path); },
        "bomb.3mf: 3D/3dmodel.model: it unpacks to more than 100 times the archive and 16 MiB");
    const FileBytes bytes = read_large_file(path, 1'000'000);
    int pieces = 0;
    EXPECT_THROW(ZipArchive({"bomb", bytes}).read("3D/3dmodel.model", [&](std::string_view) { ++pieces; }), Error);
    EXPECT_EQ(pieces, 0) << "the directory of the archive says its size";
}
#endif

TEST_F(XmlAssembly, RunAsScenesWithANameForEachBody)
{
    const auto path =
        folder_.write("a.3mf", as_3mf(model_xml(box_object_, R"(<item objectid="7"/><item objectid="7"/>)")));
    const Scene scene = load_assembly_scene(path);
    ASSERT_EQ(scene.poses.size(), 2u);
    EXPECT_EQ(scene.geometries.size(), 1u);
    EXPECT_TRUE(scene.find("bolt"));
    EXPECT_TRUE(scene.find("bolt (2)"));
    EXPECT_TRUE(is_assembly_file("A.DAE"));
    EXPECT_FALSE(is_assembly_file("a.stl"));
}

} // namespace
} // namespace oncollide

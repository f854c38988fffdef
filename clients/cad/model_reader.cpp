// Reads files by Open CASCADE's exchange of documents, which keeps names, instances and colours.
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>

#include <fmt/format.h>

#include <BRepBuilderAPI_MakeSolid.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <IGESCAFControl_Reader.hxx>
#include <Interface_CheckIterator.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Quantity_ColorRGBA.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDF_Tool.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>

#include "shape_mesher.hpp"

namespace oncollide::cad {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_nodes = 1'000'000;

std::string extension_of(const std::string& file)
{
    std::string extension = fs::path(file).extension().string();
    std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return extension;
}

std::string name_of(const TDF_Label& label)
{
    Handle(TDataStd_Name) name;
    if (!label.FindAttribute(TDataStd_Name::GetID(), name)) return {};
    const TCollection_ExtendedString& text = name->Get();
    std::string utf8(std::size_t(text.LengthOfCString()) + 1, '\0');
    Standard_PCharacter to = utf8.data();
    utf8.resize(std::size_t(text.ToUTF8CString(to)));
    while (!utf8.empty() && utf8.back() == '\0') utf8.pop_back();
    return utf8;
}

/// True for the names that programs and Open CASCADE give to instances without one: "NAUO12", "=>[0:1:1:2]".
bool is_made_up(const std::string& name)
{
    for (const char* type : {"COMPOUND", "COMPSOLID", "SOLID", "SHELL", "FACE", "the product name"})
        if (name == type) return true;
    return name.empty() || name.starts_with("NAUO") || name.starts_with("NUAO") || name.starts_with("=>[") ||
           std::ranges::all_of(name, [](unsigned char c) { return std::isdigit(c) || c == ' '; });
}

class ModelReader {
public:
    ModelReader(const Handle(TDocStd_Document) & document, const Options& options, std::string file_name)
        : shapes_(XCAFDoc_DocumentTool::ShapeTool(document->Main())),
          colours_(XCAFDoc_DocumentTool::ColorTool(document->Main())), options_(options),
          file_name_(std::move(file_name))
    {
    }

    Model read()
    {
        TDF_LabelSequence roots;
        shapes_->GetFreeShapes(roots);
        for (const TDF_Label& root : roots) add(root, {}, 1, model_.roots);
        std::size_t triangles = 0;
        for (const Mesh& mesh : model_.meshes) triangles += mesh.triangles.size();
        if (triangles == 0) throw Fault(bad_data, "it holds no surface");
        if (without_faces_ > 0)
            model_.warnings.push_back(fmt::format("{} part{} no surface, and left out: '{}'", without_faces_,
                                                  without_faces_ == 1 ? " has" : "s have", first_without_faces_));
        return std::move(model_);
    }

private:
    void add(const TDF_Label& label, const TopLoc_Location& above, double scale, std::vector<std::size_t>& to)
    {
        if (model_.nodes.size() >= most_nodes)
            throw Fault(bad_data, fmt::format("its instances make more than {} parts", most_nodes));
        TDF_Label of = label;
        TopLoc_Location location = above;
        std::string name = name_of(label);
        if (XCAFDoc_ShapeTool::IsReference(label)) {
            XCAFDoc_ShapeTool::GetReferredShape(label, of);
            location = location * XCAFDoc_ShapeTool::GetLocation(label);
            if (is_made_up(name)) name = name_of(of);
        }
        TopoDS_Shape shape;
        if (!XCAFDoc_ShapeTool::IsAssembly(of)) {
            shape = XCAFDoc_ShapeTool::GetShape(of);
            if (shape.IsNull()) return;
            location = location * shape.Location(); // of a single shape, such as a BREP file's
            shape.Location({});
        }
        if (is_made_up(name)) name = file_name_;
        const gp_Trsf trsf = location.Transformation();
        scale *= std::abs(trsf.ScaleFactor());
        const std::size_t node = model_.nodes.size();
        model_.nodes.push_back({std::move(name), matrix_of(trsf), scale, {}, {}});
        std::vector<std::size_t> children;
        if (XCAFDoc_ShapeTool::IsAssembly(of)) {
            TDF_LabelSequence components;
            XCAFDoc_ShapeTool::GetComponents(of, components);
            for (const TDF_Label& component : components) add(component, {}, scale, children);
        } else {
            const std::vector<std::size_t>& meshes = meshes_of(of, shape, model_.nodes[node].name);
            if (meshes.size() == 1) model_.nodes[node].meshes = meshes;
            if (meshes.size() > 1)
                for (const std::size_t mesh : meshes) {
                    children.push_back(model_.nodes.size());
                    model_.nodes.push_back({model_.mesh_names[mesh], matrix_of({}), scale, {}, {mesh}});
                }
            if (meshes.empty()) {
                if (without_faces_++ == 0) first_without_faces_ = model_.nodes[node].name;
            }
        }
        model_.nodes[node].children = std::move(children);
        to.push_back(node);
    }

    static std::array<double, 16> matrix_of(const gp_Trsf& trsf)
    {
        std::array<double, 16> matrix{};
        for (int row = 1; row <= 3; ++row)
            for (int column = 1; column <= 4; ++column)
                matrix[std::size_t(4 * (column - 1) + row - 1)] =
                    (column == 4 ? metres_per_unit : 1) * trsf.Value(row, column);
        matrix[15] = 1;
        return matrix;
    }

    const std::vector<std::size_t>& meshes_of(const TDF_Label& label, const TopoDS_Shape& shape,
                                              const std::string& name)
    {
        TCollection_AsciiString entry;
        TDF_Tool::Entry(label, entry);
        const auto [at, fresh] = of_label_.try_emplace(entry.ToCString());
        if (!fresh) return at->second;
        for (Piece& piece : mesh_of(shape, name, options_.deflection, model_.warnings)) {
            piece.mesh.colour = colour_of(label);
            at->second.push_back(model_.meshes.size());
            model_.meshes.push_back(std::move(piece.mesh));
            model_.mesh_names.push_back(piece.name.empty() ? name : piece.name);
        }
        return at->second;
    }

    std::optional<std::array<double, 4>> colour_of(const TDF_Label& label) const
    {
        Quantity_ColorRGBA colour;
        for (const XCAFDoc_ColorType type : {XCAFDoc_ColorSurf, XCAFDoc_ColorGen})
            if (colours_->GetColor(label, type, colour)) {
                const Quantity_Color& rgb = colour.GetRGB();
                return std::array<double, 4>{rgb.Red(), rgb.Green(), rgb.Blue(), colour.Alpha()};
            }
        return {};
    }

    Handle(XCAFDoc_ShapeTool) shapes_;
    Handle(XCAFDoc_ColorTool) colours_;
    const Options& options_;
    std::string file_name_;
    Model model_;
    std::map<std::string, std::vector<std::size_t>> of_label_; ///< indices of meshes
    std::size_t without_faces_ = 0;
    std::string first_without_faces_;
};

Handle(XSControl_WorkSession) session_of(const STEPCAFControl_Reader& reader)
{
    return reader.Reader().WS();
}
Handle(XSControl_WorkSession) session_of(const IGESCAFControl_Reader& reader)
{
    return reader.WS();
}

/// Fills the document. A reader of STEP or IGES.
template <class Reader>
void transfer(const char* format, const std::string& file, Handle(TDocStd_Document) & document,
              std::vector<std::string>& warnings)
{
    Reader reader;
    reader.SetNameMode(true), reader.SetColorMode(true), reader.SetLayerMode(false);
    if (reader.ReadFile(file.c_str()) != IFSelect_RetDone)
        throw Fault(bad_data, fmt::format("not a readable {} file", format));
    if (!reader.Transfer(document)) throw Fault(bad_data, "it holds no shape");
    std::size_t faults = 0;
    std::string first;
    const auto count = [&](const Interface_CheckIterator& list) {
        for (Interface_CheckIterator at = list; at.More(); at.Next())
            if (at.Value()->HasFailed() && faults++ == 0) first = at.Value()->CFail(1);
    };
    const Handle(XSControl_WorkSession) session = session_of(reader);
    count(session->ModelCheckList());
    count(session->TransferReader()->LastCheckList());
    if (faults > 0)
        warnings.push_back(fmt::format("{} of its entities have faults ({}); parts may be missing", faults, first));
}

/// Loose faces, as of most IGES files: joined along their edges, and made solids where they are closed.
TopoDS_Shape sewn(const TopoDS_Shape& shape)
{
    constexpr double tolerance = 1e-3; // mm
    BRepBuilderAPI_Sewing sewing(tolerance);
    BRep_Builder builder;
    TopoDS_Compound result;
    builder.MakeCompound(result);
    bool loose = false;
    for (TopExp_Explorer at(shape, TopAbs_SOLID); at.More(); at.Next()) builder.Add(result, at.Current());
    for (TopExp_Explorer at(shape, TopAbs_FACE, TopAbs_SOLID); at.More(); at.Next())
        sewing.Add(at.Current()), loose = true;
    if (!loose) return shape;
    sewing.Perform();
    const TopoDS_Shape joined = sewing.SewedShape();
    for (TopExp_Explorer at(joined, TopAbs_SHELL); at.More(); at.Next()) {
        const TopoDS_Shell& shell = TopoDS::Shell(at.Current());
        if (BRep_Tool::IsClosed(shell))
            builder.Add(result, BRepBuilderAPI_MakeSolid(shell).Solid());
        else
            builder.Add(result, shell);
    }
    for (TopExp_Explorer at(joined, TopAbs_FACE, TopAbs_SHELL); at.More(); at.Next()) builder.Add(result, at.Current());
    return result;
}

void sew_shapes(const Handle(TDocStd_Document) & document)
{
    const Handle(XCAFDoc_ShapeTool) tool = XCAFDoc_DocumentTool::ShapeTool(document->Main());
    TDF_LabelSequence labels;
    tool->GetShapes(labels);
    for (const TDF_Label& label : labels)
        if (XCAFDoc_ShapeTool::IsSimpleShape(label) && !XCAFDoc_ShapeTool::IsReference(label))
            tool->SetShape(label, sewn(XCAFDoc_ShapeTool::GetShape(label)));
}

Model read(const std::string& file, const Options& options)
{
    Handle(TDocStd_Document) document;
    XCAFApp_Application::GetApplication()->NewDocument("MDTV-XCAF", document);
    std::vector<std::string> warnings;
    const std::string extension = extension_of(file);
    if (extension == ".step" || extension == ".stp") {
        transfer<STEPCAFControl_Reader>("STEP", file, document, warnings);
    } else if (extension == ".iges" || extension == ".igs") {
        transfer<IGESCAFControl_Reader>("IGES", file, document, warnings);
        sew_shapes(document);
    } else {
        TopoDS_Shape shape;
        BRep_Builder builder;
        if (!BRepTools::Read(shape, file.c_str(), builder) || shape.IsNull())
            throw Fault(bad_data, "not a readable BREP file");
        XCAFDoc_DocumentTool::ShapeTool(document->Main())->AddShape(shape, false);
    }
    Model model = ModelReader(document, options, fs::path(file).stem().string()).read();
    model.warnings.insert(model.warnings.begin(), warnings.begin(), warnings.end());
    return model;
}

} // namespace

Model read_model(const std::string& file, const Options& options)
{
    constexpr std::array known{".step", ".stp", ".iges", ".igs", ".brep", ".brp"};
    if (std::ranges::find(known, extension_of(file)) == known.end())
        throw Fault(usage, "not a name that ends in .step, .stp, .iges, .igs, .brep or .brp");
    std::ifstream readable(file, std::ios::binary);
    if (!readable || readable.peek() == std::ifstream::traits_type::eof())
        throw Fault(no_input, readable ? "the file is empty" : "cannot be read");
    Message::DefaultMessenger()->ChangePrinters().Clear();
    try {
        return read(file, options);
    } catch (const Standard_Failure& failure) {
        const std::string what = failure.GetMessageString();
        throw Fault(bad_data, fmt::format("Open CASCADE cannot read it: {}",
                                          what.empty() ? failure.DynamicType()->Name() : what));
    }
}

} // namespace oncollide::cad

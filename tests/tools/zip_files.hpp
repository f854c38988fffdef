#pragma once
#ifdef ONCOLLIDE_XML
#include <algorithm>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/files/threemf/zip_archive.hpp>
#include <oncollide/scenes/files/xml/xml_reader.hpp>

namespace oncollide::test {

/// The files of a zip archive; their names are read from its directory.
inline std::map<std::string, std::string> read_zip(const std::string& bytes)
{
    const MeshSource source{"archive", bytes};
    const ZipArchive archive(source);
    std::map<std::string, std::string> files;
    for (std::size_t at = 0; (at = bytes.find("PK\1\2", at)) != bytes.npos; ++at) {
        std::uint16_t length = 0;
        std::memcpy(&length, bytes.data() + at + 28, sizeof(length));
        const std::string name = bytes.substr(at + 46, length);
        archive.read(name, [&](std::string_view piece) { files[name] += piece; });
    }
    return files;
}

/// Compares the elements of BCF files with the order in the schemas of BCF 2.1 or 3.0 (markup.xsd, visinfo.xsd,
/// version.xsd, extensions.xsd of buildingSMART/BCF-XML).
class BcfOrder : public XmlHandler {
public:
    explicit BcfOrder(bool version_3) : version_3_(version_3) {}
    void begin(const XmlTag& tag) override
    {
        const std::string name(tag.name);
        if (!open_.empty()) check(open_.back().first, name, open_.back().second);
        open_.emplace_back(name, "");
    }
    void end() override { open_.pop_back(); }

    std::vector<std::string> faults;

private:
    void check(const std::string& parent, const std::string& name, std::string& before)
    {
        static const std::map<std::string, std::vector<std::string>> orders{
            {"Version", {"DetailedVersion"}},
            {"Markup", {"Header", "Topic", "Comment", "Viewpoints"}},
            {"Header", {"File"}},
            {"File", {"Filename", "Date", "Reference"}},
            {"Topic",
             {"ReferenceLink", "Title", "Priority", "Index", "Labels", "CreationDate", "CreationAuthor", "ModifiedDate",
              "ModifiedAuthor", "DueDate", "AssignedTo", "Stage", "Description", "BimSnippet", "DocumentReference",
              "RelatedTopic"}},
            {"Comment", {"Date", "Author", "Comment", "Viewpoint", "ModifiedDate", "ModifiedAuthor"}},
            {"Viewpoints", {"Viewpoint", "Snapshot", "Index"}},
            {"VisualizationInfo",
             {"Components", "OrthogonalCamera", "PerspectiveCamera", "Lines", "ClippingPlanes", "Bitmap"}},
            {"Components", {"ViewSetupHints", "Selection", "Visibility", "Coloring"}},
            {"Selection", {"Component"}},
            {"Coloring", {"Color"}},
            {"Color", {"Component"}},
            {"Component", {"OriginatingSystem", "AuthoringToolId"}},
            {"PerspectiveCamera", {"CameraViewPoint", "CameraDirection", "CameraUpVector", "FieldOfView"}},
            {"CameraViewPoint", {"X", "Y", "Z"}},
            {"CameraDirection", {"X", "Y", "Z"}},
            {"CameraUpVector", {"X", "Y", "Z"}},
            {"Lines", {"Line"}},
            {"Line", {"StartPoint", "EndPoint"}},
            {"StartPoint", {"X", "Y", "Z"}},
            {"EndPoint", {"X", "Y", "Z"}},
        };
        static const std::map<std::string, std::vector<std::string>> of_version_3{
            {"Version", {}},
            {"Markup", {"Header", "Topic"}},
            {"Header", {"Files"}},
            {"Files", {"File"}},
            {"Topic",
             {"ReferenceLinks", "Title", "Priority", "Index", "Labels", "CreationDate", "CreationAuthor",
              "ModifiedDate", "ModifiedAuthor", "DueDate", "AssignedTo", "Stage", "Description", "BimSnippet",
              "DocumentReferences", "RelatedTopics", "Comments", "Viewpoints"}},
            {"Labels", {"Label"}},
            {"Comments", {"Comment"}},
            {"Viewpoints", {"ViewPoint"}},
            {"ViewPoint", {"Viewpoint", "Snapshot", "Index"}},
            {"Color", {"Components"}},
            {"Components", {"Selection", "Visibility", "Coloring", "Component"}}, // of the view, or of a colour
            {"PerspectiveCamera",
             {"CameraViewPoint", "CameraDirection", "CameraUpVector", "FieldOfView", "AspectRatio"}},
            {"Extensions",
             {"TopicTypes", "TopicStatuses", "Priorities", "TopicLabels", "Users", "SnippetTypes", "Stages"}},
            {"TopicTypes", {"TopicType"}},
            {"TopicStatuses", {"TopicStatus"}},
            {"TopicLabels", {"TopicLabel"}},
        };
        const bool newer = version_3_ && of_version_3.contains(parent);
        const auto& table = newer ? of_version_3 : orders;
        const auto order = table.find(parent);
        const auto place = [&](const std::string& of) {
            return order == table.end() ? std::ptrdiff_t(0)
                                        : std::ranges::find(order->second, of) - order->second.begin();
        };
        if (order == table.end() || place(name) == std::ssize(order->second))
            faults.push_back(name + " in " + parent);
        else if (!before.empty() && place(name) < place(before))
            faults.push_back(name + " after " + before + " in " + parent);
        before = name;
    }

    bool version_3_;
    std::vector<std::pair<std::string, std::string>> open_; ///< elements, each with its last child
};

/// Faults of the XML files of a BCF archive: text that is not well-formed, and elements that the schemas do not allow.
inline std::vector<std::string> bcf_faults(const std::map<std::string, std::string>& files)
{
    std::vector<std::string> faults;
    const auto version = files.find("bcf.version");
    const bool version_3 = version != files.end() && version->second.find("\"3.0\"") != std::string::npos;
    if (version_3 && !files.contains("extensions.xml")) faults.emplace_back("no extensions.xml");
    for (const auto& [name, text] : files) {
        if (name.ends_with(".png")) continue;
        BcfOrder order(version_3);
        try {
            read_xml({name, text}, order);
            for (const std::string& fault : order.faults) faults.push_back(name + ": " + fault);
        } catch (const Error& error) {
            faults.push_back(error.what());
        }
    }
    return faults;
}

} // namespace oncollide::test
#endif

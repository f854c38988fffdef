#include "clash/bcf_file.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include <fmt/chrono.h>

#include <oncollide/base/text/svg.hpp>

#include "clash/parts/part_ids.hpp"
#include "common/zip_bytes.hpp"

namespace oncollide::tools {
namespace {

constexpr std::string_view declaration = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";

/// A GUID of version 8 that depends on the text alone.
std::string guid_of(const std::string& text)
{
    const std::uint64_t high = hash_of("high " + text), low = hash_of("low " + text);
    return fmt::format("{:08x}-{:04x}-8{:03x}-{:04x}-{:012x}", high >> 32, high >> 16 & 0xffff, high & 0xfff,
                       0x8000 | (low >> 48 & 0x3fff), low & 0xffffffffffff);
}

std::string element(std::string_view name, std::string_view text)
{
    return fmt::format("<{0}>{1}</{0}>\n", name, xml_escaped(text));
}

std::string vector(std::string_view name, const Eigen::Vector3d& v)
{
    return fmt::format("<{0}><X>{1}</X><Y>{2}</Y><Z>{3}</Z></{0}>\n", name, v.x(), v.y(), v.z());
}

/// `content` within a list element, which BCF 2.1 has not.
std::string listed_in(std::string_view list, const std::string& content, BcfVersion version)
{
    return version == BcfVersion::v2_1 ? content : fmt::format("<{0}>\n{1}</{0}>\n", list, content);
}

/// True for a GlobalId of IFC, as the schemas require it.
bool is_ifc_guid(const std::string& guid)
{
    return guid.size() == 22 && std::ranges::all_of(guid, [](unsigned char c) {
               return c < 128 && (std::isalnum(c) || c == '_' || c == '$');
           });
}

/// Elements in the order of the schemas; see markup.xsd and visinfo.xsd of BCF 2.1 and 3.0.
class Topic {
public:
    Topic(const ClashReport& report, const Clash& clash, std::size_t number, BcfVersion version)
        : r_(report), c_(clash), number_(number), version_(version), guid_(guid_of(clash.id)),
          viewpoint_(guid_of("viewpoint " + clash.id)),
          date_(fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time_t(report.time))))
    {
    }

    const std::string& guid() const { return guid_; }

    std::string markup(bool has_snapshot) const
    {
        const bool old = version_ == BcfVersion::v2_1;
        std::string files, text(declaration);
        for (const std::string& file : std::set<std::string>{part(c_.a).file, part(c_.b).file})
            files += fmt::format("<File {}sExternal=\"true\">{}</File>\n", old ? "i" : "I", element("Filename", file));
        text += "<Markup>\n<Header>\n" + listed_in("Files", files, version_) + "</Header>\n";
        text += fmt::format("<Topic Guid=\"{}\" TopicType=\"Clash\" TopicStatus=\"{}\">\n", guid_,
                            xml_escaped(c_.status_text()));
        text += element("Title", fmt::format("{}: {} and {}", name_of(c_.kind), part(c_.a).label, part(c_.b).label));
        text += element("Index", std::to_string(number_)) +
                (old ? element("Labels", name_of(c_.kind))
                     : listed_in("Labels", element("Label", name_of(c_.kind)), version_));
        text += element("CreationDate", date_) + element("CreationAuthor", "oncollide");
        text += element("Description", fmt::format("{}: {}, at {} {}. Parts: {} and {}. Clash {}.", name_of(c_.kind),
                                                   measure_text(r_, c_), r_.position(c_.where), r_.unit.name,
                                                   part(c_.a).path, part(c_.b).path, c_.id));
        std::string comment;
        if (!c_.comment.empty()) {
            comment = fmt::format("<Comment Guid=\"{}\">\n", guid_of("comment " + c_.id));
            comment += element("Date", date_) + element("Author", "oncollide") + element("Comment", c_.comment);
            comment += fmt::format("<Viewpoint Guid=\"{}\"/>\n</Comment>\n", viewpoint_);
        }
        const std::string view = fmt::format("<{0} Guid=\"{1}\">\n<Viewpoint>viewpoint.bcfv</Viewpoint>\n{2}</{0}>\n",
                                             old ? "Viewpoints" : "ViewPoint", viewpoint_,
                                             has_snapshot ? "<Snapshot>snapshot.png</Snapshot>\n" : "");
        if (old) return text + "</Topic>\n" + comment + view + "</Markup>\n";
        if (!comment.empty()) text += listed_in("Comments", comment, version_);
        return text + listed_in("Viewpoints", view, version_) + "</Topic>\n</Markup>\n";
    }

    std::string viewpoint(const ClashView& view) const
    {
        const double metres = 1e-3 * r_.unit.millimetres;
        const Eigen::Vector3d eye = metres * (view.middle + view.from * (view.radius / std::sin(0.5 * angle)));
        const Eigen::Vector3d right = (-view.from).cross(Eigen::Vector3d::UnitZ()).normalized();
        std::string text(declaration);
        text += fmt::format("<VisualizationInfo Guid=\"{}\">\n<Components>\n<Selection>\n{}{}</Selection>\n"
                            "<Visibility DefaultVisibility=\"true\"/>\n<Coloring>\n",
                            viewpoint_, component(c_.a), component(c_.b));
        for (const auto& [colour, number] : {std::pair("FF3C78C8", c_.a), std::pair("FFE1A032", c_.b)})
            text += fmt::format("<Color Color=\"{}\">\n{}</Color>\n", colour,
                                listed_in("Components", component(number), version_));
        text += "</Coloring>\n</Components>\n<PerspectiveCamera>\n" + vector("CameraViewPoint", eye) +
                vector("CameraDirection", -view.from) + vector("CameraUpVector", right.cross(-view.from)) +
                fmt::format("<FieldOfView>{}</FieldOfView>\n{}</PerspectiveCamera>\n", degrees,
                            version_ == BcfVersion::v2_1 ? "" : "<AspectRatio>1</AspectRatio>\n");
        if (c_.apart())
            text += "<Lines>\n<Line>\n" + vector("StartPoint", metres * c_.nearest_a) +
                    vector("EndPoint", metres * c_.nearest_b) + "</Line>\n</Lines>\n";
        return text + "</VisualizationInfo>\n";
    }

private:
    static constexpr double degrees = 45, angle = degrees / 57.29577951308232; ///< the schema allows 45 to 60 degrees

    const Part& part(std::uint32_t number) const { return r_.parts.parts[number]; }
    std::string component(std::uint32_t number) const
    {
        const std::string& guid = part(number).details.guid;
        return fmt::format("<Component{}>\n",
                           is_ifc_guid(guid) ? fmt::format(" IfcGuid=\"{}\"", xml_escaped(guid)) : "") +
               element("OriginatingSystem", "oncollide") + element("AuthoringToolId", part(number).path) +
               "</Component>\n";
    }

    const ClashReport& r_;
    const Clash& c_;
    std::size_t number_;
    BcfVersion version_;
    std::string guid_, viewpoint_, date_;
};

std::string version_file(BcfVersion version)
{
    return std::string(declaration) +
           (version == BcfVersion::v2_1
                ? "<Version VersionId=\"2.1\">\n<DetailedVersion>2.1</DetailedVersion>\n</Version>\n"
                : "<Version VersionId=\"3.0\"/>\n");
}

/// The types, statuses and labels of all topics; BCF 3.0 requires this file.
std::string extensions_file(const std::set<std::string>& statuses, const std::set<std::string>& labels)
{
    std::string text = std::string(declaration) + "<Extensions>\n<TopicTypes>\n" + element("TopicType", "Clash") +
                       "</TopicTypes>\n<TopicStatuses>\n";
    for (const std::string& status : statuses) text += element("TopicStatus", status);
    text += "</TopicStatuses>\n<TopicLabels>\n";
    for (const std::string& label : labels) text += element("TopicLabel", label);
    return text + "</TopicLabels>\n</Extensions>\n";
}

} // namespace

void write_bcf(OutputFile& file, const ClashReport& r, const ClashPictures& pictures, BcfVersion version)
{
    std::vector<std::pair<std::string, std::string>> files{{"bcf.version", version_file(version)}};
    std::set<std::string> statuses, labels;
    std::size_t number = 0;
    for (std::size_t i = 0; i < r.found.list.size(); ++i) {
        const Clash& clash = r.found.list[i];
        if (clash.status != ClashStatus::fresh && clash.status != ClashStatus::active) continue;
        statuses.emplace(clash.status_text()), labels.emplace(name_of(clash.kind));
        const Topic topic(r, clash, ++number, version);
        const std::string& image = pictures.images[i];
        files.emplace_back(topic.guid() + "/markup.bcf", topic.markup(!image.empty()));
        files.emplace_back(topic.guid() + "/viewpoint.bcfv", topic.viewpoint(pictures.views[i]));
        if (!image.empty()) files.emplace_back(topic.guid() + "/snapshot.png", image);
    }
    if (version == BcfVersion::v3_0) files.emplace_back("extensions.xml", extensions_file(statuses, labels));
    file.write(zip_bytes(files, r.time));
}

} // namespace oncollide::tools

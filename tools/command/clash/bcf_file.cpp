#include "clash/bcf_file.hpp"

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

/// Elements in the order of the schema; see markup.xsd and visinfo.xsd of BCF 2.1.
class Topic {
public:
    Topic(const ClashReport& report, const Clash& clash, std::size_t number)
        : r_(report), c_(clash), number_(number), guid_(guid_of(clash.id)),
          viewpoint_(guid_of("viewpoint " + clash.id)),
          date_(fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time_t(report.time))))
    {
    }

    const std::string& guid() const { return guid_; }

    std::string markup(bool has_snapshot) const
    {
        std::string text(declaration);
        text += "<Markup>\n<Header>\n";
        for (const std::string& file : std::set<std::string>{part(c_.a).file, part(c_.b).file})
            text += "<File isExternal=\"true\">" + element("Filename", file) + "</File>\n";
        text += fmt::format("</Header>\n<Topic Guid=\"{}\" TopicType=\"Clash\" TopicStatus=\"{}\">\n", guid_,
                            xml_escaped(c_.status_text()));
        text += element("Title", fmt::format("{}: {} and {}", name_of(c_.kind), part(c_.a).name, part(c_.b).name));
        text += element("Index", std::to_string(number_)) + element("Labels", name_of(c_.kind));
        text += element("CreationDate", date_) + element("CreationAuthor", "oncollide");
        text += element("Description", fmt::format("{}: {}, at {} {}. Parts: {} and {}. Clash {}.", name_of(c_.kind),
                                                   measure_text(r_, c_), point_text(c_.where), r_.unit.name,
                                                   part(c_.a).path, part(c_.b).path, c_.id));
        text += "</Topic>\n";
        if (!c_.comment.empty()) {
            text += fmt::format("<Comment Guid=\"{}\">\n", guid_of("comment " + c_.id));
            text += element("Date", date_) + element("Author", "oncollide") + element("Comment", c_.comment);
            text += fmt::format("<Viewpoint Guid=\"{}\"/>\n</Comment>\n", viewpoint_);
        }
        text +=
            fmt::format("<Viewpoints Guid=\"{}\">\n<Viewpoint>viewpoint.bcfv</Viewpoint>\n{}</Viewpoints>\n</Markup>\n",
                        viewpoint_, has_snapshot ? "<Snapshot>snapshot.png</Snapshot>\n" : "");
        return text;
    }

    std::string viewpoint(const ClashView& view) const
    {
        const std::string components = component(c_.a) + component(c_.b);
        const double metres = 1e-3 * r_.unit.millimetres;
        const Eigen::Vector3d eye = metres * (view.middle + view.from * (view.radius / std::sin(0.5 * angle)));
        const Eigen::Vector3d right = (-view.from).cross(Eigen::Vector3d::UnitZ()).normalized();
        std::string text(declaration);
        text += fmt::format("<VisualizationInfo Guid=\"{}\">\n<Components>\n<Selection>\n{}</Selection>\n"
                            "<Visibility DefaultVisibility=\"true\"/>\n<Coloring>\n",
                            viewpoint_, components);
        text += fmt::format("<Color Color=\"FF3C78C8\">\n{}</Color>\n<Color Color=\"FFE1A032\">\n{}</Color>\n",
                            component(c_.a), component(c_.b));
        text += "</Coloring>\n</Components>\n<PerspectiveCamera>\n" + vector("CameraViewPoint", eye) +
                vector("CameraDirection", -view.from) + vector("CameraUpVector", right.cross(-view.from)) +
                fmt::format("<FieldOfView>{}</FieldOfView>\n</PerspectiveCamera>\n", degrees);
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
        return "<Component>\n" + element("OriginatingSystem", "oncollide") +
               element("AuthoringToolId", part(number).path) + "</Component>\n";
    }

    const ClashReport& r_;
    const Clash& c_;
    std::size_t number_;
    std::string guid_, viewpoint_, date_;
};

} // namespace

void write_bcf(OutputFile& file, const ClashReport& r, const ClashPictures& pictures)
{
    std::vector<std::pair<std::string, std::string>> files{
        {"bcf.version", std::string(declaration) +
                            "<Version VersionId=\"2.1\">\n<DetailedVersion>2.1</DetailedVersion>\n</Version>\n"}};
    std::size_t number = 0;
    for (std::size_t i = 0; i < r.found.list.size(); ++i) {
        const Clash& clash = r.found.list[i];
        if (clash.status != ClashStatus::fresh && clash.status != ClashStatus::active) continue;
        const Topic topic(r, clash, ++number);
        const std::string& image = pictures.images[i];
        files.emplace_back(topic.guid() + "/markup.bcf", topic.markup(!image.empty()));
        files.emplace_back(topic.guid() + "/viewpoint.bcfv", topic.viewpoint(pictures.views[i]));
        if (!image.empty()) files.emplace_back(topic.guid() + "/snapshot.png", image);
    }
    file.write(zip_bytes(files, r.time));
}

} // namespace oncollide::tools

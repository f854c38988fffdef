#pragma once
#include <memory>
#include <optional>
#include <string_view>

#include <oncollide/scenes/files/mesh/mesh_source.hpp>

namespace oncollide {

// XML, as Expat reads it. Private to scenes.

/// Where an element begins. Its views hold during the call alone.
struct XmlTag {
    std::string_view space, name; ///< of the namespace, and within it
    const char** attributes;      ///< name, value, name, value, ..., null
    std::size_t line;

    /// Nothing where there is no such attribute.
    /// @param key  as it is written; where a prefix stands for a namespace, "NAMESPACE\nNAME"
    std::optional<std::string_view> operator[](std::string_view key) const;
};

class XmlHandler {
public:
    virtual ~XmlHandler() = default;
    /// A prefix stands for a namespace in the element that begins next.
    virtual void name_space(std::string_view /*prefix*/, std::string_view /*name*/) {}
    virtual void begin(const XmlTag& tag) = 0;
    virtual void end() = 0;
    /// Part of what stands between tags.
    virtual void text(std::string_view) {}
};

/// Passes on what comes in pieces, strictly: an Error of the handler ends it, and so do entities that the text
/// declares, elements nested deeper than `most_levels`, and tags of more than 4 MiB.
class XmlReader {
public:
    /// @param source names the text in messages
    XmlReader(const MeshSource& source, XmlHandler& handler);
    ~XmlReader();

    void read(std::string_view piece); ///< of a megabyte or so
    void finish(); ///< throws unless the text was whole

    static constexpr int most_levels = 1000;

private:
    struct Parser;
    const std::unique_ptr<Parser> parser_;
};

/// The same for a text that is there as a whole.
void read_xml(const MeshSource& source, XmlHandler& handler);

} // namespace oncollide

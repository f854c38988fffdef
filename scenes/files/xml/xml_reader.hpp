#pragma once
#include <memory>
#include <optional>
#include <string_view>

#include <oncollide/scenes/files/mesh/mesh_source.hpp>

namespace oncollide {

// XML, parsed by Expat. Private to scenes.

/// The start tag of an element. Its views are valid during the call only.
struct XmlTag {
    std::string_view space, name; ///< namespace, and local name
    const char** attributes;      ///< name, value, name, value, ..., null
    std::size_t line;

    /// Empty if there is no such attribute.
    /// @param key  the key as written; if a prefix stands for a namespace, "NAMESPACE\nNAME"
    std::optional<std::string_view> operator[](std::string_view key) const;
};

class XmlHandler {
public:
    virtual ~XmlHandler() = default;
    /// Declares a namespace prefix for the element that begins next.
    virtual void name_space(std::string_view /*prefix*/, std::string_view /*name*/) {}
    virtual void begin(const XmlTag& tag) = 0;
    virtual void end() = 0;
    /// A piece of the text between tags.
    virtual void text(std::string_view) {}
};

/// Parses text in pieces, strictly. An Error of the handler ends the parsing; declared entities, elements nested deeper
/// than `most_levels`, and tags of more than 4 MiB are refused.
class XmlReader {
public:
    /// @param source names the text in messages
    XmlReader(const MeshSource& source, XmlHandler& handler);
    ~XmlReader();

    void read(std::string_view piece); ///< pieces of about a megabyte
    void finish();                     ///< throws unless the text was whole

    static constexpr int most_levels = 1000;

private:
    struct Parser;
    const std::unique_ptr<Parser> parser_;
};

/// The same for a complete text.
void read_xml(const MeshSource& source, XmlHandler& handler);

} // namespace oncollide

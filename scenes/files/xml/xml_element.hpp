#pragma once
#include <functional>
#include <string>
#include <vector>

#include <oncollide/scenes/files/mesh/mesh_source.hpp>

namespace oncollide {

/// An element of an XML text with its contents. Private to scenes and robots.
struct XmlElement {
    std::string name; ///< without the namespace
    std::size_t line = 0;
    std::vector<std::pair<std::string, std::string>> attributes{};
    std::string text{}; ///< all text outside its children
    std::vector<XmlElement> children{};
    std::uint32_t file = 0; ///< for readers of files that include others

    /// Empty if there is none.
    const std::string& attribute(std::string_view key) const;
    /// The first child of that name, or null.
    const XmlElement* find(std::string_view child) const;
};

/// Reads a whole text, except the elements that `keep` rejects and their contents.
/// @param keep  whether to keep an element of that name, `levels` below the root; called from the second level on
XmlElement read_xml_elements(const MeshSource& source,
                             const std::function<bool(std::string_view name, int level)>& keep);

} // namespace oncollide

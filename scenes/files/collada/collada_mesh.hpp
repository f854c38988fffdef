#pragma once
#include <map>

#include <oncollide/scenes/files/xml/xml_element.hpp>

namespace oncollide {

// Parts of a COLLADA file. Private to scenes.

/// The numbers of a list, which must be finite. Throws naming `element` and its line.
std::vector<double> collada_numbers(const MeshSource& source, const XmlElement& element);

/// Elements of one kind by their ids, for references ("#id").
class ColladaIds {
public:
    explicit ColladaIds(const MeshSource& source) : source_(source) {}
    void add(const XmlElement& element); ///< keeps a pointer to the element. Throws if the id exists
    const XmlElement* try_find(std::string_view reference) const; ///< null: no such element
    /// The element that the attribute of `from` refers to. Throws if there is none.
    const XmlElement& find(const XmlElement& from, std::string_view attribute) const;

private:
    const MeshSource& source_;
    std::map<std::string, const XmlElement*, std::less<>> elements_;
};

/// The triangles of a <geometry>, from triangles, polygons, strips and fans; lines are ignored.
RawMesh read_collada_mesh(const MeshSource& source, const XmlElement& geometry);

} // namespace oncollide

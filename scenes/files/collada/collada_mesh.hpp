#pragma once
#include <map>

#include <oncollide/scenes/files/xml/xml_element.hpp>

namespace oncollide {

// Parts of a COLLADA file. Private to scenes.

/// All numbers of a list, which must be finite. Throws naming `element` and its line.
std::vector<double> collada_numbers(const MeshSource& source, const XmlElement& element);

/// Elements of one kind by their ids, which references ("#id") name.
class ColladaIds {
public:
    explicit ColladaIds(const MeshSource& source) : source_(source) {}
    void add(const XmlElement& element); ///< which stays where it is. Throws where its id is taken
    const XmlElement* try_find(std::string_view reference) const; ///< null: it is none of them
    /// What the attribute of `from` refers to. Throws where that is none of them.
    const XmlElement& find(const XmlElement& from, std::string_view attribute) const;

private:
    const MeshSource& source_;
    std::map<std::string, const XmlElement*, std::less<>> elements_;
};

/// The triangles of a <geometry>: of triangles, polygons, strips and fans; lines are left out.
RawMesh read_collada_mesh(const MeshSource& source, const XmlElement& geometry);

} // namespace oncollide

#pragma once
#include <cstddef>
#include <iterator>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include <oncollide/base/aabb.hpp>
#include <oncollide/scenes/model/mesh.hpp>
#include <oncollide/scenes/model/occupancy_map.hpp>
#include <oncollide/scenes/model/shape.hpp>
#include <oncollide/scenes/model/terrain.hpp>

namespace oncollide {

class CookedMesh;

/// The last one is a mesh in a cooked file, of which is read what a test needs (scenes/cooked/cooked_mesh.hpp).
using GeometryData = std::variant<Mesh, Shape, OccupancyMap, Terrain, std::shared_ptr<const CookedMesh>>;

/// What a body is made of, in its own frame. Shared by its instances.
struct Geometry {
    std::string name;
    GeometryData data;
    /// The entry of a scene file that makes this geometry again (JSON text: file or generator; paths absolute or
    /// relative to the current folder). Empty when made in code, and for shapes: their data says it all.
    std::string recipe;
};

/// The exact box of a geometry in its own frame.
Aabb bounds_of(const GeometryData& geometry);
Aabb bounds_of(const Geometry& geometry);

/// The geometries of a scene. None changes once it is there, and none moves: a reference stays good while the list or
/// anyone whom it was shared with lives. Copies of the list share the geometries.
class GeometryList {
public:
    class Iterator {
    public:
        using iterator_category = std::forward_iterator_tag;
        using value_type = Geometry;
        using difference_type = std::ptrdiff_t;
        using pointer = const Geometry*;
        using reference = const Geometry&;

        Iterator() = default;
        explicit Iterator(const std::shared_ptr<const Geometry>* at) : at_(at) {}
        reference operator*() const { return **at_; }
        pointer operator->() const { return at_->get(); }
        Iterator& operator++() { return ++at_, *this; }
        Iterator operator++(int) { return Iterator(at_++); }
        friend bool operator==(const Iterator&, const Iterator&) = default;

    private:
        const std::shared_ptr<const Geometry>* at_ = nullptr;
    };

    std::size_t size() const { return items_.size(); }
    bool empty() const { return items_.empty(); }
    const Geometry& operator[](std::size_t i) const { return *items_[i]; }
    const Geometry& back() const { return *items_.back(); }
    Iterator begin() const { return Iterator(items_.data()); }
    Iterator end() const { return Iterator(items_.data() + items_.size()); }
    /// The geometry, for one who may outlive the scene. Copies nothing.
    const std::shared_ptr<const Geometry>& share(std::size_t i) const { return items_[i]; }

private:
    friend struct Scene; // the only one who adds: it checks names and shapes
    std::vector<std::shared_ptr<const Geometry>> items_;
};

} // namespace oncollide

#pragma once
#include <cstddef>
#include <iterator>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include <oncollide/base/aabb.hpp>
#include <oncollide/base/error.hpp>
#include <oncollide/scenes/model/mesh.hpp>
#include <oncollide/scenes/model/occupancy_map.hpp>
#include <oncollide/scenes/model/shape.hpp>
#include <oncollide/scenes/model/terrain.hpp>

namespace oncollide {

class CookedMesh;

/// The size of a cooked file.
struct CookedSize {
    std::uint64_t bytes = 0;
    std::uint32_t chunks = 0;
};

/// The last alternative is a mesh in a cooked file, which is read in parts as tests need them
/// (scenes/cooked/cooked_mesh.hpp).
using GeometryData = std::variant<Mesh, Shape, OccupancyMap, Terrain, std::shared_ptr<const CookedMesh>>;

/// A geometry in its own frame. Several bodies may share it.
struct Geometry {
    std::string name;
    GeometryData data;
    /// The entry of a scene file that makes this geometry again (JSON text: file or generator; paths absolute or
    /// relative to the current folder). Empty for geometries made in code, and for shapes, whose data is a complete
    /// description.
    std::string recipe;
};

/// The exact AABB of a geometry in its own frame.
ONCOLLIDE_API Aabb bounds_of(const GeometryData& geometry);
ONCOLLIDE_API Aabb bounds_of(const Geometry& geometry);

/// Throws Error{bad_data} naming `name` for a geometry made in code that check_mesh or check_shape refuses, and for a
/// null cooked mesh. Cost: as theirs.
ONCOLLIDE_API void check_geometry(const std::string& name, const GeometryData& geometry);

/// The geometries of a scene. A geometry never changes or moves in memory: a reference stays valid while the list or
/// any holder of share() lives. Copies of the list share the geometries.
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
    /// The geometry, for holders that may outlive the scene. Copies no data.
    const std::shared_ptr<const Geometry>& share(std::size_t i) const { return items_[i]; }

private:
    friend struct SceneInfo; // which checks names and shapes of the geometries that it adds
    std::vector<std::shared_ptr<const Geometry>> items_;
};

} // namespace oncollide

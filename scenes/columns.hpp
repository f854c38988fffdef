#pragma once
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/geometry.hpp>
#include <oncollide/scenes/motion.hpp>

namespace oncollide {

class Deformation;
template <class Signature>
class FunctionRef;

// The columns of a Scene, one row per body. Readers use them like arrays; only the scene changes them. Values that
// bodies have in common are stored once or not at all, to save memory in scenes of ten million bodies.

/// One value per body.
template <class T>
class BodyColumn {
public:
    std::size_t size() const { return values_.size(); }
    const T& operator[](std::size_t body) const { return values_[body]; }
    const T* data() const { return values_.data(); }
    const T* begin() const { return values_.data(); }
    const T* end() const { return values_.data() + values_.size(); }
    friend bool operator==(const BodyColumn&, const BodyColumn&) = default;

private:
    friend struct Scene;
    std::vector<T> values_;
};

/// Names: their letters, and 8 bytes for each body up to the last named body.
class NameColumn {
public:
    std::size_t size() const { return size_; }
    /// Empty for a body without a name. Valid until a body is added.
    std::string_view operator[](std::size_t body) const
    {
        if (body >= ends_.size()) return {};
        const std::size_t begin = body ? ends_[body - 1] : 0;
        return std::string_view(letters_).substr(begin, ends_[body] - begin);
    }
    friend bool operator==(const NameColumn&, const NameColumn&) = default;

private:
    friend struct Scene;
    void push_back(std::string_view name);

    std::string letters_;
    std::vector<std::size_t> ends_; ///< end of each body's name in letters_; no entries after the last named body
    std::size_t size_ = 0;
};

/// Poses, exactly as given: 28 bytes each, and 72 more for a body that ever had a rotation.
class PoseColumn {
public:
    /// Iterates over poses by value.
    class Iterator {
    public:
        using iterator_category = std::input_iterator_tag;
        using value_type = Eigen::Isometry3d;
        using difference_type = std::ptrdiff_t;
        Iterator() = default;
        Iterator(const PoseColumn& column, std::size_t body) : column_(&column), body_(body) {}
        Eigen::Isometry3d operator*() const { return (*column_)[body_]; }
        Iterator& operator++() { return ++body_, *this; }
        Iterator operator++(int) { return {*column_, body_++}; }
        friend bool operator==(const Iterator&, const Iterator&) = default;

    private:
        const PoseColumn* column_ = nullptr;
        std::size_t body_ = 0;
    };

    std::size_t size() const { return positions_.size(); }
    /// Returns a copy; const, so that code that writes to the copy, to move the body, does not compile.
    const Eigen::Isometry3d operator[](std::size_t body) const // NOLINT: const as said
    {
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.translation() = positions_[body];
        if (const std::uint32_t rotated = rotated_[body]) pose.linear() = rotations_[rotated - 1];
        return pose;
    }
    const Eigen::Vector3d& position(std::size_t body) const { return positions_[body]; }
    Eigen::Isometry3d back() const { return (*this)[size() - 1]; }
    Iterator begin() const { return {*this, 0}; }
    Iterator end() const { return {*this, size()}; }

private:
    friend struct Scene;
    void reserve(std::size_t bodies);
    void push_back(const Eigen::Isometry3d& pose);
    void set(std::size_t body, const Eigen::Isometry3d& pose);

    std::vector<Eigen::Vector3d> positions_;
    std::vector<std::uint32_t> rotated_; ///< 0: the identity, else one more than the index of its rotation
    std::vector<Eigen::Matrix3d> rotations_;
};

/// Motions; bodies without a motion take no memory.
class ONCOLLIDE_API MotionColumn {
public:
    const Motion& operator[](std::size_t body) const;
    /// The bodies that have a motion, ascending, and their motions.
    std::span<const std::uint32_t> bodies() const { return bodies_; }
    std::span<const Motion> of_bodies() const { return motions_; }

private:
    friend struct Scene;
    std::vector<std::uint32_t> bodies_;
    std::vector<Motion> motions_;
};

/// The bodies that were changed, so that a reader can follow a scene without comparing all bodies.
class ONCOLLIDE_API ChangeLog {
public:
    struct Change {
        std::uint32_t body : 31, only_pose : 1; ///< only_pose: no other column changed
    };
    /// A reader's position in a log.
    struct Mark {
        std::uint64_t log = 0, changes = 0;
    };

    ChangeLog() : log_(new_number()) {}
    ChangeLog(const ChangeLog&) : ChangeLog() {} // a reader of one copy has not seen the changes of the other
    ChangeLog(ChangeLog&& other) noexcept;
    ChangeLog& operator=(ChangeLog other) noexcept;

    Mark now() const { return {log_, forgotten_ + changes_.size()}; }
    /// True if the log is the same and still holds all changes since the mark.
    bool reaches(Mark mark) const { return mark.log == log_ && mark.changes >= forgotten_; }
    /// Bodies changed since the mark; a body may appear several times. Requires reaches(mark).
    std::span<const Change> since(Mark mark) const
    {
        return std::span(changes_).subspan(static_cast<std::size_t>(mark.changes - forgotten_));
    }

private:
    friend struct Scene;
    static std::uint64_t new_number();
    /// @param most  changes to keep
    void note(Change change, std::size_t most);
    void reserve(std::size_t most) { changes_.reserve(most); }

    std::uint64_t log_, forgotten_ = 0;
    std::vector<Change> changes_;
};

/// Finds an index by name in constant time. The owner stores the names; name_of(index) returns them.
class NameIndex {
public:
    using NameOf = FunctionRef<std::string_view(std::uint32_t)>;
    /// Adds `name` for `index`; returns false and changes nothing if the name exists.
    bool add(std::string_view name, std::uint32_t index, const NameOf& name_of);
    std::optional<std::uint32_t> find(std::string_view name, const NameOf& name_of) const;

private:
    struct Slot {
        std::uint32_t hash, index;
    };
    void grow();

    std::vector<Slot> slots_; ///< the count is a power of two; at most half of the slots are in use
    std::size_t used_ = 0;
};

/// The geometries of a scene. A geometry never changes or moves in memory: a reference stays valid while the list or
/// any holder of share() lives. Only a mesh that deforms is replaced by another geometry, with its vertices of the
/// frame; a reference to it ends with deform(). Copies of the list share geometries and deformations.
class ONCOLLIDE_API GeometryList {
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

    /// The numbers of the meshes that deform, ascending.
    std::span<const std::uint32_t> deforming() const { return deforming_; }
    bool deforms(std::size_t i) const { return deformation(i) != nullptr; }
    /// Null: the geometry is rigid.
    const Deformation* deformation(std::size_t i) const;
    /// The geometry as it was added.
    const Geometry& at_rest(std::size_t i) const;
    /// Gives the meshes that deform their vertices at `time` (frames). A mesh whose vertices stay the same stays.
    /// Throws as Deformation::move(), and nothing has changed. Cost: a copy of each mesh. Mover calls it.
    void deform(double time);

private:
    friend struct SceneInfo; // which checks names, shapes and deformations of the geometries that it adds
    struct Rest {
        std::shared_ptr<const Geometry> geometry;
        std::shared_ptr<Deformation> deformation;
    };
    const Rest* rest_of(std::size_t i) const;
    /// The geometry at `time`: `before` if its vertices are the same.
    static std::shared_ptr<const Geometry> at_time(const Rest& rest, const std::shared_ptr<const Geometry>& before,
                                                   double time);

    std::vector<std::shared_ptr<const Geometry>> items_; ///< as they are now
    std::vector<std::uint32_t> deforming_;
    std::vector<Rest> rest_; ///< of the meshes that deform
};

} // namespace oncollide

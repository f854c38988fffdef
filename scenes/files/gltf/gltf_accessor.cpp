#include <oncollide/scenes/files/gltf/gltf_accessor.hpp>

#include <algorithm>
#include <cstring>
#include <limits>

#include <fmt/format.h>

namespace oncollide {

namespace {

enum ComponentType { int8 = 5120, uint8 = 5121, int16 = 5122, uint16 = 5123, uint32 = 5125, float32 = 5126 };

std::size_t bytes_of(int type)
{
    return type == int8 || type == uint8 ? 1 : type == int16 || type == uint16 ? 2 : 4;
}

bool counts(int type)
{
    return type == uint8 || type == uint16 || type == uint32;
}

template <class Number>
Number load(const char* at)
{
    Number number;
    std::memcpy(&number, at, sizeof number);
    return number;
}

std::uint32_t whole_number(const GltfColumn& column, std::size_t i)
{
    const char* const at = column.at(i);
    return column.type == uint8    ? load<std::uint8_t>(at)
           : column.type == uint16 ? load<std::uint16_t>(at)
                                   : load<std::uint32_t>(at);
}

/// A signed type has one more value below zero than above: the lowest is also -1.
template <class Whole>
double scaled(const char* at, bool normalized)
{
    const double number = load<Whole>(at);
    return normalized ? std::max(number / std::numeric_limits<Whole>::max(), -1.0) : number;
}

double coordinate(const char* at, int type, bool normalized)
{
    switch (type) {
    case int8:
        return scaled<std::int8_t>(at, normalized);
    case uint8:
        return scaled<std::uint8_t>(at, normalized);
    case int16:
        return scaled<std::int16_t>(at, normalized);
    case uint16:
        return scaled<std::uint16_t>(at, normalized);
    default:
        return load<float>(at);
    }
}

/// `count` elements of `bytes` each in the view that `node` names. Step 0: contiguous.
GltfColumn column_in(GltfBuffers& buffers, const Node& node, int type, std::size_t count, std::size_t bytes,
                     std::uint64_t step)
{
    const std::string_view view = buffers.view(node["bufferView"]);
    const std::uint64_t offset = node.has("byteOffset") ? node["byteOffset"].natural() : 0;
    if (step == 0) step = bytes;
    if (step < bytes) node.fail(fmt::format("its elements lie {} bytes apart, but take {}", step, bytes));
    // offset + (count - 1) * step + bytes <= view.size(), without overflow
    if (count > 0 &&
        (offset > view.size() || bytes > view.size() - offset || count - 1 > (view.size() - offset - bytes) / step))
        node.fail(fmt::format("takes {} elements of {} bytes from byte {} on, but the view has {} bytes", count, bytes,
                              offset, view.size()));
    return {view.data() + (count > 0 ? offset : 0), static_cast<std::size_t>(step), type};
}

int type_of(const Node& node)
{
    return static_cast<int>(node["componentType"].integer(int8, float32));
}

} // namespace

GltfAccessor GltfAccessor::of_corners(const GltfDocument& document, GltfBuffers& buffers, const Node& number)
{
    const Node& node = document.at(GltfDocument::accessors, number);
    if (node["type"].text() != "SCALAR" || !counts(type_of(node)))
        node.fail("an accessor of indices is not made of whole numbers (SCALAR, 5121, 5123 or 5125)");
    GltfAccessor accessor;
    accessor.read(document, buffers, node, 1);
    return accessor;
}

GltfAccessor GltfAccessor::of_positions(const GltfDocument& document, GltfBuffers& buffers, const Node& number)
{
    const Node& node = document.at(GltfDocument::accessors, number);
    const int type = type_of(node);
    const bool quantized = document.is_quantized() && type <= uint16;
    if (node["type"].text() != "VEC3" || (type != float32 && !quantized))
        node.fail("an accessor of positions is not made of three floats (VEC3, 5126; or whole numbers of 8 or 16 bits "
                  "where the file uses KHR_mesh_quantization)");
    GltfAccessor accessor;
    accessor.read(document, buffers, node, 3);
    return accessor;
}

GltfAccessor GltfAccessor::of_vectors(const GltfDocument& document, GltfBuffers& buffers, const Node& number,
                                      Vectors kind)
{
    const Node& node = document.at(GltfDocument::accessors, number);
    const int type = type_of(node);
    const bool turns = kind == Vectors::quaternions;
    GltfAccessor accessor;
    if (node["type"].text() != (turns ? "VEC4" : "VEC3") ||
        (type != float32 && !(turns && (type == int8 || type == int16))))
        node.fail(turns ? "an accessor of rotations is not made of four floats (VEC4, 5126; or normalized 5120 or 5122)"
                        : "an accessor of instances is not made of three floats (VEC3, 5126)");
    accessor.read(document, buffers, node, turns ? 4 : 3);
    if (type != float32 && !accessor.normalized_) node.fail("whole numbers must be normalized");
    return accessor;
}

void GltfAccessor::read(const GltfDocument& document, GltfBuffers& buffers, const Node& accessor, std::size_t numbers)
{
    constexpr std::int64_t most = std::numeric_limits<std::uint32_t>::max();
    node_ = accessor;
    elements_.type = type_of(accessor);
    size_ = static_cast<std::size_t>(accessor["count"].integer(0, most));
    normalized_ = accessor.has("normalized") && accessor["normalized"].boolean();
    const bool has_view = accessor.has("bufferView"), is_sparse = accessor.has("sparse");
    if (has_view) {
        const Node& view = document.at(GltfDocument::buffer_views, accessor["bufferView"]);
        const std::uint64_t step = view.has("byteStride") ? view["byteStride"].natural() : 0;
        elements_ = column_in(buffers, accessor, elements_.type, size_, numbers * bytes_of(elements_.type), step);
    }
    if (is_sparse) read_sparse(buffers, accessor["sparse"], numbers);
    if (!has_view && !is_sparse) accessor.fail("has neither 'bufferView' nor 'sparse', so it has no data");
}

void GltfAccessor::read_sparse(GltfBuffers& buffers, const Node& sparse, std::size_t numbers)
{
    replaced_ = static_cast<std::size_t>(sparse["count"].integer(0, static_cast<std::int64_t>(size_)));
    const Node places = sparse["indices"];
    const int type = type_of(places);
    if (!counts(type)) places.fail("the places of a sparse accessor must be of type 5121, 5123 or 5125");
    places_ = column_in(buffers, places, type, replaced_, bytes_of(type), 0);
    values_ = column_in(buffers, sparse["values"], elements_.type, replaced_, numbers * bytes_of(elements_.type), 0);
    for (std::size_t k = 0; k < replaced_; ++k)
        if (const std::uint32_t place = whole_number(places_, k);
            place >= size_ || (k > 0 && place <= whole_number(places_, k - 1)))
            places.fail(fmt::format("number {} is {}; the places of {} elements must ascend", k, place, size_));
}

const char* GltfAccessor::element(std::size_t i) const
{
    std::size_t low = 0, high = replaced_;
    while (low < high)
        if (const std::size_t middle = (low + high) / 2; whole_number(places_, middle) < i)
            low = middle + 1;
        else
            high = middle;
    if (low < replaced_ && whole_number(places_, low) == i) return values_.at(low);
    return elements_.data ? elements_.at(i) : nullptr;
}

std::uint32_t GltfAccessor::corner(std::size_t i) const
{
    const char* const at = element(i);
    return at ? whole_number({at, 0, elements_.type}, 0) : 0;
}

Eigen::Vector3d GltfAccessor::position(std::size_t i) const
{
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    numbers(i, 3, point.data());
    return point;
}

Eigen::Quaterniond GltfAccessor::quaternion(std::size_t i) const
{
    Eigen::Quaterniond rotation(0, 0, 0, 0);
    numbers(i, 4, rotation.coeffs().data()); // x, y, z, w, as in Eigen
    if (!(rotation.norm() > 1e-6)) node_->fail(fmt::format("quaternion {} has no direction", i));
    return rotation.normalized();
}

void GltfAccessor::numbers(std::size_t i, std::size_t count, double* out) const
{
    if (const char* const at = element(i))
        for (std::size_t k = 0; k < count; ++k)
            out[k] = coordinate(at + k * bytes_of(elements_.type), elements_.type, normalized_);
}

} // namespace oncollide

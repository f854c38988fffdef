#include <oncollide/broadphase/bounds/cooked_support.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include <oncollide/base/error.hpp>
#include <oncollide/broadphase/aabb_kernel.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3f;

/// The axes of box k, as the traversal of cooked meshes decodes them.
Eigen::Matrix3f axes_of(const CookedNode& node, unsigned k)
{
    Eigen::Quaternionf q(node.qw[k], node.qx[k], node.qy[k], node.qz[k]);
    q.coeffs() *= 1.0f / 32767;
    q.coeffs() *= 1.5f - 0.5f * q.squaredNorm();
    return q.toRotationMatrix();
}

} // namespace

CookedSupport::CookedSupport(std::shared_ptr<const CookedMesh> mesh, const Eigen::Vector3d& centre)
    : mesh_(std::move(mesh)), centre_(centre), rounding_(std::ldexp(static_cast<float>(mesh_->radius()), -18))
{
    const auto top = mesh_->open();
    add_boxes(*top);
    if (boxes_.size() != top->tree_chunks)
        throw ChunkFault(ErrorKind::bad_data, mesh_->name() + ": has upper levels that are no tree over its chunks");
    points_.resize(boxes_.size());
}

/// In depth-first order, the boxes without a child node enclose the chunks, in chunk order.
void CookedSupport::add_boxes(const CookedMesh::Top& top)
{
    const std::size_t nodes = top.nodes.size() / sizeof(CookedNode);
    const Vector3f all = mesh_->bounds().half_extent().cast<float>();
    if (nodes == 0) return boxes_.push_back({Vector3f::Zero(), all});
    std::vector<std::uint32_t> waiting{1}; // the number of a node; 0 for a chunk, whose box is beside it
    std::vector<Box> of_waiting{{}};
    std::size_t seen = 0;
    while (!waiting.empty() && boxes_.size() <= top.tree_chunks) {
        const std::uint32_t number = waiting.back();
        const Box box = of_waiting.back();
        waiting.pop_back(), of_waiting.pop_back();
        if (number == 0) {
            boxes_.push_back(box);
            continue;
        }
        if (number > nodes || ++seen > nodes) return; // not a tree
        CookedNode node;
        std::memcpy(&node, &top.nodes[(number - 1) * sizeof node], sizeof node);
        for (unsigned k = std::min(node.lanes, 8u); k-- > 0;) {
            const Eigen::Matrix3f axes = axes_of(node, k);
            const Vector3f half = node.unit * Vector3f(node.hx[k], node.hy[k], node.hz[k]),
                           centre = Vector3f(node.origin[0], node.origin[1], node.origin[2]) +
                                    node.unit * Vector3f(node.x[k], node.y[k], node.z[k]);
            // Axes that are not a rotation are rejected only when the chunk is read; until then, the chunk may be
            // anywhere.
            const bool rotated = (axes.transpose() * axes - Eigen::Matrix3f::Identity()).norm() < 2e-5f;
            const Vector3f around =
                rotated ? Vector3f((axes.cwiseAbs() * half).array() + 1e-4f * half.norm()) : Vector3f(2 * all);
            waiting.push_back(node.child[k]), of_waiting.push_back({rotated ? centre : Vector3f::Zero(), around});
        }
    }
}

float CookedSupport::bound(std::size_t chunk, const Vector3f& d) const
{
    ONCOLLIDE_ASSERT(chunk < boxes_.size());
    const Box& box = boxes_[chunk];
    const float most = d.dot(box.centre) + d.cwiseAbs().dot(box.half);
    // A box of the file may be wrong until its chunk is read, but the mesh's bounds hold for every chunk.
    const float all = d.cwiseAbs().dot(mesh_->bounds().half_extent().cast<float>());
    return (most < all ? most : all) + rounding_;
}

float CookedSupport::most_of(std::size_t chunk, const Vector3f& d) const
{
    ONCOLLIDE_ASSERT(chunk < points_.size() && points_[chunk].size() > 0);
    const auto& [x, y, z] = points_[chunk].xyz;
    return aabb_kernel().most_along(x.data(), y.data(), z.data(), static_cast<std::uint32_t>(x.size()), d.data());
}

/// False if the chunk cannot be read: CookedMesh records the fault, and the box stays in use as an upper bound.
bool CookedSupport::read(std::size_t chunk)
{
    try {
        mesh_->read(chunk, read_);
    } catch (const ChunkFault&) {
        return false;
    }
    points_[chunk] = point_columns(read_.vertices, centre_);
    return true;
}

void CookedSupport::prepare(const Vector3f& d)
{
    ONCOLLIDE_ASSERT(std::abs(d.norm() - 1) < 1e-3f);
    ONCOLLIDE_ASSERT(points_.size() == boxes_.size());
    std::size_t first = 0;
    for (std::size_t c = 1; c < boxes_.size(); ++c)
        if (bound(c, d) > bound(first, d)) first = c;
    float best = -std::numeric_limits<float>::infinity();
    const auto look_at = [&](std::size_t chunk) {
        if (bound(chunk, d) < best) return;
        if (points_[chunk].size() == 0 && !read(chunk)) return;
        best = std::max(best, most_of(chunk, d));
    };
    look_at(first);
    for (std::size_t c = 0; c < boxes_.size(); ++c) look_at(c);
}

float CookedSupport::most(const Vector3f& d) const
{
    float best = -std::numeric_limits<float>::infinity();
    // Tries the chunks already read first, because they were read for similar directions.
    for (std::size_t c = 0; c < boxes_.size(); ++c)
        if (points_[c].size() > 0 && bound(c, d) > best) best = std::max(best, most_of(c, d));
    for (std::size_t c = 0; c < boxes_.size(); ++c)
        if (points_[c].size() == 0) best = std::max(best, bound(c, d));
    return best;
}

std::size_t CookedSupport::bytes() const
{
    std::size_t sum = boxes_.capacity() * sizeof(Box);
    for (const PointColumns& points : points_) sum += points.bytes();
    return sum;
}

} // namespace oncollide

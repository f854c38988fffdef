#include "clash/parts/part_ids.hpp"

#include <algorithm>
#include <map>
#include <variant>
#include <vector>

#include <fmt/format.h>

namespace oncollide::tools {
namespace {

/// FNV-1a, by Fowler, Noll and Vo, with a final mix of all bits.
class Hash {
public:
    void add(const void* data, std::size_t bytes)
    {
        const auto* byte = static_cast<const unsigned char*>(data);
        for (std::size_t i = 0; i < bytes; ++i) value_ = (value_ ^ byte[i]) * 0x100000001b3;
    }
    std::uint64_t value() const
    {
        std::uint64_t x = value_;
        x = (x ^ x >> 33) * 0xff51afd7ed558ccd;
        x = (x ^ x >> 33) * 0xc4ceb9fe1a85ec53;
        return x ^ x >> 33;
    }

private:
    std::uint64_t value_ = 0xcbf29ce484222325;
};

std::uint64_t geometry_hash(const Mesh& mesh, const Eigen::Isometry3d& pose)
{
    Hash hash;
    for (const Eigen::Vector3d& v : mesh.vertices) hash.add(v.data(), sizeof(double) * 3);
    hash.add(mesh.triangles.data(), mesh.triangles.size() * sizeof(Triangle));
    hash.add(pose.matrix().data(), sizeof(double) * 16);
    return hash.value();
}

} // namespace

std::uint64_t hash_of(std::string_view text)
{
    Hash hash;
    hash.add(text.data(), text.size());
    return hash.value();
}

void make_ids_unique(PartList& list)
{
    std::map<std::string, std::vector<Part*>> by_id;
    for (Part& part : list.parts) by_id[part.id].push_back(&part);
    std::map<std::string, int> count;
    for (const auto& [id, parts] : by_id) {
        if (parts.size() == 1) continue;
        for (Part* part : parts) {
            const auto& mesh = std::get<Mesh>(list.meshes[part->mesh]->data);
            part->id = fmt::format("{}\n{:016x}", id, geometry_hash(mesh, part->pose));
            if (const int earlier = count[part->id]++) part->id += fmt::format("\n{}", earlier);
        }
    }
}

std::string clash_id(const Part& a, const Part& b)
{
    const auto& [first, second] = std::minmax(a.id, b.id);
    return fmt::format("c{:016x}", hash_of(first + '\0' + second));
}

} // namespace oncollide::tools

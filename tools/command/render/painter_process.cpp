#include "render/painter_process.hpp"

#include <array>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <string_view>

namespace oncollide::tools {
namespace {

/// All of a picture apart from its columns.
struct Head {
    std::array<double, 3> eye, look_at;
    double view_angle;
    std::int32_t width, height;
    Colour background;
    std::uint32_t meshes, bodies, balls, lines;
};
struct MeshRow {
    std::uint64_t vertices, triangles;
    std::array<double, 3> low, high;
};
struct BodyRow {
    double pose[16];
    std::uint32_t mesh;
    Colour colour;
};

std::array<double, 3> numbers_of(const Eigen::Vector3d& v)
{
    return {v.x(), v.y(), v.z()};
}
Eigen::Vector3d vector_of(const std::array<double, 3>& v)
{
    return {v[0], v[1], v[2]};
}

template <class Row>
std::string_view bytes_of(const std::vector<Row>& rows)
{
    return {reinterpret_cast<const char*>(rows.data()), sizeof(Row) * rows.size()};
}

/// The parts of a request. Vertices and triangles are not copied.
struct Packed {
    Head head{};
    std::vector<MeshRow> meshes;
    std::vector<BodyRow> bodies;
    std::vector<std::string_view> parts;
};

void pack(const Picture& picture, Packed& to)
{
    std::map<const Mesh*, std::uint32_t> number;
    std::vector<const Mesh*> meshes;
    for (const Picture::Body& body : picture.bodies) {
        const auto [at, fresh] = number.emplace(body.mesh, std::uint32_t(meshes.size()));
        if (fresh) meshes.push_back(body.mesh);
        BodyRow& row = to.bodies.emplace_back();
        Eigen::Map<Eigen::Matrix4d>(row.pose) = body.pose.matrix();
        row.mesh = at->second, row.colour = body.colour;
    }
    for (const Mesh* const mesh : meshes) {
        to.meshes.push_back({mesh->vertices.size(), mesh->triangles.size(), numbers_of(mesh->bounds.min),
                             numbers_of(mesh->bounds.max)});
    }
    to.head = {.eye = numbers_of(picture.camera.eye),
               .look_at = numbers_of(picture.camera.look_at),
               .view_angle = picture.camera.view_angle,
               .width = picture.width,
               .height = picture.height,
               .background = picture.background,
               .meshes = std::uint32_t(meshes.size()),
               .bodies = std::uint32_t(picture.bodies.size()),
               .balls = std::uint32_t(picture.balls.size()),
               .lines = std::uint32_t(picture.lines.size())};
    to.parts = {{reinterpret_cast<const char*>(&to.head), sizeof to.head},
                bytes_of(to.meshes),
                bytes_of(to.bodies),
                bytes_of(picture.balls),
                bytes_of(picture.lines)};
    for (const Mesh* const mesh : meshes)
        to.parts.push_back(bytes_of(mesh->vertices)), to.parts.push_back(bytes_of(mesh->triangles));
}

/// Takes a request apart.
class Unpacker {
public:
    explicit Unpacker(std::string_view bytes) : rest_(bytes) {}
    template <class Row>
    std::vector<Row> take(std::size_t count)
    {
        std::vector<Row> rows(count);
        if (count) std::memcpy(static_cast<void*>(rows.data()), rest_.data(), sizeof(Row) * count);
        rest_.remove_prefix(sizeof(Row) * count);
        return rows;
    }

private:
    std::string_view rest_;
};

/// A picture with its own meshes.
struct Unpacked : Picture {
    std::vector<std::unique_ptr<Mesh>> meshes;
};

Unpacked unpack(std::string_view request)
{
    Unpacker from(request);
    Unpacked picture;
    const Head head = from.take<Head>(1)[0];
    const auto meshes = from.take<MeshRow>(head.meshes);
    const auto bodies = from.take<BodyRow>(head.bodies);
    picture.balls = from.take<Picture::Ball>(head.balls);
    picture.lines = from.take<Picture::Line>(head.lines);
    for (const MeshRow& row : meshes) {
        Mesh& mesh = *picture.meshes.emplace_back(std::make_unique<Mesh>());
        mesh.vertices = from.take<Eigen::Vector3d>(row.vertices);
        mesh.triangles = from.take<Triangle>(row.triangles);
        mesh.bounds = {vector_of(row.low), vector_of(row.high)};
    }
    for (const BodyRow& row : bodies)
        picture.bodies.push_back({picture.meshes[row.mesh].get(),
                                  Eigen::Isometry3d(Eigen::Map<const Eigen::Matrix4d>(row.pose)), row.colour});
    picture.camera = {vector_of(head.eye), vector_of(head.look_at), head.view_angle};
    picture.width = head.width, picture.height = head.height, picture.background = head.background;
    return picture;
}

/// An empty request opens the driver; any other request draws.
GraphicsProcess::Serve painter(int gpu)
{
    return [gpu, painter = std::shared_ptr<Painter>()](std::string_view request) mutable {
        if (!painter) painter = std::make_shared<Painter>(gpu);
        if (request.empty()) return std::string();
        const std::vector<std::uint8_t> pixels = painter->draw(unpack(request));
        return std::string(pixels.begin(), pixels.end());
    };
}

} // namespace

PainterProcess::PainterProcess(int gpu) : process_(painter(gpu)) {}

void PainterProcess::open()
{
    process_.request({});
}

std::vector<std::uint8_t> PainterProcess::draw(const Picture& picture)
{
    Packed packed;
    pack(picture, packed);
    const std::string pixels = process_.request(packed.parts);
    return {pixels.begin(), pixels.end()};
}

} // namespace oncollide::tools

#include "bench/mesh_files.hpp"

#include <bit>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/numbers/random.hpp>

namespace oncollide::tools {
namespace {

static_assert(std::endian::native == std::endian::little, "binary files are written in memory order");

template <class T>
void put(OutputFile& file, const T& value)
{
    file.write({reinterpret_cast<const char*>(&value), sizeof value});
}

/// The surface; vertex (column, row) is number row * (cells + 1) + column.
class HeightField {
public:
    HeightField(std::uint32_t cells, std::uint64_t seed) : cells_(cells), seed_(seed) {}

    std::uint32_t side() const { return cells_ + 1; }
    std::uint32_t vertices() const { return side() * side(); }
    std::uint32_t triangles() const { return 2 * cells_ * cells_; }
    std::array<double, 3> vertex(std::uint32_t number) const
    {
        const std::uint32_t column = number % side(), row = number / side();
        return {column * 0.5 + u01(seed_, number, 0) * 0.1, row * 0.5 + u01(seed_, number, 1) * 0.1,
                u01(seed_, number, 2)};
    }
    /// Calls visit(x, y, z) for each vertex.
    template <class Visit>
    void each_vertex(Visit visit) const
    {
        for (std::uint32_t i = 0; i < vertices(); ++i) std::apply(visit, vertex(i));
    }
    /// Calls visit(a, b, c) for each triangle of the cells between two rows of vertices.
    template <class Visit>
    void each_triangle(std::uint32_t row, Visit visit) const
    {
        for (std::uint32_t column = 0; column < cells_; ++column) {
            const std::uint32_t a = row * side() + column, b = a + 1, c = a + side(), d = c + 1;
            visit(a, b, d), visit(a, d, c);
        }
    }
    template <class Visit>
    void each_triangle(Visit visit) const
    {
        for (std::uint32_t row = 0; row < cells_; ++row) each_triangle(row, visit);
    }

private:
    std::uint32_t cells_;
    std::uint64_t seed_;
};

void write_plain_obj(const HeightField& field, OutputFile& file, bool exact)
{
    field.each_vertex([&](double x, double y, double z) {
        exact ? file.print("v {} {} {}\n", x, y, z) : file.print("v {:.6f} {:.6f} {:.6f}\n", x, y, z);
    });
    field.each_triangle([&](auto a, auto b, auto c) { file.print("f {} {} {}\n", a + 1, b + 1, c + 1); });
}

void write_full_obj(const HeightField& field, OutputFile& file)
{
    file.print("# a scene as an exporter writes it\r\n\r\nmtllib scene.mtl\r\no land\r\n");
    field.each_vertex([&](double x, double y, double z) { file.print("v {:.6f} {:.6f} {:.6f}\r\n", x, y, z); });
    file.print("# {} vertices\r\n", field.vertices());
    for (std::uint32_t i = 0; i < field.vertices(); ++i) file.print("vt {:.4f} {:.4f}\r\n", u01(0, i, 0), u01(0, i, 1));
    for (std::uint32_t i = 0; i < field.vertices(); ++i)
        file.print("vn {:.4f} {:.4f} {:.4f}\r\n", 0.1 * u01(0, i, 2), 0.1 * u01(0, i, 3), 1.0);
    for (std::uint32_t row = 0; row + 1 < field.side(); ++row) {
        if (row % 64 == 0) file.print("g rows_{}\r\nusemtl grass\r\ns 1\r\n# rows from {} on\r\n", row, row);
        field.each_triangle(row, [&](auto a, auto b, auto c) {
            file.print("f {0}/{0}/{0} {1}/{1}/{1} {2}/{2}/{2}\r\n", a + 1, b + 1, c + 1);
        });
    }
}

void write_backward_obj(const HeightField& field, OutputFile& file)
{
    for (std::uint32_t row = 0, vertex = 0; row < field.side(); ++row) {
        for (std::uint32_t column = 0; column < field.side(); ++column) {
            const auto [x, y, z] = field.vertex(vertex++);
            file.print("v {:.6f} {:.6f} {:.6f}\n", x, y, z);
        }
        if (row == 0) continue;
        field.each_triangle(row - 1, [&](auto a, auto b, auto c) {
            file.print("f -{} -{} -{}\n", vertex - a, vertex - b, vertex - c);
        });
    }
}

void put_facet(const HeightField& field, OutputFile& file, const std::array<std::uint32_t, 3>& corners)
{
    put(file, std::array<float, 3>{0, 0, 1});
    for (const std::uint32_t corner : corners) {
        const auto [x, y, z] = field.vertex(corner);
        put(file, std::array<float, 3>{float(x), float(y), float(z)});
    }
    put(file, std::uint16_t(0));
}

void write_binary_stl(const HeightField& field, OutputFile& file, bool mixed)
{
    file.write(std::string(80, ' '));
    put(file, field.triangles());
    if (!mixed) {
        field.each_triangle([&](auto a, auto b, auto c) { put_facet(field, file, {a, b, c}); });
        return;
    }
    std::vector<std::array<std::uint32_t, 3>> triangles;
    triangles.reserve(field.triangles());
    field.each_triangle([&](auto a, auto b, auto c) { triangles.push_back({a, b, c}); });
    for (std::size_t i = triangles.size(); i > 1; --i) std::swap(triangles[i - 1], triangles[splitmix(i) % i]);
    for (const auto& corners : triangles) put_facet(field, file, corners);
}

void write_text_stl(const HeightField& field, OutputFile& file)
{
    file.print("solid land\n");
    field.each_triangle([&](auto a, auto b, auto c) {
        file.print("facet normal 0 0 1\n  outer loop\n");
        for (const std::uint32_t corner : {a, b, c}) {
            const auto [x, y, z] = field.vertex(corner);
            file.print("    vertex {:.6f} {:.6f} {:.6f}\n", x, y, z);
        }
        file.print("  endloop\nendfacet\n");
    });
    file.print("endsolid land\n");
}

void write_ply(const HeightField& field, OutputFile& file, bool binary)
{
    file.print("ply\nformat {} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
               "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
               binary ? "binary_little_endian" : "ascii", field.vertices(), field.triangles());
    field.each_vertex([&](double x, double y, double z) {
        if (binary)
            put(file, std::array<float, 3>{float(x), float(y), float(z)});
        else
            file.print("{:.6f} {:.6f} {:.6f}\n", x, y, z);
    });
    field.each_triangle([&](auto a, auto b, auto c) {
        if (binary)
            put(file, std::uint8_t(3)), put(file, std::array<std::uint32_t, 3>{a, b, c});
        else
            file.print("3 {} {} {}\n", a, b, c);
    });
}

void write_off(const HeightField& field, OutputFile& file)
{
    file.print("OFF\n{} {} 0\n", field.vertices(), field.triangles());
    field.each_vertex([&](double x, double y, double z) { file.print("{:.6f} {:.6f} {:.6f}\n", x, y, z); });
    field.each_triangle([&](auto a, auto b, auto c) { file.print("3 {} {} {}\n", a, b, c); });
}

} // namespace

void write_mesh_file(const MeshFileStyle& style, const std::filesystem::path& path, std::uint32_t cells,
                     std::uint64_t seed)
{
    const HeightField field(cells, seed);
    OutputFile file(path);
    if (style.name == "obj-full")
        write_full_obj(field, file);
    else if (style.name == "obj-back")
        write_backward_obj(field, file);
    else if (style.extension == "obj")
        write_plain_obj(field, file, style.name == "obj-exact");
    else if (style.name == "stl" || style.name == "stl-mixed")
        write_binary_stl(field, file, style.name == "stl-mixed");
    else if (style.name == "stl-text")
        write_text_stl(field, file);
    else if (style.extension == "ply")
        write_ply(field, file, style.name == "ply");
    else
        write_off(field, file);
    file.commit();
}

} // namespace oncollide::tools

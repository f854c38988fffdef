#include <oncollide/scenes/files/tables/body_table.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/text/csv_reader.hpp>
#include <oncollide/base/text/near_word.hpp>
#include <oncollide/scenes/files/mesh/mesh_source.hpp>

namespace oncollide {

namespace {

constexpr std::uintmax_t largest_table = std::uintmax_t(4) << 30;

enum Column { geometry, x, y, z, qx, qy, qz, qw, vx, vy, vz, layer, mask, group, fixed, name, columns };
constexpr std::array<std::string_view, columns> column_names = {
    "geometry", "x", "y", "z", "qx", "qy", "qz", "qw", "vx", "vy", "vz", "layer", "mask", "group", "static", "name"};

std::vector<Column> read_header(CsvReader& fields, bool needs_geometry)
{
    std::vector<Column> header;
    for (bool last = false; !last;) {
        const std::string_view field = fields.next(last);
        const auto found = std::ranges::find(column_names, field);
        if (found == column_names.end())
            fields.fail(fmt::format("unknown column {}{}", // a long name is the text of another kind of file
                                    field.size() <= 16 ? quoted(field) : fmt::format("of {} bytes", field.size()),
                                    valid_names(field, {column_names.begin(), column_names.end()})));
        const auto column = static_cast<Column>(found - column_names.begin());
        if (std::ranges::find(header, column) != header.end())
            fields.fail(fmt::format("column '{}' is there twice", field));
        header.push_back(column);
    }
    const auto need = [&](std::initializer_list<Column> wanted) {
        for (const Column column : wanted)
            if (std::ranges::find(header, column) == header.end())
                fields.fail(fmt::format("the column '{}' is missing", column_names[column]));
    };
    const auto all_or_none = [&](std::initializer_list<Column> group) {
        if (std::ranges::find_first_of(header, group) != header.end()) need(group);
    };
    need({x, y, z});
    if (needs_geometry) need({geometry});
    all_or_none({qx, qy, qz, qw}), all_or_none({vx, vy, vz});
    return header;
}

/// Reads the fields of a row.
class RowReader {
public:
    RowReader(const BodyRows& rows, const CsvReader& fields) : rows_(rows), fields_(fields)
    {
        if (rows.geometry()) row.geometry = *rows.geometry();
    }

    void set(Column column, std::string_view field)
    {
        switch (column) {
        case geometry:
            return set_geometry(field);
        case layer:
            return set(column, field, 0xffffffffu, row.layer);
        case mask:
            return set(column, field, 0xffffffffu, row.mask);
        case group:
            return set(column, field, 0xffffffffu, row.group);
        case fixed: {
            std::uint32_t number = 0;
            set(column, field, 1, number);
            row.is_static = number == 1;
            return;
        }
        case name:
            name_ = field;
            row.name = name_;
            return;
        default:
            double value = 0;
            if (!parse(field, value) || !std::isfinite(value))
                fields_.fail(
                    fmt::format("column '{}' is {}; it must be a finite number", column_names[column], quoted(field)));
            if (column < qx)
                row.position[column - x] = value;
            else if (column < vx)
                row.rotation[column - qx] = value;
            else
                row.velocity[column - vx] = value;
        }
    }

    BodyRow row;

private:
    void set_geometry(std::string_view field)
    {
        if (field == geometry_name_) return; // the row has the same geometry as the previous row
        const std::optional<GeometryId> found = rows_.scene().find_geometry(field);
        if (!found) fields_.fail(fmt::format("no geometry named {}", quoted(field)));
        row.geometry = *found, geometry_name_ = field;
    }
    void set(Column column, std::string_view field, std::uint32_t most, std::uint32_t& value) const
    {
        const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
        if (error != std::errc{} || end != field.data() + field.size() || value > most)
            fields_.fail(fmt::format("column '{}' is {}; it must be a whole number from 0 to {}", column_names[column],
                                     quoted(field), most));
    }

    const BodyRows& rows_;
    const CsvReader& fields_;
    std::string geometry_name_, name_;
};

/// Adds a body for each line of `fields`.
void read_rows(BodyRows& rows, CsvReader& fields, const std::vector<Column>& header, RowReader& reader)
{
    const auto place = [&] { return fmt::format("{}: line {}", rows.file(), fields.line()); };
    while (!fields.at_end()) {
        fields.next_line();
        if (rows.skip()) {
            fields.skip_line();
            continue;
        }
        bool last = false;
        for (std::size_t k = 0; k < header.size(); ++k) {
            if (last) fields.fail(fmt::format("has {} fields; the header has {}", k, header.size()));
            reader.set(header[k], fields.next(last));
        }
        if (!last) fields.fail(fmt::format("has more fields than the header, which has {}", header.size()));
        rows.add(reader.row, place);
    }
}

std::vector<Column> header_of(const BodyRows& rows, CsvReader& fields)
{
    std::vector<Column> header = read_header(fields, !rows.geometry());
    if (rows.geometry() && std::ranges::find(header, geometry) != header.end())
        fields.fail("the table has a column 'geometry', and the scene file gives a geometry for all rows");
    return header;
}

/// Reads a file in pieces that end with a line; only one piece is in memory.
class Pieces {
public:
    explicit Pieces(const std::filesystem::path& path) : name_(path.string())
    {
        check_readable(path);
        file_.open(path, std::ios::binary);
    }
    /// The next piece, valid until the next call; empty at the end.
    std::string_view next()
    {
        constexpr std::size_t size = std::size_t(1) << 20, longest_line = std::size_t(64) << 20;
        text_.erase(0, taken_);
        taken_ = 0;
        while (file_ && taken_ == 0) {
            const std::size_t before = text_.size();
            if (before > longest_line) refuse(name_, "has a line of over 64 MB");
            text_.resize(before + size);
            file_.read(text_.data() + before, std::streamsize(size));
            text_.resize(before + std::size_t(file_.gcount()));
            if (file_.bad()) throw Error(ErrorKind::no_input, name_ + ": cannot be read");
            taken_ = text_.rfind('\n') + 1; // 0 if there is no end of a line
        }
        if (!file_) taken_ = text_.size();
        return std::string_view(text_).substr(0, taken_);
    }

private:
    std::string name_;
    std::ifstream file_;
    std::string text_;
    std::size_t taken_ = 0;
};

/// For a scene that wants only some of the rows: holds one piece of the file at a time.
void read_csv_pieces(BodyRows& rows, const std::filesystem::path& path)
{
    Pieces pieces(path);
    const std::string_view first = pieces.next();
    if (first.empty()) refuse(rows.file(), "the file is empty");
    CsvReader fields(rows.file(), without_byte_order_mark(first));
    const std::vector<Column> header = header_of(rows, fields);
    RowReader reader(rows, fields);
    read_rows(rows, fields, header, reader);
    for (std::string_view piece = pieces.next(); !piece.empty(); piece = pieces.next()) {
        rows.expect(piece.size() / 2); // a line has at least two bytes
        fields.go_on(piece);
        read_rows(rows, fields, header, reader);
    }
}

} // namespace

void read_csv_bodies(BodyRows& rows, const std::filesystem::path& path)
{
    if (rows.scene().has_sink()) return read_csv_pieces(rows, path);
    const FileBytes bytes = read_large_file(path, largest_table);
    const std::string_view text = without_byte_order_mark(bytes);
    CsvReader fields(rows.file(), text);
    const std::vector<Column> header = header_of(rows, fields);
    rows.expect(static_cast<std::size_t>(std::ranges::count(text, '\n')) - (text.back() == '\n'));
    RowReader reader(rows, fields);
    read_rows(rows, fields, header, reader);
}

} // namespace oncollide

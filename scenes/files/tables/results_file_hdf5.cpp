#include <oncollide/scenes/files/tables/results_file.hpp>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <tuple>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/scenes/files/tables/hdf5_writing.hpp>

namespace oncollide {

namespace {

namespace fs = std::filesystem;
using namespace hdf5_writing;

constexpr hsize_t pair_chunk = 16'384, frame_chunk = 128; // rows per chunk of the file

Hdf5Handle text_type()
{
    constexpr auto variable_length = static_cast<std::size_t>(-1); // H5T_VARIABLE
    Hdf5Handle text = type(hdf5().H5Tcopy(hdf5().text));
    sure(hdf5().H5Tset_size(text.id(), variable_length)), sure(hdf5().H5Tset_cset(text.id(), H5T_CSET_UTF8));
    return text;
}

Hdf5Handle enumeration(const std::vector<std::string>& names)
{
    Hdf5Handle made = type(hdf5().H5Tenum_create(hdf5().native_uint8));
    for (std::uint8_t value = 0; value < names.size(); ++value)
        sure(hdf5().H5Tenum_insert(made.id(), names[value].c_str(), &value));
    return made;
}

struct Field {
    std::string name;
    std::size_t offset;
    hid_t type;
};

Hdf5Handle row_type(std::size_t size, const std::vector<Field>& fields)
{
    Hdf5Handle made = type(hdf5().H5Tcreate(H5T_COMPOUND, size));
    for (const Field& field : fields) sure(hdf5().H5Tinsert(made.id(), field.name.c_str(), field.offset, field.type));
    return made;
}

Hdf5Handle pair_type(const ResultsHeader& header)
{
    const Hdf5& h5 = hdf5();
    const Hdf5Handle verdict = enumeration(header.verdicts), stage = enumeration(header.stages),
                     kind = enumeration(header.kinds);
    return row_type(sizeof(PairRow), {{"a", offsetof(PairRow, a), h5.native_uint32},
                                      {"b", offsetof(PairRow, b), h5.native_uint32},
                                      {"verdict", offsetof(PairRow, verdict), verdict.id()},
                                      {"stage", offsetof(PairRow, stage), stage.id()},
                                      {"kind", offsetof(PairRow, kind), kind.id()},
                                      {"gap_bound", offsetof(PairRow, bound), h5.native_double},
                                      {"max_error", offsetof(PairRow, max_error), h5.native_double}});
}

Hdf5Handle sweep_type()
{
    const Hdf5& h5 = hdf5();
    std::vector<Field> fields{{"clear_until", offsetof(SweepRow, clear_until), h5.native_double},
                              {"contact_by", offsetof(SweepRow, contact_by), h5.native_double},
                              {"gap", offsetof(SweepRow, gap), h5.native_double},
                              {"triangle_a", offsetof(SweepRow, triangle_a), h5.native_uint32},
                              {"triangle_b", offsetof(SweepRow, triangle_b), h5.native_uint32},
                              {"separating", offsetof(SweepRow, separating), h5.native_uint8}};
    for (std::size_t k = 0; k < 3; ++k) {
        fields.push_back({std::string(1, "xyz"[k]), offsetof(SweepRow, point) + k * sizeof(double), h5.native_double});
        fields.push_back(
            {fmt::format("normal_{}", "xyz"[k]), offsetof(SweepRow, normal) + k * sizeof(double), h5.native_double});
    }
    std::ranges::sort(fields, {}, &Field::name);
    return row_type(sizeof(SweepRow), fields);
}

Hdf5Handle frame_type(const ResultsHeader& header)
{
    const Hdf5& h5 = hdf5();
    std::vector<Field> fields{
        {"frame", offsetof(FrameRow, frame), h5.native_uint64}, {"first", offsetof(FrameRow, first), h5.native_uint64},
        {"pairs", offsetof(FrameRow, pairs), h5.native_uint64}, {"hash", offsetof(FrameRow, hash), h5.native_uint64},
        {"chain", offsetof(FrameRow, chain), h5.native_uint64}, {"ms", offsetof(FrameRow, ms), h5.native_double}};
    std::size_t at = offsetof(FrameRow, stages);
    for (const std::string& stage : header.stages) {
        fields.push_back({stage + "_in", at + offsetof(StageRow, in), h5.native_uint64});
        fields.push_back({stage + "_out", at + offsetof(StageRow, out), h5.native_uint64});
        fields.push_back({stage + "_undecided", at + offsetof(StageRow, undecided), h5.native_uint64});
        fields.push_back({stage + "_ms", at + offsetof(StageRow, ms), h5.native_double});
        at += sizeof(StageRow);
    }
    std::ranges::sort(fields, {}, &Field::name); // otherwise HDF5 sorts them slowly in each write
    return row_type(sizeof(FrameRow), fields);
}

/// A growing dataset of rows, and the type of its rows.
struct Rows {
    Hdf5Handle dataset, row;

    /// Calls move(memory space, file space) for rows `first` to `first + count - 1`.
    template <class Move>
    void some(hsize_t first, hsize_t count, Move move) const
    {
        const Hdf5& h5 = hdf5();
        const Hdf5Handle all = space(h5.H5Dget_space(dataset.id())),
                         memory = space(h5.H5Screate_simple(1, &count, nullptr));
        sure(h5.H5Sselect_hyperslab(all.id(), H5S_SELECT_SET, &first, nullptr, &count, nullptr));
        sure(move(memory.id(), all.id()));
    }
    /// Appends rows after the first `size`.
    void append(hsize_t size, hsize_t count, const void* rows) const
    {
        const hsize_t extent = size + count;
        sure(hdf5().H5Dset_extent(dataset.id(), &extent));
        if (count)
            some(size, count, [&](hid_t memory, hid_t file) {
                return hdf5().H5Dwrite(dataset.id(), row.id(), memory, file, H5P_DEFAULT, rows);
            });
    }
};

Rows make_rows(hid_t file, const char* name, Hdf5Handle row, hsize_t chunk)
{
    const Hdf5& h5 = hdf5();
    const hsize_t none = 0, any = H5S_UNLIMITED;
    const Hdf5Handle extent = space(h5.H5Screate_simple(1, &none, &any)), plan = properties(h5.dataset_creation);
    sure(h5.H5Pset_chunk(plan.id(), 1, &chunk));
    Hdf5Handle dataset(sure(h5.H5Dcreate2(file, name, row.id(), extent.id(), H5P_DEFAULT, plan.id(), H5P_DEFAULT)),
                       h5.H5Dclose);
    return {std::move(dataset), std::move(row)};
}

void write_attribute(hid_t file, const char* name, hid_t type, const void* value)
{
    const Hdf5& h5 = hdf5();
    const Hdf5Handle one = space(h5.H5Screate(H5S_SCALAR));
    const Hdf5Handle made(sure(h5.H5Acreate2(file, name, type, one.id(), H5P_DEFAULT, H5P_DEFAULT)), h5.H5Aclose);
    sure(h5.H5Awrite(made.id(), type, value));
}

void write_header(hid_t file, const ResultsHeader& header)
{
    const Hdf5Handle text = text_type();
    for (const auto& [name, value] : {std::pair("version", &header.version), std::pair("scene", &header.scene),
                                      std::pair("settings", &header.settings), std::pair("source", &header.source)}) {
        const char* const letters = value->c_str();
        write_attribute(file, name, text.id(), &letters);
    }
    write_attribute(file, "bodies", hdf5().native_uint64, &header.bodies);
}

void write_names(hid_t file, const NameColumn& names)
{
    const Hdf5& h5 = hdf5();
    const hsize_t count = names.size();
    bool any = false;
    for (std::size_t i = 0; i < count && !any; ++i) any = !names[i].empty();
    if (!any) return;
    const Hdf5Handle all = space(h5.H5Screate_simple(1, &count, nullptr));
    Rows rows{{}, text_type()};
    rows.dataset = {sure(h5.H5Dcreate2(file, "names", rows.row.id(), all.id(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT)),
                    h5.H5Dclose};
    constexpr hsize_t block = 65'536;
    std::vector<std::string> texts;
    std::vector<const char*> letters;
    for (hsize_t first = 0; first < count; first += block) {
        texts.clear(), letters.clear();
        for (hsize_t i = first; i < std::min(count, first + block); ++i) texts.emplace_back(names[i]);
        for (const std::string& text : texts) letters.push_back(text.c_str());
        rows.some(first, letters.size(), [&](hid_t memory, hid_t file_space) {
            return h5.H5Dwrite(rows.dataset.id(), rows.row.id(), memory, file_space, H5P_DEFAULT, letters.data());
        });
    }
}

/// Throws unless it was written by this version, of this scene, with these settings.
void check_header(const std::string& name, const ResultsHeader& found, const ResultsHeader& wanted)
{
    for (const auto& [what, there, here] :
         {std::tuple("version", &found.version, &wanted.version), std::tuple("scene", &found.scene, &wanted.scene),
          std::tuple("settings", &found.settings, &wanted.settings)})
        if (*there != *here)
            throw Error(ErrorKind::usage,
                        fmt::format("{}: cannot be continued: its '{}' differs from this run's: {} there, {} here",
                                    name, what, *there, *here));
}

/// The rows before `frame`.
std::span<const FrameRow> frames_before(const std::string& name, std::span<const FrameRow> rows, std::uint64_t frame)
{
    const std::uint64_t first = rows.front().frame, last = rows.back().frame;
    if (frame <= first || frame > last + 1)
        throw Error(ErrorKind::usage, fmt::format("{}: holds frames {} to {}; it can be continued from frames {} to {}",
                                                  name, first, last, first + 1, last + 1));
    return rows.first(frame - first);
}

} // namespace

struct ResultsFile::Open {
    Hdf5Handle file;
    Rows frames, pairs;
    std::optional<Rows> sweeps;
};

ResultsFile::ResultsFile(const fs::path& path, const ResultsHeader& header, const NameColumn& names,
                         std::uint64_t frame)
    : name_(path.string())
{
    hdf5();
    check_writable(path);
    std::error_code none;
    const bool goes_on = frame > 0 && fs::exists(path, none);
    const fs::path written = goes_on ? fs::path(path).concat(".part") : path;
    open_ = std::make_unique<Open>();
    try {
        errno = 0;
        open_->file = create(written);
        const hid_t file = open_->file.id();
        write_header(file, header);
        write_names(file, names);
        open_->pairs = make_rows(file, "pairs", pair_type(header), pair_chunk);
        if (header.sweeps) open_->sweeps = make_rows(file, "sweeps", sweep_type(), pair_chunk);
        open_->frames = make_rows(file, "frames", frame_type(header), frame_chunk);
        sure(hdf5().H5Fflush(file, H5F_SCOPE_LOCAL));
        sure(hdf5().H5Fstart_swmr_write(file));
    } catch (const Failed&) {
        fail();
    }
    if (!goes_on) return;
    try {
        copy(path, header, frame);
    } catch (const Error&) {
        fs::remove(written, none);
        throw;
    }
    std::error_code error;
    fs::rename(written, path, error);
    if (error) throw Error(ErrorKind::cannot_write, fmt::format("{}: cannot be replaced: {}", name_, error.message()));
}

void ResultsFile::copy(const fs::path& from, const ResultsHeader& header, std::uint64_t frame)
{
    const StoredResults earlier(from, header);
    check_header(name_, earlier.header(), header);
    std::vector<PairRow> pairs;
    std::vector<SweepRow> sweeps;
    for (const FrameRow& row : frames_before(name_, earlier.frames(), frame))
        earlier.read(row, pairs), earlier.read(row, sweeps), add(pairs, row, sweeps);
}

ResultsFile::~ResultsFile()
{
    if (open_ && std::uncaught_exceptions() == 0) try {
            close();
        } catch (const Error&) { // callers who need the error call close()
        }
}

void ResultsFile::add(std::span<const PairRow> pairs, FrameRow row, std::span<const SweepRow> sweeps)
{
    ONCOLLIDE_ASSERT(sweeps.size() == (open_->sweeps ? pairs.size() : 0));
    row.first = pairs_, row.pairs = pairs.size();
    try {
        const Hdf5& h5 = hdf5();
        errno = 0;
        open_->pairs.append(pairs_, pairs.size(), pairs.data());
        sure(h5.H5Dflush(open_->pairs.dataset.id()));
        if (open_->sweeps) {
            open_->sweeps->append(pairs_, sweeps.size(), sweeps.data());
            sure(h5.H5Dflush(open_->sweeps->dataset.id()));
        }
        open_->frames.append(frames_, 1, &row); // from now on the frame is part of the file
        sure(h5.H5Dflush(open_->frames.dataset.id()));
    } catch (const Failed&) {
        fail();
    }
    pairs_ += pairs.size(), ++frames_, chain_ = row.chain;
}

void ResultsFile::close()
{
    if (!open_) return;
    try {
        errno = 0;
        open_->pairs = {}, open_->sweeps.reset(), open_->frames = {};
        sure(hdf5().H5Fflush(open_->file.id(), H5F_SCOPE_LOCAL));
        open_.reset();
    } catch (const Failed&) {
        fail();
    }
}

/// Leaves open objects open until the program ends: closing them would write.
void ResultsFile::fail()
{
    const std::string why = errno ? std::strerror(errno) : "HDF5 cannot write it";
    static_cast<void>(open_.release());
    throw Error(ErrorKind::cannot_write, fmt::format("{}: cannot write: {}", name_, why));
}

} // namespace oncollide

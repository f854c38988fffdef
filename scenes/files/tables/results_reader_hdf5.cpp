#include <oncollide/scenes/files/tables/results_file.hpp>

#include <algorithm>
#include <cstring>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/scenes/files/hdf5/hdf5_attribute.hpp>
#include <oncollide/scenes/files/hdf5/hdf5_dataset.hpp>
#include <oncollide/scenes/files/hdf5/hdf5_heap.hpp>
#include <oncollide/scenes/files/hdf5/hdf5_links.hpp>

namespace oncollide {

/// A member of a row in memory.
struct StoredField {
    std::string name;
    std::uint64_t offset, size;
    Hdf5Type::Kind kind;
    const std::vector<std::string>* words = nullptr; ///< words of an enumeration, from 0 on
};

namespace {

std::vector<StoredField> pair_fields(const ResultsHeader& words)
{
    return {{"a", offsetof(PairRow, a), 4, Hdf5Type::Kind::whole},
            {"b", offsetof(PairRow, b), 4, Hdf5Type::Kind::whole},
            {"verdict", offsetof(PairRow, verdict), 1, Hdf5Type::Kind::enumeration, &words.verdicts},
            {"stage", offsetof(PairRow, stage), 1, Hdf5Type::Kind::enumeration, &words.stages},
            {"kind", offsetof(PairRow, kind), 1, Hdf5Type::Kind::enumeration, &words.kinds},
            {"gap_bound", offsetof(PairRow, bound), 8, Hdf5Type::Kind::real},
            {"max_error", offsetof(PairRow, max_error), 8, Hdf5Type::Kind::real}};
}

std::vector<StoredField> sweep_fields()
{
    std::vector<StoredField> fields{{"clear_until", offsetof(SweepRow, clear_until), 8, Hdf5Type::Kind::real},
                                    {"contact_by", offsetof(SweepRow, contact_by), 8, Hdf5Type::Kind::real},
                                    {"gap", offsetof(SweepRow, gap), 8, Hdf5Type::Kind::real},
                                    {"triangle_a", offsetof(SweepRow, triangle_a), 4, Hdf5Type::Kind::whole},
                                    {"triangle_b", offsetof(SweepRow, triangle_b), 4, Hdf5Type::Kind::whole},
                                    {"separating", offsetof(SweepRow, separating), 1, Hdf5Type::Kind::whole}};
    for (std::uint64_t k = 0; k < 3; ++k) {
        fields.push_back({std::string(1, "xyz"[k]), offsetof(SweepRow, point) + 8 * k, 8, Hdf5Type::Kind::real});
        fields.push_back(
            {fmt::format("normal_{}", "xyz"[k]), offsetof(SweepRow, normal) + 8 * k, 8, Hdf5Type::Kind::real});
    }
    return fields;
}

std::vector<StoredField> frame_fields(const ResultsHeader& words)
{
    std::vector<StoredField> fields{{"frame", offsetof(FrameRow, frame), 8, Hdf5Type::Kind::whole},
                                    {"first", offsetof(FrameRow, first), 8, Hdf5Type::Kind::whole},
                                    {"pairs", offsetof(FrameRow, pairs), 8, Hdf5Type::Kind::whole},
                                    {"hash", offsetof(FrameRow, hash), 8, Hdf5Type::Kind::whole},
                                    {"chain", offsetof(FrameRow, chain), 8, Hdf5Type::Kind::whole},
                                    {"ms", offsetof(FrameRow, ms), 8, Hdf5Type::Kind::real}};
    std::uint64_t at = offsetof(FrameRow, stages);
    for (const std::string& stage : words.stages) {
        fields.push_back({stage + "_in", at + offsetof(StageRow, in), 8, Hdf5Type::Kind::whole});
        fields.push_back({stage + "_out", at + offsetof(StageRow, out), 8, Hdf5Type::Kind::whole});
        fields.push_back({stage + "_undecided", at + offsetof(StageRow, undecided), 8, Hdf5Type::Kind::whole});
        fields.push_back({stage + "_ms", at + offsetof(StageRow, ms), 8, Hdf5Type::Kind::real});
        at += sizeof(StageRow);
    }
    return fields;
}

} // namespace

/// A dataset of rows, whose members are found by name.
class StoredRows {
public:
    StoredRows(Hdf5Dataset data, std::vector<StoredField> fields) : data_(std::move(data))
    {
        const Hdf5Type& type = data_.type();
        if (type.kind != Hdf5Type::Kind::compound || data_.extent().size() != 1) throw Hdf5Fault{"holds other values"};
        std::ranges::sort(fields, {}, &StoredField::offset);
        for (const StoredField& field : fields) {
            const auto member = std::ranges::find(type.members, field.name, &Hdf5Type::Member::name);
            if (member == type.members.end() || member->type.kind != field.kind || member->type.size != field.size ||
                member->type.is_signed || member->type.is_big_endian)
                throw Hdf5Fault{fmt::format("has no column '{}' of the right type", field.name)};
            add(field, *member);
        }
    }

    std::uint64_t size() const
    {
        if (data_.extent()[0] > data_.rows_in_file()) throw Hdf5Fault{"the file is too short for its rows"};
        return data_.extent()[0];
    }

    template <class Row>
    void read(std::uint64_t first, std::uint64_t count, Row* rows) const
    {
        const std::uint64_t row_bytes = data_.type().size;
        const bool same = copies_.size() == 1 && copies_[0].bytes == row_bytes && row_bytes == sizeof(Row);
        data_.read({&first, 1}, {&count, 1}, [&](const Hdf5Piece& piece) {
            if (same && piece.value_bytes == row_bytes)
                std::memcpy(rows + piece.to, piece.from, piece.columns * row_bytes);
            else
                for (std::uint64_t i = 0; i < piece.columns; ++i)
                    for (const Copy& copy : copies_)
                        std::memcpy(reinterpret_cast<char*>(rows + piece.to + i) + copy.to,
                                    piece.from + i * piece.value_bytes + copy.from, copy.bytes);
        });
        for (const Translation& words : translations_)
            for (std::uint64_t i = 0; i < count; ++i) {
                auto& value = reinterpret_cast<std::uint8_t*>(rows + i)[words.at];
                value = words.numbers[value];
            }
    }

private:
    struct Copy {
        std::uint64_t from, to, bytes;
    };
    struct Translation {
        std::uint64_t at;
        std::array<std::uint8_t, 256> numbers;
    };

    void add(const StoredField& field, const Hdf5Type::Member& member)
    {
        if (!copies_.empty() && copies_.back().to + copies_.back().bytes == field.offset &&
            copies_.back().from + copies_.back().bytes == member.offset)
            copies_.back().bytes += field.size;
        else
            copies_.push_back({member.offset, field.offset, field.size});
        if (!field.words) return;
        Translation words{field.offset, {}};
        words.numbers.fill(0xff); // stands for an unknown word
        bool same = member.type.names.size() == field.words->size();
        for (const auto& [name, number] : member.type.names) {
            const auto found = std::ranges::find(*field.words, name);
            if (found != field.words->end())
                words.numbers[number] = static_cast<std::uint8_t>(found - field.words->begin());
            same = same && words.numbers[number] == number;
        }
        if (!same) translations_.push_back(words);
    }

    Hdf5Dataset data_;
    std::vector<Copy> copies_; ///< copies of each row
    std::vector<Translation> translations_;
};

struct StoredResults::Open {
    std::shared_ptr<const Hdf5Bytes> file;
    std::unique_ptr<StoredRows> frames, pairs, sweeps;

    std::optional<Hdf5Dataset> find(const char* name) const
    {
        const auto object = find_hdf5_object(*file, name);
        return object ? std::optional(Hdf5Dataset(file, *object)) : std::nullopt;
    }
    std::unique_ptr<StoredRows> rows(const std::string& path, const char* name, std::vector<StoredField> fields) const
    {
        try {
            if (auto data = find(name)) return std::make_unique<StoredRows>(std::move(*data), std::move(fields));
            throw Hdf5Fault{"is missing"};
        } catch (const Hdf5Fault& fault) {
            if (fault.what == hdf5_in_other_file) refuse(fmt::format("{}: {}", path, name), fault.what);
            throw Hdf5Fault{fmt::format("{}: {}", name, fault.what)};
        }
    }
    void read_header(ResultsHeader& header) const
    {
        Hdf5Walk walk(*file);
        const Hdf5Object root(walk, file->root());
        Hdf5TextHeap texts(*file);
        for (const auto& [name, value] :
             {std::pair("version", &header.version), std::pair("scene", &header.scene),
              std::pair("settings", &header.settings), std::pair("source", &header.source)}) {
            const Hdf5Attribute found = hdf5_attribute(walk, root, name);
            if (found.type.kind != Hdf5Type::Kind::text)
                throw Hdf5Fault{fmt::format("the attribute '{}' has another type", name)};
            *value = texts.text(found.data.cursor(*file));
        }
        const Hdf5Attribute bodies = hdf5_attribute(walk, root, "bodies");
        if (bodies.type.kind != Hdf5Type::Kind::whole || bodies.type.size != 8 || bodies.type.is_big_endian)
            throw Hdf5Fault{"the attribute 'bodies' has another type"};
        header.bodies = bodies.data.cursor(*file).number(8);
    }
};

StoredResults::StoredResults(const std::filesystem::path& path, const ResultsHeader& words)
    : name_(path.string()), open_(std::make_unique<Open>())
{
    if (!is_regular(path)) check_readable(path); // a file that a run continues is not an input
    try {
        open_->file = std::make_shared<const Hdf5Bytes>(path, Hdf5Bytes::Access::while_written);
        open_->read_header(header_);
        open_->frames = open_->rows(name_, "frames", frame_fields(words));
        frames_.resize(open_->frames->size());
        if (!frames_.empty()) open_->frames->read(0, frames_.size(), frames_.data());
        // Read after the frames, because there may be more pairs than they count.
        open_->pairs = open_->rows(name_, "pairs", pair_fields(words));
        if (frames_.empty()) throw Hdf5Fault{"it holds no frame"};
        header_.sweeps = open_->find("sweeps").has_value();
        if (header_.sweeps) open_->sweeps = open_->rows(name_, "sweeps", sweep_fields());
        std::uint64_t pairs = open_->pairs->size();
        if (header_.sweeps) pairs = std::min(pairs, open_->sweeps->size());
        for (std::size_t k = 0; k < frames_.size(); ++k) {
            const FrameRow& row = frames_[k];
            if (row.frame - frames_[0].frame != k || row.first > pairs || row.pairs > pairs - row.first)
                throw Hdf5Fault{fmt::format("row {} of 'frames' is impossible", k)};
        }
    } catch (const Hdf5Fault& fault) {
        // A run that is killed early leaves an empty file, half a header, or no frame.
        refuse(name_, fmt::format("is not a results file of 'oncollide run --pairs', or is damaged, or its run was cut "
                                  "off before the first frame was done: {}; run the scene again, without --from-frame",
                                  fault.what));
    }
}

StoredResults::~StoredResults() = default;

std::string StoredResults::unlike(const NameColumn& names) const
{
    try {
        const auto data = open_->find("names");
        if (!data) return {}; // no body has a name
        if (data->type().kind != Hdf5Type::Kind::text || data->extent().size() != 1 ||
            data->extent()[0] > data->rows_in_file())
            throw Hdf5Fault{"they have another type"};
        Hdf5TextHeap texts(*open_->file);
        std::string found;
        const std::uint64_t none = 0, count = data->extent()[0];
        data->read({&none, 1}, {&count, 1}, [&](const Hdf5Piece& piece) {
            for (std::uint64_t i = 0; i < piece.columns && found.empty(); ++i) {
                const Hdf5Cursor place(*open_->file, {piece.from + i * piece.value_bytes, data->type().size}, 0);
                const std::string_view name = texts.text(place);
                const std::uint64_t body = piece.to + i;
                if (body >= names.size() || name != std::string_view(names[body])) found = name;
            }
        });
        return found;
    } catch (const Hdf5Fault& fault) {
        if (fault.what == hdf5_in_other_file) refuse(name_ + ": names", fault.what);
        refuse(name_, "the names of its bodies cannot be read: " + fault.what);
    }
}

void StoredResults::read(const FrameRow& frame, std::vector<SweepRow>& sweeps) const
{
    sweeps.resize(header_.sweeps ? frame.pairs : 0);
    if (sweeps.empty()) return;
    try {
        open_->sweeps->read(frame.first, frame.pairs, sweeps.data());
    } catch (const Hdf5Fault& fault) {
        refuse(name_, fmt::format("the sweeps of frame {} cannot be read: {}", frame.frame, fault.what));
    }
}

void StoredResults::read(const FrameRow& frame, std::vector<PairRow>& pairs) const
{
    pairs.resize(frame.pairs);
    try {
        open_->pairs->read(frame.first, frame.pairs, pairs.data());
    } catch (const Hdf5Fault& fault) {
        refuse(name_, fmt::format("the pairs of frame {} cannot be read: {}", frame.frame, fault.what));
    }
}

} // namespace oncollide

#include "hdf5_inputs.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "formats.hpp"
#include "load_with_samples.hpp"
#include "scenes/files/hdf5_writers.hpp"
#include "temporary_folder.hpp"
#include <oncollide/base/files/checksum.hpp>
#include <oncollide/scenes/files/tables/results_file.hpp>
#include <oncollide/scenes/motion.hpp>

namespace oncollide::test {

namespace {

ResultsHeader results_header()
{
    ResultsHeader header;
    header.version = "1", header.scene = "scene", header.settings = header.source = "{}", header.bodies = 2;
    header.verdicts = {"separate", "within"}, header.stages = {"bounds", "broad"}, header.kinds = {"none", "near"};
    return header;
}

/// A file with a group of columns, each in another layout, and a recording of unit quaternions.
std::string table_file(const TemporaryFolder& folder, bool newest, std::size_t first_plan)
{
    const std::vector<Hdf5Plan> plans = hdf5_plans();
    const hid_t file = create_hdf5(folder / "a.h5", newest ? hdf5_newest : hdf5_oldest, first_plan % 2 ? 512 : 0);
    const hid_t bodies = H5Gcreate2(file, "bodies", 0, 0, 0);
    const auto add = [&](hid_t place, const char* name, std::vector<hsize_t> extent, hid_t type, auto value) {
        Hdf5Plan plan = plans[first_plan++ % plans.size()];
        const auto fit = [&](std::vector<hsize_t>& sizes, hsize_t largest) {
            if (!sizes.empty()) sizes.resize(extent.size(), largest);
            for (std::size_t d = 0; d < sizes.size(); ++d) sizes[d] = std::max(std::min(sizes[d], largest), hsize_t{1});
        };
        fit(plan.chunk, 2), fit(plan.most, H5S_UNLIMITED);
        for (std::size_t d = 0; d < plan.most.size(); ++d) plan.most[d] = std::max(plan.most[d], extent[d]);
        for (std::size_t d = 0; d < plan.chunk.size() && !plan.most.empty(); ++d)
            plan.chunk[d] = std::min(plan.chunk[d], plan.most[d]);
        plan.extent = extent, plan.written = Hdf5Plan::nothing;
        write_hdf5(place, name, plan, type, 2);
        const hid_t data = H5Dopen2(place, name, 0);
        std::vector<double> numbers;
        for (hsize_t i = 0, count = H5Sget_simple_extent_npoints(H5Dget_space(data)); i < count; ++i)
            numbers.push_back(value(i));
        H5Dwrite(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, 0, numbers.data()), H5Dclose(data);
    };
    const auto zero = [](hsize_t) { return 0; };
    add(bodies, "position", {6, 3}, H5T_IEEE_F32LE, [](hsize_t i) { return 0.5 * double(i); });
    add(bodies, "geometry", {6}, H5T_STD_U8LE, zero);
    add(bodies, "rotation", {6, 4}, H5T_IEEE_F64BE, [](hsize_t i) { return i % 4 == 3; });
    add(bodies, "velocity", {6, 3}, hdf5_half(), zero);
    add(bodies, "static", {6}, H5T_STD_I8LE, [](hsize_t) { return 1; });
    add(bodies, "layer", {6}, H5T_STD_I64BE, [](hsize_t) { return 1; });
    H5Gclose(bodies);
    add(file, "recorded", {3, 2, 7}, H5T_IEEE_F64LE, [](hsize_t i) { return i % 7 == 6; });
    H5Lcreate_soft("recorded", file, "poses", 0, 0);
    for (int i = 0; newest && i < 12; ++i) H5Lcreate_soft("/bodies", file, fmt::format("more {}", i).c_str(), 0, 0);
    H5Fclose(file);
    return folder.read("a.h5");
}

/// @param closed  false: the bytes that a killed writer leaves
std::string results_file(const TemporaryFolder& folder, bool closed)
{
    Scene scene;
    scene.add_body({.name = "first", .geometry = scene.add("ball", Sphere{.radius = 1})});
    ResultsFile file(folder / "a.h5", results_header(), scene.names);
    for (std::uint64_t frame = 0; frame < 4; ++frame) {
        const std::vector<PairRow> pairs(3, {0, 1, 1, 1, 0, 0.5, 1});
        file.add(pairs, {.frame = frame, .first = 0, .pairs = 0, .hash = 7, .chain = 8, .ms = 1, .stages = {}});
    }
    if (closed) file.close();
    return folder.read("a.h5");
}

/// A structure with a checksum.
struct Sealed {
    std::size_t at, size, checksum; ///< checksum: its place

    std::uint32_t right(const std::string& bytes) const
    {
        std::string part = bytes.substr(at, size);
        if (checksum + 4 == at + size)
            part.resize(size - 4);
        else
            std::fill_n(part.begin() + std::ptrdiff_t(checksum - at), 4, '\0');
        return lookup3(part);
    }
};

std::uint32_t word_at(const std::string& bytes, std::size_t at)
{
    std::uint32_t word = 0;
    for (std::size_t i = 4; i-- > 0;) word = word << 8 | static_cast<unsigned char>(bytes[at + i]);
    return word;
}

/// The structure that begins there, if its checksum is right.
std::optional<Sealed> sealed_at(const std::string& bytes, std::size_t at)
{
    const std::size_t left = bytes.size() - at;
    if (bytes.compare(at, 4, "FHDB") == 0) {
        const Sealed found{at, 512, at + 17}; // of 32 bits of offset
        if (left >= 512 && word_at(bytes, found.checksum) == found.right(bytes)) return found;
        return std::nullopt;
    }
    constexpr std::size_t longest = 600;
    for (std::size_t size = 12; size <= std::min(left, longest); ++size)
        if (word_at(bytes, at + size - 4) == lookup3(std::string_view(bytes).substr(at, size - 4)))
            return Sealed{at, size, at + size - 4};
    return std::nullopt;
}

/// The search takes longer than reading a file, so results are kept: callers pass the same seeds again.
const std::vector<Sealed>& sealed_parts(const std::string& bytes)
{
    static std::map<std::string, std::vector<Sealed>> known;
    if (known.size() > 100) known.clear();
    const auto [at, is_new] = known.try_emplace(bytes);
    std::vector<Sealed>& parts = at->second;
    if (!is_new) return parts;
    for (const std::string_view signature : {"\x89HDF", "OHDR", "OCHK", "FRHP", "FHIB", "FHDB", "BTHD", "BTIN", "BTLF",
                                             "FAHD", "FADB", "EAHD", "EAIB", "EASB", "EADB"})
        for (std::size_t place = bytes.find(signature); place != bytes.npos; place = bytes.find(signature, place + 1))
            if (const auto found = sealed_at(bytes, place)) parts.push_back(*found);
    return parts;
}

/// Changes a number of one to eight bytes.
void change(std::string& bytes, std::size_t at, std::size_t end, std::mt19937_64& random)
{
    const std::size_t width = std::min<std::size_t>(end - at, std::size_t{1} << random() % 4);
    std::uint64_t value = 0;
    for (std::size_t i = width; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
    const std::array<std::uint64_t, 8> values{value + 1, value - 1,        2 * value,        ~std::uint64_t{0},
                                              0,         random() % 0x400, bytes.size() / 2, random()};
    value = random() % 3 ? values[random() % values.size()] : random() % (bytes.size() + 8);
    for (std::size_t i = 0; i < width; ++i) bytes[at + i] = static_cast<char>(value >> 8 * i);
}

} // namespace

std::vector<std::string> hdf5_seeds()
{
    const TemporaryFolder folder;
    std::vector<std::string> seeds;
    for (const bool newest : {false, true})
        for (std::size_t plan = 0; plan < 22; plan += 3) seeds.push_back(table_file(folder, newest, plan));
    seeds.push_back(results_file(folder, true)), seeds.push_back(results_file(folder, false));
    return seeds;
}

std::string mutated_hdf5(std::string bytes, std::mt19937_64& random)
{
    if (bytes.size() < 64) return bytes;
    const std::vector<Sealed> parts = sealed_parts(bytes);
    for (std::uint64_t changes = 1 + random() % 3; changes > 0; --changes) {
        const std::size_t at = random() % bytes.size(), other = random() % bytes.size(),
                          length = std::min<std::size_t>(bytes.size() - std::max(at, other), 8u << random() % 7);
        switch (parts.empty() ? 5 + random() % 5 : random() % 10) {
        default: {
            const Sealed& part = parts[random() % parts.size()];
            if (part.at + part.size > bytes.size()) break; // cut off before
            const std::size_t place = part.at + 4 + random() % (part.size - 8);
            change(bytes, place, part.at + part.size, random);
            const std::uint32_t sum = part.right(bytes);
            for (std::size_t i = 0; i < 4; ++i) bytes[part.checksum + i] = static_cast<char>(sum >> 8 * i);
            break;
        }
        case 5:
        case 6:
        case 7:
            change(bytes, at, bytes.size(), random);
            break;
        case 8:
            bytes.replace(at, length, bytes.substr(other, length));
            break;
        case 9:
            if (random() % 4 == 0) bytes.resize(std::max<std::size_t>(at, 64));
            break;
        }
    }
    return bytes;
}

void read_hdf5(const std::filesystem::path& file, void (*check)(const Error&, const std::filesystem::path&))
{
    bool is_read = false;
    std::optional<Error> last;
    const auto attempt = [&](auto read) {
        try {
            read(), is_read = true;
        } catch (const Error& error) {
            check(error, file), last = error;
        }
    };
    attempt([&] { load_with_samples(file.parent_path() / "hdf5-table.json"); });
    attempt([&] {
        Scene scene = load_with_samples(file.parent_path() / "hdf5-recording.json");
        Mover mover;
        for (int frame = 0; frame < std::min(scene.frames, 5); ++frame) mover.move(scene, frame);
    });
    attempt([&] {
        const StoredResults stored(file, results_header());
        stored.unlike(NameColumn());
        std::vector<PairRow> pairs;
        for (const FrameRow& row : stored.frames().first(std::min<std::size_t>(5, stored.frames().size())))
            stored.read(row, pairs);
    });
    if (!is_read) throw *last;
}

} // namespace oncollide::test

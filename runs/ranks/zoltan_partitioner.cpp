#include <algorithm>

#include <fmt/format.h>
#include <zoltan.h>

#include <oncollide/runs/ranks/mpi_ranks.hpp>
#include <oncollide/runs/ranks/partitioner.hpp>

namespace oncollide {

namespace {

struct Points {
    std::span<const Eigen::Vector3d> points;
    std::span<const float> weights;
};

const Points& points_of(void* data)
{
    return *static_cast<const Points*>(data);
}

int count(void* data, int* error)
{
    *error = ZOLTAN_OK;
    return int(points_of(data).points.size());
}
void list(void* data, int, int, ZOLTAN_ID_PTR global, ZOLTAN_ID_PTR local, int weights, float* out, int* error)
{
    *error = ZOLTAN_OK;
    const Points& p = points_of(data);
    for (std::size_t i = 0; i < p.points.size(); ++i) {
        global[i] = local[i] = ZOLTAN_ID_TYPE(i); // bisection uses only the points
        if (weights) out[i] = p.weights[i];
    }
}
int dimensions(void*, int* error)
{
    *error = ZOLTAN_OK;
    return 3;
}
void coordinates(void* data, int, int, int number, ZOLTAN_ID_PTR, ZOLTAN_ID_PTR local, int, double* out, int* error)
{
    *error = ZOLTAN_OK;
    for (int i = 0; i < number; ++i) Eigen::Map<Eigen::Vector3d>(out + 3 * i) = points_of(data).points[local[i]];
}

void check(int error, const char* what)
{
    if (error != ZOLTAN_OK && error != ZOLTAN_WARN)
        throw Error(ErrorKind::internal, fmt::format("Zoltan: {} failed ({})", what, error));
}

class ZoltanPartitioner final : public Partitioner {
public:
    explicit ZoltanPartitioner(int size) : size_(size)
    {
        float version = 0;
        check(Zoltan_Initialize(0, nullptr, &version), "Zoltan_Initialize");
        zoltan_ = Zoltan_Create(mpi_communicator());
        if (!zoltan_) throw Error(ErrorKind::internal, "Zoltan: out of memory");
        // DEBUG_LEVEL first, because setting the method prints.
        for (const auto& [name, value] : {std::pair{"DEBUG_LEVEL", "0"},
                                          {"LB_METHOD", "RCB"},
                                          {"KEEP_CUTS", "1"},
                                          {"RETURN_LISTS", "NONE"},
                                          {"RCB_REUSE", "1"},
                                          {"NUM_GID_ENTRIES", "1"},
                                          {"NUM_LID_ENTRIES", "1"},
                                          {"OBJ_WEIGHT_DIM", "1"},
                                          {"IMBALANCE_TOL", "1.02"}})
            check(Zoltan_Set_Param(zoltan_, name, value), name);
        found_.resize(std::size_t(size));
    }
    ~ZoltanPartitioner() override { Zoltan_Destroy(&zoltan_); }
    ZoltanPartitioner(const ZoltanPartitioner&) = delete;

    std::string_view name() const override { return "zoltan"; }

    void rebuild(Ranks& ranks, std::span<const Eigen::Vector3d> points, std::span<const float> weights) override
    {
        std::uint64_t all = points.size();
        ranks.sum({&all, 1});
        // For a single part Zoltan stores no cuts, and its box would be empty.
        if (size_ == 1 || all == 0) return;
        Points here{points, weights};
        Zoltan_Set_Num_Obj_Fn(zoltan_, count, &here), Zoltan_Set_Obj_List_Fn(zoltan_, list, &here);
        Zoltan_Set_Num_Geom_Fn(zoltan_, dimensions, &here);
        Zoltan_Set_Geom_Multi_Fn(zoltan_, coordinates, &here);
        int changes = 0, global_entries = 0, local_entries = 0, imports = 0, exports = 0;
        ZOLTAN_ID_PTR import_global = nullptr, import_local = nullptr, export_global = nullptr, export_local = nullptr;
        int *import_ranks = nullptr, *import_parts = nullptr, *export_ranks = nullptr, *export_parts = nullptr;
        check(Zoltan_LB_Partition(zoltan_, &changes, &global_entries, &local_entries, &imports, &import_global,
                                  &import_local, &import_ranks, &import_parts, &exports, &export_global, &export_local,
                                  &export_ranks, &export_parts),
              "Zoltan_LB_Partition");
        Zoltan_LB_Free_Part(&import_global, &import_local, &import_ranks, &import_parts);
        Zoltan_LB_Free_Part(&export_global, &export_local, &export_ranks, &export_parts);
        cut_ = true;
    }

    int owner(const Eigen::Vector3d& point) const override
    {
        if (!cut_) return 0;
        Eigen::Vector3d p = point;
        int rank = 0;
        check(Zoltan_LB_Point_Assign(zoltan_, p.data(), &rank), "Zoltan_LB_Point_Assign");
        return rank;
    }

    /// Regions are open below and closed above, consistent with owner().
    void ranks(const Aabb& box, std::vector<int>& ranks) const override
    {
        ranks.assign(1, 0);
        if (!cut_) return;
        int number = 0;
        check(Zoltan_LB_Box_Assign(zoltan_, box.min.x(), box.min.y(), box.min.z(), box.max.x(), box.max.y(),
                                   box.max.z(), found_.data(), &number),
              "Zoltan_LB_Box_Assign");
        ranks.assign(found_.begin(), found_.begin() + number);
        std::ranges::sort(ranks);
    }

private:
    int size_;
    Zoltan_Struct* zoltan_ = nullptr;
    bool cut_ = false;
    mutable std::vector<int> found_; ///< room for all ranks
};

} // namespace

std::unique_ptr<Partitioner> make_zoltan_partitioner(const Ranks& ranks)
{
    return std::make_unique<ZoltanPartitioner>(ranks.size());
}

} // namespace oncollide

#include <algorithm>

#include <mpi.h>

#include <oncollide/runs/ranks/ranks.hpp>

namespace oncollide {

namespace {

constexpr int bytes_tag = 1, number_tag = 2;
constexpr std::size_t most_of_a_message = std::size_t{1} << 30; // because counts are ints

class MpiRanks final : public Ranks {
public:
    MpiRanks()
    {
        int level = 0;
        MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &level);
        MPI_Comm_rank(MPI_COMM_WORLD, &rank_), MPI_Comm_size(MPI_COMM_WORLD, &size_);
    }
    ~MpiRanks() override { MPI_Finalize(); }

    int rank() const override { return rank_; }
    int size() const override { return size_; }

    void exchange(std::span<const Bytes> out, std::vector<Bytes>& in) override
    {
        std::vector<std::uint64_t> sending, coming(std::size_t(size_), 0);
        for (const Bytes& bytes : out) sending.push_back(bytes.size());
        MPI_Alltoall(sending.data(), 1, MPI_UINT64_T, coming.data(), 1, MPI_UINT64_T, MPI_COMM_WORLD);
        in.resize(std::size_t(size_));
        std::vector<MPI_Request> requests;
        const auto pieces = [](std::size_t size, auto each) {
            for (std::size_t at = 0; at < size; at += most_of_a_message)
                each(at, int(std::min(size - at, most_of_a_message)));
        };
        for (int other = 0; other < size_; ++other) {
            Bytes& bytes = in[std::size_t(other)];
            bytes.resize(coming[std::size_t(other)]);
            if (other != rank_)
                pieces(bytes.size(), [&](std::size_t at, int count) {
                    MPI_Irecv(bytes.data() + at, count, MPI_BYTE, other, bytes_tag, MPI_COMM_WORLD,
                              &requests.emplace_back());
                });
        }
        for (int k = 0; k < size_; ++k) {
            const int other = (rank_ + k) % size_; // start with different receivers
            const Bytes& bytes = out[std::size_t(other)];
            if (other == rank_)
                in[std::size_t(other)] = bytes;
            else
                pieces(bytes.size(), [&](std::size_t at, int count) {
                    MPI_Isend(bytes.data() + at, count, MPI_BYTE, other, bytes_tag, MPI_COMM_WORLD,
                              &requests.emplace_back());
                });
        }
        MPI_Waitall(int(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
    }

    void gather(const Bytes& mine, std::vector<Bytes>& all) override
    {
        const std::vector<Bytes> out(std::size_t(size_), mine);
        exchange(out, all);
    }
    void sum(std::span<std::uint64_t> numbers) override
    {
        MPI_Allreduce(MPI_IN_PLACE, numbers.data(), int(numbers.size()), MPI_UINT64_T, MPI_SUM, MPI_COMM_WORLD);
    }
    void most(std::span<double> numbers) override
    {
        MPI_Allreduce(MPI_IN_PLACE, numbers.data(), int(numbers.size()), MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    }
    std::uint64_t before(std::uint64_t number) override
    {
        std::uint64_t sum = 0;
        MPI_Exscan(&number, &sum, 1, MPI_UINT64_T, MPI_SUM, MPI_COMM_WORLD);
        return rank_ == 0 ? 0 : sum;
    }
    void send(int to, std::uint64_t number) override
    {
        // A message this small is buffered, so the call does not wait for the receiver.
        MPI_Send(&number, 1, MPI_UINT64_T, to, number_tag, MPI_COMM_WORLD);
    }
    std::uint64_t receive(int from) override
    {
        std::uint64_t number = 0;
        MPI_Recv(&number, 1, MPI_UINT64_T, from, number_tag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
        return number;
    }
    void abort(int code) override { MPI_Abort(MPI_COMM_WORLD, code); }

private:
    int rank_ = 0, size_ = 1;
};

} // namespace

bool mpi_is_built()
{
    return true;
}

std::unique_ptr<Ranks> make_mpi_ranks()
{
    return std::make_unique<MpiRanks>();
}

} // namespace oncollide

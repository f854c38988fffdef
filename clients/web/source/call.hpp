// The functions that JavaScript calls. Each returns 0, or the kind of an error (ErrorKind), whose message oc_message()
// has. Arguments that are arrays lie in the input buffer, which JavaScript has filled; results are columns of doubles.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/base/error.hpp>

#define ONCOLLIDE_WEB extern "C" __attribute__((used, visibility("default")))

namespace oncollide::web {

/// Runs `work` and returns 0; keeps the message of an error that it throws, and returns the error's kind.
int answer(void (*work)(void*), void* context);

template <class Work>
int call(Work work)
{
    return answer([](void* context) { (*static_cast<Work*>(context))(); }, &work);
}

/// The columns of the last call, one after the other: column k begins at the sum of the widths before it times the
/// rows.
class Results {
public:
    /// Room for `rows` rows of `width` doubles each in all columns; returns where row 0 of the first column is.
    double* make(std::size_t rows, std::size_t width)
    {
        rows_ = rows;
        numbers_.resize(rows * width);
        return numbers_.data();
    }
    const double* data() const { return numbers_.data(); }
    std::size_t rows() const { return rows_; }

private:
    std::vector<double> numbers_;
    std::size_t rows_ = 0;
};

/// Results of the last call: 0 for the items, others where a call has several lists.
Results& results(std::size_t list = 0);

/// Writes rows into columns: columns of one number, and of three.
class ColumnWriter {
public:
    ColumnWriter(Results& to, std::size_t rows, std::size_t width) : at_(to.make(rows, width)), rows_(rows) {}
    /// The number of row `row` in the next column.
    void next(std::size_t row, double value) { at_[column_ * rows_ + row] = value, ++column_; }
    void next(std::size_t row, const Eigen::Vector3d& v)
    {
        double* const to = at_ + column_ * rows_ + 3 * row;
        to[0] = v.x(), to[1] = v.y(), to[2] = v.z();
        column_ += 3;
    }
    void end_row() { column_ = 0; }

private:
    double* at_;
    std::size_t rows_, column_ = 0;
};

/// Rigid matrices, 16 numbers each, column by column.
Eigen::Isometry3d pose_at(const double* poses, std::size_t index);
std::vector<Eigen::Isometry3d> poses_at(const double* poses, std::size_t count);

} // namespace oncollide::web

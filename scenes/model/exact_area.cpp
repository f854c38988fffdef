#include <oncollide/scenes/model/exact_area.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace oncollide {

namespace {

/// A sum of doubles without rounding: a nonoverlapping expansion, grown term by term. Source: Shewchuk, "Adaptive
/// precision floating-point arithmetic", 1997, Grow-Expansion.
class ExactSum {
public:
    void add(double term)
    {
        for (int i = 0; i < size_; ++i) {
            const double sum = term + parts_[i], virtual_part = sum - term;
            parts_[i] = (term - (sum - virtual_part)) + (parts_[i] - virtual_part);
            term = sum;
        }
        parts_[size_++] = term;
    }
    void add_product(double x, double y)
    {
        const double product = x * y;
        add(std::fma(x, y, -product)), add(product);
    }
    bool zero() const
    {
        return std::all_of(parts_.begin(), parts_.begin() + size_, [](double part) { return part == 0; });
    }

private:
    std::array<double, 12> parts_;
    int size_ = 0;
};

/// Sign test of the 2D orientation determinant of the projections to axes i, j.
bool in_line(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, int i, int j)
{
    ExactSum det;
    det.add_product(a[i], b[j]), det.add_product(-a[j], b[i]);
    det.add_product(b[i], c[j]), det.add_product(-b[j], c[i]);
    det.add_product(c[i], a[j]), det.add_product(-c[j], a[i]);
    return det.zero();
}

} // namespace

bool are_in_line(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c)
{
    // Scaling by a power of two moves the largest coordinate to about 2^500: products neither overflow nor lose low
    // bits.
    const double largest = std::max({a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff(), c.cwiseAbs().maxCoeff()});
    if (largest == 0) return true;
    const auto lift = [exponent = 500 - std::ilogb(largest)](const Eigen::Vector3d& p) -> Eigen::Vector3d {
        return p.unaryExpr([exponent](double x) { return std::ldexp(x, exponent); });
    };
    const Eigen::Vector3d p = lift(a), q = lift(b), r = lift(c);
    return in_line(p, q, r, 0, 1) && in_line(p, q, r, 1, 2) && in_line(p, q, r, 2, 0);
}

} // namespace oncollide

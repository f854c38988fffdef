#include "verify/oracle/exact_distance.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "truth/exact_oracle.hpp"
#include "truth/integers.hpp"

namespace oncollide::oracle {
namespace {

using Integer = boost::multiprecision::cpp_int;
using Place = PointOf<Integer>;

/// A fraction with a positive denominator.
struct Fraction {
    Integer top, bottom;
};
bool operator<(const Fraction& a, const Fraction& b)
{
    return a.top * b.bottom < b.top * a.bottom;
}

/// The exponent of the last bit of x that is set; large for 0.
int last_bit(double x)
{
    Digits digits;
    digits.take(x);
    return digits.lowest;
}

Fraction to_segment(const Place& p, const Place& a, const Place& b)
{
    const Place edge = b - a, from_a = p - a;
    const Integer length2 = dot(edge, edge), along = dot(edge, from_a);
    if (along <= 0) return {dot(from_a, from_a), 1};
    if (along >= length2) return {dot(p - b, p - b), 1};
    return {dot(from_a, from_a) * length2 - along * along, length2}; // Pythagoras
}

void take(Fraction& least, const Fraction& other)
{
    if (least.bottom == 0 || other < least) least = other;
}

/// The distance between inner points of two segments, where they have the nearest points of the lines.
void take_insides(Fraction& least, const Place& p, const Place& q, const Place& c, const Place& d)
{
    // Gram's determinants of the normal equations of the two lines' nearest points.
    const Place u = q - p, v = d - c, w = c - p;
    const Integer uu = dot(u, u), vv = dot(v, v), uv = dot(u, v), wu = dot(w, u), wv = dot(w, v);
    const Integer gram = uu * vv - uv * uv, s = wu * vv - wv * uv, t = wu * uv - wv * uu;
    if (gram <= 0 || s < 0 || s > gram || t < 0 || t > gram) return;
    const Integer volume = dot(w, cross(u, v));
    take(least, {volume * volume, gram});
}

void take_face(Fraction& least, const Place& p, const std::array<Place, 3>& t)
{
    const Place n = cross(t[1] - t[0], t[2] - t[0]);
    const Integer area2 = dot(n, n);
    if (area2 == 0) return;
    for (std::size_t k = 0; k < 3; ++k)
        if (dot(cross(t[(k + 1) % 3] - t[k], p - t[k]), n) < 0) return;
    const Integer height = dot(p - t[0], n);
    take(least, {height * height, area2});
}

} // namespace

struct ExactDistance::Square {
    Fraction value; ///< in units of 4^exponent
    int exponent;
    long double length = 0; ///< its root, rounded; a relative error below 2^-58

    template <std::size_t N>
    static int exponent_of(const std::array<Eigen::Vector3d, N>& a, const std::array<Eigen::Vector3d, N>& b)
    {
        Digits digits;
        digits.take(a), digits.take(b);
        return digits.count() > 0 ? digits.lowest : 0;
    }
    template <std::size_t N>
    static std::array<Place, N> places(const std::array<Eigen::Vector3d, N>& of, int exponent)
    {
        std::array<Place, N> places;
        for (std::size_t i = 0; i < N; ++i)
            for (int k = 0; k < 3; ++k) places[i][std::size_t(k)] = integer<Integer>(of[i][k], exponent);
        return places;
    }
    void round()
    {
        const auto& [top, bottom] = value;
        if (top == 0) return;
        const int shift = 128 + int(msb(bottom)) - int(msb(top)), even = shift + (shift & 1);
        const Integer scaled = even >= 0 ? Integer(top << even) / bottom : Integer(top / (bottom << -even));
        length = std::ldexp(std::sqrt(scaled.convert_to<long double>()), exponent - even / 2);
    }
};

ExactDistance::ExactDistance(const TrianglePoints& a, const TrianglePoints& b)
    : square_(new Square{{0, 1}, Square::exponent_of(a, b)})
{
    if (contact(a, b) != TriangleContact::separate) return;
    const auto p = Square::places(a, square_->exponent), q = Square::places(b, square_->exponent);
    Fraction least{0, 0};
    for (std::size_t i = 0; i < 3; ++i) {
        take_face(least, p[i], q), take_face(least, q[i], p);
        const Place &to_p = p[(i + 1) % 3], &to_q = q[(i + 1) % 3];
        for (std::size_t j = 0; j < 3; ++j) {
            take(least, to_segment(p[j], q[i], to_q)), take(least, to_segment(q[j], p[i], to_p));
            take_insides(least, p[i], to_p, q[j], q[(j + 1) % 3]);
        }
    }
    square_->value = least;
    square_->round();
}

ExactDistance::ExactDistance(const SegmentPoints& a, const SegmentPoints& b)
    : square_(new Square{{0, 0}, Square::exponent_of(a, b)})
{
    const auto p = Square::places(a, square_->exponent), q = Square::places(b, square_->exponent);
    for (std::size_t i = 0; i < 2; ++i)
        take(square_->value, to_segment(p[i], q[0], q[1])), take(square_->value, to_segment(q[i], p[0], p[1]));
    take_insides(square_->value, p[0], p[1], q[0], q[1]);
    square_->round();
}

ExactDistance::~ExactDistance() = default;
ExactDistance::ExactDistance(ExactDistance&&) noexcept = default;
ExactDistance& ExactDistance::operator=(ExactDistance&&) noexcept = default;

int ExactDistance::compare(double length) const
{
    const long double rounded = square_->length; // mostly decides
    if (length > rounded * (1 + 0x1p-50L)) return -1;
    if (length < rounded * (1 - 0x1p-50L)) return 1;
    const int finer = std::min(last_bit(length), square_->exponent), shift = 2 * (square_->exponent - finer);
    const Integer units = integer<Integer>(length, finer);
    const Integer distance2 = square_->value.top << shift, length2 = units * units * square_->value.bottom;
    return distance2 < length2 ? -1 : distance2 > length2;
}

long double ExactDistance::value() const
{
    return square_->length;
}

bool ExactDistance::operator<(const ExactDistance& other) const
{
    if (square_->length < other.square_->length * (1 - 0x1p-50L)) return true;
    if (square_->length > other.square_->length * (1 + 0x1p-50L)) return false;
    const int shift = 2 * (square_->exponent - other.square_->exponent);
    Fraction mine = square_->value, theirs = other.square_->value;
    (shift > 0 ? mine.top : theirs.top) <<= std::abs(shift);
    return mine < theirs;
}

ExactDistance least_distance(const TrianglePoints& triangle, std::span<const TrianglePoints> others)
{
    const auto box = [](const TrianglePoints& t) { return Eigen::AlignedBox3d(t[0]).extend(t[1]).extend(t[2]); };
    std::vector<std::pair<double, const TrianglePoints*>> nearest_box_first;
    for (const TrianglePoints& other : others)
        nearest_box_first.emplace_back(box(triangle).exteriorDistance(box(other)), &other);
    std::ranges::sort(nearest_box_first);
    ExactDistance least(triangle, *nearest_box_first.front().second);
    for (const auto& [apart, other] : nearest_box_first) {
        if (least.compare((1 - 0x1p-40) * apart) < 0) break;
        if (ExactDistance one(triangle, *other); one < least) least = std::move(one);
    }
    return least;
}

} // namespace oncollide::oracle

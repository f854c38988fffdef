#pragma once
#include <algorithm>
#include <functional>
#include <iterator>
#include <ranges>
#include <span>

// The constrained algorithms call the algorithms of namespace std. They take the arguments of C++20, and return the
// parts of the results that this project uses.
namespace std::ranges {

namespace oncollide_missing {

template <class R>
concept Range = requires(R& r)
{
    std::begin(r);
    std::end(r);
};

template <class R>
using Iterator = decltype(std::begin(std::declval<R&>()));

/// `compare` of the projections of two values.
template <class Compare, class Proj>
auto projected(Compare& compare, Proj& proj)
{
    return [&](auto&& a, auto&& b) -> bool {
        return std::invoke(compare, std::invoke(proj, std::forward<decltype(a)>(a)),
                           std::invoke(proj, std::forward<decltype(b)>(b)));
    };
}
template <class Test, class Proj>
auto projected_test(Test& test, Proj& proj)
{
    return [&](auto&& a) -> bool { return std::invoke(test, std::invoke(proj, std::forward<decltype(a)>(a))); };
}
template <class Value, class Proj>
auto equals(const Value& value, Proj& proj)
{
    return [&](auto&& a) -> bool { return std::invoke(proj, std::forward<decltype(a)>(a)) == value; };
}

template <class It>
struct Part {
    It first, last;
    It begin() const { return first; }
    It end() const { return last; }
    bool empty() const { return first == last; }
    auto size() const { return static_cast<std::size_t>(last - first); }
    auto data() const { return std::to_address(first); }
    decltype(auto) front() const { return *first; }
    decltype(auto) back() const { return last[-1]; }
    decltype(auto) operator[](std::ptrdiff_t i) const { return first[i]; }
};

template <class In, class Out>
struct InOut {
    In in;
    Out out;
};

} // namespace oncollide_missing

// Each algorithm for an iterator and its end, and for a range.
#define ONCOLLIDE_TEST(name)                                                                                           \
    template <class It, class Test, class Proj = identity>                                                             \
    requires(!oncollide_missing::Range<It>) auto name(It first, It last, Test test, Proj proj = {})                    \
    {                                                                                                                  \
        return std::name(first, last, oncollide_missing::projected_test(test, proj));                                  \
    }                                                                                                                  \
    template <oncollide_missing::Range R, class Test, class Proj = identity>                                           \
    auto name(R&& r, Test test, Proj proj = {})                                                                        \
    {                                                                                                                  \
        return std::name(std::begin(r), std::end(r), oncollide_missing::projected_test(test, proj));                   \
    }
ONCOLLIDE_TEST(any_of)
ONCOLLIDE_TEST(all_of)
ONCOLLIDE_TEST(none_of)
ONCOLLIDE_TEST(find_if)
ONCOLLIDE_TEST(count_if)
ONCOLLIDE_TEST(partition_point)
#undef ONCOLLIDE_TEST

#define ONCOLLIDE_EQUAL(name, by_test)                                                                                 \
    template <class It, class T, class Proj = identity>                                                                \
    requires(!oncollide_missing::Range<It>) auto name(It first, It last, const T& value, Proj proj = {})               \
    {                                                                                                                  \
        return std::by_test(first, last, oncollide_missing::equals(value, proj));                                      \
    }                                                                                                                  \
    template <oncollide_missing::Range R, class T, class Proj = identity>                                              \
    auto name(R&& r, const T& value, Proj proj = {})                                                                   \
    {                                                                                                                  \
        return std::by_test(std::begin(r), std::end(r), oncollide_missing::equals(value, proj));                       \
    }
ONCOLLIDE_EQUAL(find, find_if)
ONCOLLIDE_EQUAL(count, count_if)
#undef ONCOLLIDE_EQUAL

// With a comparison, by default `Default`.
#define ONCOLLIDE_COMPARE(name, Default)                                                                               \
    template <class It, class Compare = Default, class Proj = identity>                                                \
    requires(!oncollide_missing::Range<It>) auto name(It first, It last, Compare compare = {}, Proj proj = {})         \
    {                                                                                                                  \
        return std::name(first, last, oncollide_missing::projected(compare, proj));                                    \
    }                                                                                                                  \
    template <oncollide_missing::Range R, class Compare = Default, class Proj = identity>                              \
    auto name(R&& r, Compare compare = {}, Proj proj = {})                                                             \
    {                                                                                                                  \
        return std::name(std::begin(r), std::end(r), oncollide_missing::projected(compare, proj));                     \
    }
ONCOLLIDE_COMPARE(sort, less)
ONCOLLIDE_COMPARE(stable_sort, less)
ONCOLLIDE_COMPARE(is_sorted, less)
ONCOLLIDE_COMPARE(max_element, less)
ONCOLLIDE_COMPARE(min_element, less)
ONCOLLIDE_COMPARE(adjacent_find, equal_to)
ONCOLLIDE_COMPARE(push_heap, less)
ONCOLLIDE_COMPARE(pop_heap, less)
ONCOLLIDE_COMPARE(make_heap, less)
#undef ONCOLLIDE_COMPARE

template <oncollide_missing::Range R, class Compare = less, class Proj = identity>
auto nth_element(R&& r, oncollide_missing::Iterator<R> nth, Compare compare = {}, Proj proj = {})
{
    return std::nth_element(std::begin(r), nth, std::end(r), oncollide_missing::projected(compare, proj));
}

template <class It, class T, class Compare = less, class Proj = identity>
requires(!oncollide_missing::Range<It>) It
    lower_bound(It first, It last, const T& value, Compare compare = {}, Proj proj = {})
{
    return std::lower_bound(first, last, value, [&](auto&& a, const T& b) -> bool {
        return std::invoke(compare, std::invoke(proj, std::forward<decltype(a)>(a)), b);
    });
}
template <class It, class T, class Compare = less, class Proj = identity>
requires(!oncollide_missing::Range<It>) It
    upper_bound(It first, It last, const T& value, Compare compare = {}, Proj proj = {})
{
    return std::upper_bound(first, last, value, [&](const T& b, auto&& a) -> bool {
        return std::invoke(compare, b, std::invoke(proj, std::forward<decltype(a)>(a)));
    });
}
template <oncollide_missing::Range R, class T, class Compare = less, class Proj = identity>
auto lower_bound(R&& r, const T& value, Compare compare = {}, Proj proj = {})
{
    return ranges::lower_bound(std::begin(r), std::end(r), value, compare, proj);
}
template <oncollide_missing::Range R, class T, class Compare = less, class Proj = identity>
auto upper_bound(R&& r, const T& value, Compare compare = {}, Proj proj = {})
{
    return ranges::upper_bound(std::begin(r), std::end(r), value, compare, proj);
}
template <oncollide_missing::Range R, class T, class Compare = less, class Proj = identity>
auto equal_range(R&& r, const T& value, Compare compare = {}, Proj proj = {})
{
    return oncollide_missing::Part<oncollide_missing::Iterator<R>>{ranges::lower_bound(r, value, compare, proj),
                                                                   ranges::upper_bound(r, value, compare, proj)};
}
template <class It, class T, class Compare = less, class Proj = identity>
requires(!oncollide_missing::Range<It>) bool binary_search(It first, It last, const T& value, Compare compare = {},
                                                           Proj proj = {})
{
    const It at = ranges::lower_bound(first, last, value, compare, proj);
    return at != last && !std::invoke(compare, value, std::invoke(proj, *at));
}
template <oncollide_missing::Range R, class T, class Compare = less, class Proj = identity>
bool binary_search(R&& r, const T& value, Compare compare = {}, Proj proj = {})
{
    return ranges::binary_search(std::begin(r), std::end(r), value, compare, proj);
}

template <oncollide_missing::Range R, class Compare = less, class Proj = identity>
auto max(R&& r, Compare compare = {}, Proj proj = {})
{
    return *ranges::max_element(r, compare, proj);
}
template <oncollide_missing::Range R, class Compare = less, class Proj = identity>
auto min(R&& r, Compare compare = {}, Proj proj = {})
{
    return *ranges::min_element(r, compare, proj);
}

template <oncollide_missing::Range R>
auto reverse(R&& r)
{
    std::reverse(std::begin(r), std::end(r));
    return std::end(r);
}
template <class It>
requires(!oncollide_missing::Range<It>) void reverse(It first, It last)
{
    std::reverse(first, last);
}
template <oncollide_missing::Range R>
void rotate(R&& r, oncollide_missing::Iterator<R> middle)
{
    std::rotate(std::begin(r), middle, std::end(r));
}
template <oncollide_missing::Range R, class T>
auto fill(R&& r, const T& value)
{
    std::fill(std::begin(r), std::end(r), value);
    return std::end(r);
}
template <oncollide_missing::Range R, class T>
void replace(R&& r, const T& old, const T& value)
{
    std::replace(std::begin(r), std::end(r), old, value);
}
template <oncollide_missing::Range R>
auto unique(R&& r)
{
    return oncollide_missing::Part<oncollide_missing::Iterator<R>>{std::unique(std::begin(r), std::end(r)),
                                                                   std::end(r)};
}
template <oncollide_missing::Range R, class Function, class Proj = identity>
void for_each(R&& r, Function function, Proj proj = {})
{
    for (auto&& item : r) std::invoke(function, std::invoke(proj, item));
}

template <oncollide_missing::Range R, class Out>
auto copy(R&& r, Out out)
{
    return oncollide_missing::InOut<oncollide_missing::Iterator<R>, Out>{std::end(r),
                                                                         std::copy(std::begin(r), std::end(r), out)};
}
template <class It, class Out>
requires(!oncollide_missing::Range<It>) auto copy(It first, It last, Out out)
{
    return oncollide_missing::InOut<It, Out>{last, std::copy(first, last, out)};
}
template <oncollide_missing::Range R, class Out>
auto move(R&& r, Out out)
{
    return oncollide_missing::InOut<oncollide_missing::Iterator<R>, Out>{std::end(r),
                                                                         std::move(std::begin(r), std::end(r), out)};
}
template <oncollide_missing::Range R, class Out, class Function, class Proj = identity>
auto transform(R&& r, Out out, Function function, Proj proj = {})
{
    for (auto&& item : r) *out++ = std::invoke(function, std::invoke(proj, item));
    return oncollide_missing::InOut<oncollide_missing::Iterator<R>, Out>{std::end(r), out};
}
template <oncollide_missing::Range R, oncollide_missing::Range S, class Out, class Compare = less>
void merge(R&& r, S&& s, Out out, Compare compare = {})
{
    std::merge(std::begin(r), std::end(r), std::begin(s), std::end(s), out, compare);
}
template <oncollide_missing::Range R, oncollide_missing::Range S, class Compare = less>
bool includes(R&& r, S&& s, Compare compare = {})
{
    return std::includes(std::begin(r), std::end(r), std::begin(s), std::end(s), compare);
}
template <oncollide_missing::Range R, oncollide_missing::Range S>
auto find_first_of(R&& r, S&& s)
{
    return std::find_first_of(std::begin(r), std::end(r), std::begin(s), std::end(s));
}
template <oncollide_missing::Range R, oncollide_missing::Range S, class Same = equal_to>
bool equal(R&& r, S&& s, Same same = {})
{
    return std::equal(std::begin(r), std::end(r), std::begin(s), std::end(s), same);
}
template <oncollide_missing::Range R, oncollide_missing::Range S, class Compare = less>
bool lexicographical_compare(R&& r, S&& s, Compare compare = {})
{
    return std::lexicographical_compare(std::begin(r), std::end(r), std::begin(s), std::end(s), compare);
}

} // namespace std::ranges

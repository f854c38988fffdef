// The standard library of MinGW-w64 converts names of files from char to wchar_t by mbrtowc. The mbrtowc of its C
// library knows no UTF-8, even if the code page of the process is UTF-8. A program that links this file and the
// manifest beside it has UTF-8 names everywhere.
#include <cerrno>
#include <cwchar>
#include <string_view>

#include <oncollide/base/utf8.hpp>

/// The function of the C standard, always from UTF-8 to UTF-16. A code beyond 16 bits needs two calls: the call with
/// its first three bytes gives the first half, and the call with its last byte gives the second half, which `state`
/// holds meanwhile.
extern "C" std::size_t __cdecl mbrtowc(wchar_t* to, const char* from, std::size_t size, std::mbstate_t* state)
{
    static thread_local std::mbstate_t own = 0;
    if (!state) state = &own;
    constexpr std::size_t invalid = std::size_t(-1), incomplete = std::size_t(-2);
    if (!from) return *state = 0, 0;
    if (size == 0) return incomplete;
    if (*state) {
        if (to) *to = static_cast<wchar_t>(*state);
        return *state = 0, 1;
    }
    const auto [code, bytes] = oncollide::first_character({from, size});
    if (code == oncollide::Utf8Character::none) return errno = EILSEQ, invalid;
    if (code < 0x10000) {
        if (to) *to = static_cast<wchar_t>(code);
        return code ? bytes : 0;
    }
    if (to) *to = static_cast<wchar_t>(0xd7c0 + (code >> 10));
    *state = static_cast<std::mbstate_t>(0xdc00 + (code & 0x3ff));
    return bytes - 1;
}

#include <oncollide/scenes/files/xml/xml_reader.hpp>

#include <algorithm>
#include <exception>
#include <new>

#include <expat.h>
#include <fmt/format.h>

namespace oncollide {

namespace {

constexpr char separator = '\n'; // between a namespace and a name; names cannot contain it
constexpr std::size_t piece_bytes = std::size_t{1} << 20, most_tag_bytes = 4 * piece_bytes;

} // namespace

struct XmlReader::Parser {
    const MeshSource& source;
    XmlHandler& handler;
    XML_Parser expat = XML_ParserCreateNS(nullptr, separator);
    std::exception_ptr fault{}; ///< exceptions must not pass through C code
    int levels = 0;
    std::uint64_t bytes = 0;

    Parser(const MeshSource& s, XmlHandler& h) : source(s), handler(h)
    {
        if (!expat) throw std::bad_alloc();
        XML_SetUserData(expat, this);
        XML_SetElementHandler(expat, begin, end);
        XML_SetStartNamespaceDeclHandler(expat, name_space);
        XML_SetCharacterDataHandler(expat, text);
        XML_SetEntityDeclHandler(expat, entity);
    }
    ~Parser() { XML_ParserFree(expat); }
    Parser(const Parser&) = delete;
    Parser& operator=(const Parser&) = delete;

    std::size_t line() const { return XML_GetCurrentLineNumber(expat); }

    /// Runs one call of the handler.
    template <class Call>
    static void guarded(void* self, Call call)
    {
        Parser& parser = *static_cast<Parser*>(self);
        if (parser.fault) return;
        try {
            call(parser);
        } catch (...) {
            parser.fault = std::current_exception();
            XML_StopParser(parser.expat, XML_FALSE);
        }
    }

    static void begin(void* self, const char* name, const char** attributes)
    {
        guarded(self, [&](Parser& p) {
            if (++p.levels > most_levels)
                p.source.fail(fmt::format("elements are nested deeper than {} levels", most_levels), p.line());
            const std::string_view whole = name;
            const std::size_t at = whole.rfind(separator);
            const bool plain = at == whole.npos;
            p.handler.begin(
                {plain ? "" : whole.substr(0, at), plain ? whole : whole.substr(at + 1), attributes, p.line()});
        });
    }
    static void name_space(void* self, const char* prefix, const char* name)
    {
        guarded(self, [&](Parser& p) { p.handler.name_space(prefix ? prefix : "", name ? name : ""); });
    }
    static void end(void* self, const char*)
    {
        guarded(self, [](Parser& p) { --p.levels, p.handler.end(); });
    }
    static void text(void* self, const char* begin, int length)
    {
        guarded(self, [&](Parser& p) { p.handler.text({begin, static_cast<std::size_t>(length)}); });
    }
    static void entity(void* self, const char* name, int, const char*, int, const char*, const char*, const char*,
                       const char*)
    {
        guarded(self, [&](Parser& p) {
            p.source.fail(fmt::format("the entity {} is declared; such a file is not read", oncollide::quoted(name)),
                          p.line());
        });
    }

    void pass(std::string_view piece, bool last)
    {
        bytes += piece.size();
        const auto status = XML_Parse(expat, piece.data(), static_cast<int>(piece.size()), last);
        if (fault) std::rethrow_exception(fault);
        if (status == XML_STATUS_ERROR) {
            const XML_Error error = XML_GetErrorCode(expat);
            if (error == XML_ERROR_NO_MEMORY) throw std::bad_alloc();
            source.fail(fmt::format("not well-formed XML: {}", XML_ErrorString(error)), line());
        }
        // Expat scans an incomplete tag again with each piece, so its length must be limited.
        const auto at = static_cast<std::uint64_t>(XML_GetCurrentByteIndex(expat));
        if (!last && bytes - std::min(bytes, at) > most_tag_bytes)
            source.fail(fmt::format("a tag or comment is longer than {} bytes", most_tag_bytes), line());
    }
};

std::optional<std::string_view> XmlTag::operator[](std::string_view key) const
{
    for (const char** attribute = attributes; *attribute; attribute += 2)
        if (key == *attribute) return attribute[1];
    return {};
}

XmlReader::XmlReader(const MeshSource& source, XmlHandler& handler) : parser_(std::make_unique<Parser>(source, handler))
{
}

XmlReader::~XmlReader() = default;

void XmlReader::read(std::string_view piece)
{
    parser_->pass(piece, false);
}

void XmlReader::finish()
{
    parser_->pass({}, true);
}

void read_xml(const MeshSource& source, XmlHandler& handler)
{
    XmlReader reader(source, handler);
    ReadingProgress progress(source.name, source.bytes.size());
    for (std::size_t at = 0; at < source.bytes.size(); at += piece_bytes) {
        reader.read(source.bytes.substr(at, piece_bytes));
        progress.at(at);
    }
    reader.finish();
}

} // namespace oncollide

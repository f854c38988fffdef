#include <oncollide/base/text_sink.hpp>

#include <iterator>

namespace oncollide {

void TextSink::print_as(fmt::string_view format, fmt::format_args args)
{
    fmt::vformat_to(std::back_inserter(buffer_), format, args);
    if (buffer_.size() > most_) flush();
}

} // namespace oncollide

#include <oncollide/scenes/files/xml/xml_element.hpp>

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/scenes/files/xml/xml_reader.hpp>

namespace oncollide {

namespace {

class ElementTree : public XmlHandler {
public:
    ElementTree(const MeshSource& source, const std::function<bool(std::string_view, int)>& keep)
        : source_(source), keep_(keep),
          most_(std::clamp<std::size_t>(source.bytes.size() / bytes_each, least, std::size_t{10} * least))
    {
    }

    void begin(const XmlTag& tag) override
    {
        if (left_out_ > 0 || (!open_.empty() && !keep_(tag.name, static_cast<int>(open_.size())))) {
            ++left_out_;
            return;
        }
        if (++elements_ > most_)
            source_.fail(fmt::format("there are more than {} elements, too many for a file of its size", most_),
                         tag.line);
        XmlElement element{.name = std::string(tag.name), .line = tag.line};
        for (const char** attribute = tag.attributes; *attribute; attribute += 2)
            element.attributes.emplace_back(attribute[0], attribute[1]);
        open_.push_back(std::move(element));
    }

    void end() override
    {
        if (left_out_ > 0) {
            --left_out_;
            return;
        }
        XmlElement element = std::move(open_.back());
        open_.pop_back();
        (open_.empty() ? root : open_.back().children.emplace_back()) = std::move(element);
    }

    void text(std::string_view piece) override
    {
        if (left_out_ == 0) open_.back().text += piece;
    }

    XmlElement root{};

private:
    // An element takes more memory than its few letters in the file.
    static constexpr std::size_t least = 2'000'000, bytes_each = 24;

    const MeshSource& source_;
    const std::function<bool(std::string_view, int)>& keep_;
    const std::size_t most_;
    std::size_t elements_ = 0, left_out_ = 0;
    std::vector<XmlElement> open_; ///< from the root to the element being read
};

} // namespace

const std::string& XmlElement::attribute(std::string_view key) const
{
    static const std::string none;
    const auto found = std::ranges::find(attributes, key, &std::pair<std::string, std::string>::first);
    return found == attributes.end() ? none : found->second;
}

const XmlElement* XmlElement::find(std::string_view child) const
{
    const auto found = std::ranges::find(children, child, &XmlElement::name);
    return found == children.end() ? nullptr : &*found;
}

XmlElement read_xml_elements(const MeshSource& source, const std::function<bool(std::string_view, int)>& keep)
{
    ElementTree tree(source, keep);
    read_xml(source, tree);
    return std::move(tree.root);
}

} // namespace oncollide

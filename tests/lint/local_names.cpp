#include "tests/lint/local_names.h"

#include "tests/lint/text.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <utility>

namespace zoned::lint {

namespace {

bool is_identifier(std::string_view text) {
    return is_word_character(text.front()) &&
           std::isdigit(static_cast<unsigned char>(text.front())) == 0;
}

/// Reads the definitions that stand directly in anonymous namespaces.
class LocalNameReader {
  public:
    std::vector<LocalName> read(std::string_view text) {
        walk_braces(
            text, head_, [this] { open(); }, [this] { close(); }, [this] { end(); });
        return std::move(names_);
    }

  private:
    /// A namespace by its name, "" for an anonymous one; none: a body or an initialiser.
    using Scope = std::optional<std::string>;

    void open() {
        Scope scope = namespace_name();
        if (!scope && !head_.empty()) {
            define();
        }
        scopes_.push_back(std::move(scope));
    }

    void close() {
        if (!scopes_.empty()) {
            scopes_.pop_back();
        }
    }

    void end() {
        if (position("=") < head_.size()) {
            define();
        }
    }

    [[nodiscard]] Scope namespace_name() const {
        const std::size_t at = !head_.empty() && head_[0].text == "inline" ? 1 : 0;
        if (at >= head_.size() || head_[at].text != "namespace") {
            return std::nullopt;
        }
        return joined(at + 1, head_.size());
    }

    [[nodiscard]] std::string joined(std::size_t from, std::size_t to) const {
        std::string text;
        for (std::size_t i = from; i < to; ++i) {
            const bool words = !text.empty() && is_word_character(text.back()) &&
                               is_word_character(head_[i].text.front());
            text += (words ? " " : "") + std::string(head_[i].text);
        }
        return text;
    }

    /// Of the first such token; the number of tokens where there is none.
    [[nodiscard]] std::size_t position(std::string_view text) const {
        const auto at = std::find_if(
            head_.begin(), head_.end(), [text](const Token& token) { return token.text == text; });
        return static_cast<std::size_t>(at - head_.begin());
    }

    /// Past the bracket that closes the one at `from`.
    [[nodiscard]] std::size_t behind(std::size_t from,
                                     std::string_view opening,
                                     std::string_view closing) const {
        int depth = 0;
        for (std::size_t i = from; i < head_.size(); ++i) {
            depth += head_[i].text == opening ? 1 : head_[i].text == closing ? -1 : 0;
            if (depth == 0) {
                return i + 1;
            }
        }
        return head_.size();
    }

    /// Notes what the head defines, if it stands directly in an anonymous namespace.
    void define() {
        if (scopes_.empty() || scopes_.back() != "" || position("operator") < head_.size() ||
            std::find(scopes_.begin(), scopes_.end(), std::nullopt) != scopes_.end()) {
            return;
        }
        while (!head_.empty() && head_[0].text == "template") {
            head_.erase(head_.begin(),
                        head_.begin() + static_cast<std::ptrdiff_t>(behind(1, "<", ">")));
        }
        const std::size_t call = position("(");
        const std::size_t value = position("=");
        std::size_t at = std::min(value, head_.size());
        if (is_type()) {
            at = type_name();
        } else if (call < value) {
            at = call;
        }
        while (at > 0 && head_[at - 1].text == "]") {  // an array's length
            at = position_before(at - 1, "[");
        }
        if (at == 0 || at > head_.size() || !is_identifier(head_[at - 1].text) ||
            (at > 1 && head_[at - 2].text == ":")) {
            return;
        }
        std::string parameters;
        if (!is_type() && at == call && call < value) {
            parameters = joined(call, behind(call, "(", ")"));
        } else if (head_[0].text == "using" || head_[0].text == "namespace") {
            parameters = joined(value, head_.size());
        }
        names_.push_back(
            {scope(), std::string(head_[at - 1].text), std::move(parameters), head_[at - 1].line});
    }

    [[nodiscard]] std::size_t position_before(std::size_t at, std::string_view text) const {
        while (at > 0 && head_[at].text != text) {
            --at;
        }
        return at;
    }

    [[nodiscard]] bool is_type() const {
        return !head_.empty() &&
               (head_[0].text == "struct" || head_[0].text == "class" || head_[0].text == "enum" ||
                head_[0].text == "union") &&
               position("(") == head_.size();
    }

    /// Past the name of the type: before its bases, its `final` or its end.
    [[nodiscard]] std::size_t type_name() const {
        return std::min(position(":"), std::min(position("final"), head_.size()));
    }

    [[nodiscard]] std::string scope() const {
        std::string text;
        for (const Scope& scope : scopes_) {
            if (!scope->empty()) {
                text += (text.empty() ? "" : "::") + *scope;
            }
        }
        return text;
    }

    std::vector<Token> head_;  // what stands since the last brace or semicolon
    std::vector<Scope> scopes_;
    std::vector<LocalName> names_;
};

/// The library or program that compiles a source: two folders deep, test programs three.
std::string library_of(std::string_view path) {
    const bool deep = path.starts_with("tests/unit/") || path.starts_with("tests/integration/");
    std::size_t end = 0;
    for (int depth = 0; depth < (deep ? 3 : 2) && end != std::string_view::npos; ++depth) {
        end = path.find('/', end == 0 ? 0 : end + 1);
    }
    return std::string(path.substr(0, end));
}

struct Definition {
    std::string path;
    std::string parameters;
    int line = 0;
};

bool clash(const Definition& a, const Definition& b) {
    if (a.path == b.path) {
        return false;
    }
    if (a.parameters.starts_with('=') && b.parameters.starts_with('=')) {
        return a.parameters != b.parameters;  // an alias may be declared again
    }
    return a.parameters == b.parameters || !a.parameters.starts_with('(') ||
           !b.parameters.starts_with('(');
}

}  // namespace

std::vector<LocalName> local_names_of(std::string_view text) {
    return LocalNameReader().read(text);
}

std::vector<Finding> check_local_names(const std::vector<SourceFile>& files) {
    std::map<std::string, std::vector<Definition>> known;  // by library, namespace and name
    std::vector<Finding> findings;
    for (const SourceFile& file : files) {
        if (!file.path.ends_with(".cpp") || file.path.starts_with("tests/fuzz/")) {
            continue;  // fuzzers are programs of one source
        }
        const std::string library = library_of(file.path);
        for (const LocalName& local : local_names_of(file.text)) {
            std::vector<Definition>& others =
                known[library + " " + local.scope + "::" + local.name];
            const Definition here{file.path, local.parameters, local.line};
            const auto other = std::find_if(others.begin(), others.end(), [&](const auto& there) {
                return clash(here, there);
            });
            if (other != others.end()) {
                findings.push_back({file.path,
                                    local.line,
                                    local.name + " is also a local name of " + other->path + ":" +
                                        std::to_string(other->line)});
            }
            others.push_back(here);
        }
    }
    return findings;
}

}  // namespace zoned::lint

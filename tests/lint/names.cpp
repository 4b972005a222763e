#include "tests/lint/names.h"

#include "tests/lint/text.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>

namespace zoned::lint {

namespace {

/// Reads the scopes of a source: what each brace opens.
class TypeReader {
  public:
    std::vector<TypeDefinition> read(std::string_view text) {
        walk_braces(
            text, head_, [this] { open(); }, [this] { close(); }, [] {});
        return std::move(types_);
    }

  private:
    enum class Scope {
        kOpen,    // a namespace or a type: what stands in it counts
        kHidden,  // an anonymous namespace or a body
    };

    void open() {
        const bool hidden =
            std::find(scopes_.begin(), scopes_.end(), Scope::kHidden) != scopes_.end();
        Scope scope = Scope::kHidden;
        if (const auto name = namespace_name()) {
            scope = name->empty() ? Scope::kHidden : Scope::kOpen;
        } else if (const auto type = type_name()) {
            scope = Scope::kOpen;
            if (!hidden && !type->text.empty()) {
                types_.push_back({std::string(type->text), type->line});
            }
        }
        scopes_.push_back(scope);
    }

    void close() {
        if (!scopes_.empty()) {
            scopes_.pop_back();
        }
    }

    /// What stands behind `namespace`, empty for an anonymous one; none: the head is another.
    [[nodiscard]] std::optional<std::string_view> namespace_name() const {
        for (std::size_t i = 0; i < head_.size(); ++i) {
            if (head_[i].text == "namespace") {
                return i + 1 < head_.size() ? head_[i + 1].text : std::string_view();
            }
            if (head_[i].text != "inline") {
                break;
            }
        }
        return std::nullopt;
    }

    /// Past the parameters of a template that begin at `at`.
    [[nodiscard]] std::size_t behind_angles(std::size_t at) const {
        int depth = 0;
        for (std::size_t i = at; i < head_.size(); ++i) {
            depth += head_[i].text == "<" ? 1 : head_[i].text == ">" ? -1 : 0;
            if (depth == 0) {
                return i + 1;
            }
        }
        return head_.size();
    }

    /// The name of the type that the head defines, without text where it counts for nothing (a
    /// specialisation, a qualified or no name); none: the head is that of no type.
    [[nodiscard]] std::optional<Token> type_name() const {
        std::size_t i = 0;
        while (i < head_.size() && !is_key(head_[i].text)) {
            if (head_[i].text == "template") {
                i = behind_angles(i + 1);
            } else if (head_[i].text == "(" || head_[i].text == "=") {
                return std::nullopt;  // a function, or a value
            } else {
                ++i;  // public:, typedef, const, static, ...
            }
        }
        if (i == head_.size()) {
            return std::nullopt;
        }
        while (i < head_.size() &&
               (is_key(head_[i].text) || head_[i].text == "[" || head_[i].text == "alignas")) {
            i = behind_attribute(i);
        }
        if (i == head_.size() || head_[i].text == ":") {
            return Token{};  // has no name
        }
        const std::string_view next =
            i + 1 < head_.size() ? head_[i + 1].text : std::string_view(":");
        if (next == "<" || (next == ":" && i + 2 < head_.size() && head_[i + 2].text == ":")) {
            return Token{};
        }
        if (next == ":" || next == "final") {
            return head_[i];
        }
        return std::nullopt;  // `struct A make() {`
    }

    /// Past a keyword, or an attribute with its brackets.
    [[nodiscard]] std::size_t behind_attribute(std::size_t at) const {
        const std::string_view text = head_[at].text;
        if (is_key(text)) {
            return at + 1;
        }
        const std::string_view close = text == "[" ? "]" : ")";
        std::size_t i = at + 1;
        while (i < head_.size() && head_[i].text != close) {
            ++i;
        }
        while (i < head_.size() && head_[i].text == close) {
            ++i;
        }
        return i;
    }

    static bool is_key(std::string_view text) {
        return text == "class" || text == "struct" || text == "union" || text == "enum";
    }

    std::vector<Token> head_;  // what stands since the last brace or semicolon
    std::vector<Scope> scopes_;
    std::vector<TypeDefinition> types_;
};

struct Place {
    std::string path;
    int line = 0;
};

/// A finding for each name that stands at several places.
std::vector<Finding> repeated(const std::map<std::string, std::vector<Place>>& names,
                              std::span<const std::string_view> exceptions,
                              const std::string& kind) {
    std::vector<Finding> findings;
    for (const auto& [name, places] : names) {
        if (places.size() == 1 ||
            std::find(exceptions.begin(), exceptions.end(), name) != exceptions.end()) {
            continue;
        }
        std::string what =
            kind + " " + name + " occurs " + std::to_string(places.size()) + " times:";
        for (const Place& place : places) {
            what += " " + place.path + ":" + std::to_string(place.line);
        }
        findings.push_back({places.front().path, places.front().line, std::move(what)});
    }
    return findings;
}

/// Whether `some` stand among the words, one behind the other.
bool hold(const std::vector<std::string>& words, const std::vector<std::string>& some) {
    return std::search(words.begin(), words.end(), some.begin(), some.end()) != words.end();
}

bool is_named(std::string_view path) {
    static constexpr std::string_view kEndings[] = {".h", ".cpp", ".cl", ".proto", ".txtpb"};
    static constexpr std::string_view kFolders[] = {
        "server/", "client-sim/", "shared/", "kernels/", "proto/", "config/"};
    const auto begins = [path](std::string_view folder) {
        return path.starts_with(folder);
    };
    const auto ends = [path](std::string_view ending) {
        return path.ends_with(ending);
    };
    return std::any_of(std::begin(kFolders), std::end(kFolders), begins) &&
           std::any_of(std::begin(kEndings), std::end(kEndings), ends);
}

}  // namespace

std::vector<TypeDefinition> types_of(std::string_view text) {
    return TypeReader().read(text);
}

std::vector<Finding> check_header_names(const std::vector<SourceFile>& files,
                                        std::span<const std::string_view> exceptions) {
    std::map<std::string, std::vector<Place>> names;
    for (const SourceFile& file : files) {
        if (is_product(file.path) && file.path.ends_with(".h")) {
            names[std::string(name_of(file.path))].push_back({file.path, 1});
        }
    }
    return repeated(names, exceptions, "header");
}

std::vector<Finding> check_type_names(const std::vector<SourceFile>& files,
                                      std::span<const std::string_view> exceptions) {
    std::map<std::string, std::vector<Place>> names;
    for (const SourceFile& file : files) {
        if (is_product(file.path) && file.path.ends_with(".h")) {
            for (const TypeDefinition& type : types_of(file.text)) {
                names[type.name].push_back({file.path, type.line});
            }
        }
    }
    return repeated(names, exceptions, "type");
}

std::vector<std::string> words_of(std::string_view identifier) {
    std::vector<std::string> words;
    bool fresh = true;
    for (std::size_t i = 0; i < identifier.size(); ++i) {
        const auto c = static_cast<unsigned char>(identifier[i]);
        if (std::isalpha(c) == 0) {
            fresh = true;
            continue;
        }
        const bool upper = std::isupper(c) != 0;
        const bool after_lower =
            i > 0 && std::islower(static_cast<unsigned char>(identifier[i - 1])) != 0;
        const bool before_lower = i + 1 < identifier.size() &&
                                  std::islower(static_cast<unsigned char>(identifier[i + 1])) != 0;
        if (fresh || (upper && (after_lower || before_lower))) {
            words.emplace_back();
        }
        words.back() += static_cast<char>(std::tolower(c));
        fresh = false;
    }
    if (words.size() > 1 && words.front() == "k" && identifier.starts_with('k')) {
        words.erase(words.begin());
    }
    return words;
}

namespace {

/// A renamed word with its parts, and those of its exceptions.
struct SplitWord {
    explicit SplitWord(const RenamedWord& word) : renamed(&word), old(words_of(word.old)) {
        for (const std::string_view other : word.exceptions) {
            exceptions.push_back(words_of(other));
        }
    }

    const RenamedWord* renamed;
    std::vector<std::string> old;
    std::vector<std::vector<std::string>> exceptions;
};

std::vector<const RenamedWord*> renamed_in(const std::vector<std::string>& words,
                                           const std::vector<SplitWord>& renamed) {
    std::vector<const RenamedWord*> out;
    for (const SplitWord& word : renamed) {
        if (hold(words, word.old) &&
            std::none_of(word.exceptions.begin(), word.exceptions.end(), [&](const auto& other) {
                return hold(words, other);
            })) {
            out.push_back(word.renamed);
        }
    }
    return out;
}

}  // namespace

std::vector<Finding> check_renamed_words(const SourceFile& file,
                                         std::span<const RenamedWord> renamed) {
    std::vector<Finding> findings;
    if (!is_named(file.path)) {
        return findings;
    }
    std::vector<SplitWord> here;
    for (const RenamedWord& word : renamed) {
        if (file.path.starts_with(word.place)) {
            here.emplace_back(word);
        }
    }
    const std::string code = code_of(file.text, file.path.ends_with(".txtpb"));
    std::map<std::string_view, std::vector<const RenamedWord*>> seen;  // by identifier
    for (const Token& token : tokens_of(code)) {
        const auto [it, fresh] = seen.try_emplace(token.text);
        if (fresh) {
            it->second = renamed_in(words_of(token.text), here);
        }
        for (const RenamedWord* word : it->second) {
            findings.push_back({file.path,
                                token.line,
                                std::string(token.text) + ": '" + std::string(word->old) +
                                    "' is called " + std::string(word->now) + " here"});
        }
    }
    return findings;
}

}  // namespace zoned::lint

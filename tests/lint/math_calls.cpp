#include "tests/lint/math_calls.h"

#include "tests/lint/text.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <string_view>

namespace zoned::lint {

namespace {

constexpr std::array<std::string_view, 30> kInexact = {
    "sin",   "cos",   "tan",   "asin",  "acos",  "atan", "atan2", "sincos", "sinh",   "cosh",
    "tanh",  "asinh", "acosh", "atanh", "exp",   "exp2", "expm1", "exp10",  "log",    "log2",
    "log10", "log1p", "pow",   "powr",  "hypot", "cbrt", "erf",   "erfc",   "tgamma", "lgamma"};

/// Of Eigen: these call the C library themselves.
constexpr std::array<std::string_view, 7> kOfEigen =
    {"AngleAxis", "AngleAxisf", "AngleAxisd", "eulerAngles", "slerp", "angularDistance", "Random"};

/// Members of the same name as a function above that compute nothing: `config.log()`.
constexpr std::string_view kAccessor = "log";

/// Pages: people look at what is computed there, and it goes no further.
constexpr std::array<std::string_view, 2> kPages = {"server/admin/", "server/app/admin/"};

constexpr std::string_view kOwn = "shared/core/elementary/";

bool contains(const auto& names, std::string_view name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

/// Without the suffix of floats and long doubles, and without the prefix of built-in functions.
std::string_view plain(std::string_view name) {
    if (name.starts_with("__builtin_")) {
        name.remove_prefix(std::string_view("__builtin_").size());
    }
    if (!contains(kInexact, name) && (name.ends_with('f') || name.ends_with('l'))) {
        name.remove_suffix(1);
    }
    return name;
}

bool is_name(std::string_view token) {
    return !token.empty() && is_word_character(token.front()) &&
           std::isdigit(static_cast<unsigned char>(token.front())) == 0;
}

class Calls {
  public:
    explicit Calls(const std::vector<Token>& tokens) : tokens_(tokens) {}

    /// Whether token i is a call of an inexact function.
    [[nodiscard]] bool at(std::size_t i) const {
        if (contains(kOfEigen, tokens_[i].text)) {
            return before(i, 1) == ":" || before(i, 1) == ".";
        }
        const std::string_view name = plain(tokens_[i].text);
        if (!contains(kInexact, name) || after(i, 1) != "(") {
            return false;
        }
        if (before(i, 1) == ":") {
            // std::sin(x) and ::sin(x), but not Writer::log(line).
            return before(i, 3) == "std" || !is_name(before(i, 3));
        }
        const bool member = before(i, 1) == "." || (before(i, 1) == ">" && before(i, 2) == "-");
        if (member) {
            return after(i, 2) == ")" && name != kAccessor;
        }
        // Behind a type it is a declaration.
        return before(i, 1) == "return" || (name != kAccessor && !is_name(before(i, 1)));
    }

  private:
    [[nodiscard]] std::string_view before(std::size_t i, std::size_t by) const {
        return i >= by ? tokens_[i - by].text : std::string_view();
    }

    [[nodiscard]] std::string_view after(std::size_t i, std::size_t by) const {
        return i + by < tokens_.size() ? tokens_[i + by].text : std::string_view();
    }

    const std::vector<Token>& tokens_;
};

}  // namespace

std::vector<Finding> check_math_calls(const SourceFile& file) {
    const bool source = file.path.ends_with(".h") || file.path.ends_with(".cpp");
    const bool page = std::any_of(kPages.begin(), kPages.end(), [&](std::string_view folder) {
        return file.path.starts_with(folder);
    });
    if (!source || !is_product(file.path) || file.path.starts_with("kernels/") || page ||
        file.path.starts_with(kOwn)) {
        return {};
    }
    std::vector<Finding> findings;
    const std::string code = code_of(file.text);
    const std::vector<Token> tokens = tokens_of(code);
    const Calls calls(tokens);
    for (std::size_t i = 0; i < tokens.size(); ++i) {
        if (calls.at(i)) {
            findings.push_back({file.path,
                                tokens[i].line,
                                std::string(tokens[i].text) +
                                    " has other last bits in another library or on another "
                                    "processor: use shared/core/elementary/elementary.h"});
        }
    }
    return findings;
}

}  // namespace zoned::lint

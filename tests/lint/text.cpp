#include "tests/lint/text.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace zoned::lint {

namespace {

bool parse_include(std::string_view line, Include& include) {
    const auto skip_spaces = [&line] {
        while (!line.empty() && (line.front() == ' ' || line.front() == '\t')) {
            line.remove_prefix(1);
        }
    };
    skip_spaces();
    if (!line.starts_with('#')) {
        return false;
    }
    line.remove_prefix(1);
    skip_spaces();
    if (!line.starts_with("include")) {
        return false;
    }
    line.remove_prefix(7);
    skip_spaces();
    if (line.empty() || (line.front() != '"' && line.front() != '<')) {
        return false;
    }
    include.quoted = line.front() == '"';
    line.remove_prefix(1);
    const std::size_t end = line.find(include.quoted ? '"' : '>');
    if (end == std::string_view::npos) {
        return false;
    }
    include.target = line.substr(0, end);
    return true;
}

/// Blanks in place of all but line ends.
void blank(std::string& text, std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < std::min(to, text.size()); ++i) {
        text[i] = text[i] == '\n' ? '\n' : ' ';
    }
}

/// The end of the raw string whose R stands at `at`; `at` where there is none.
std::size_t raw_string_end(std::string_view text, std::size_t at) {
    const std::size_t open = text.find('(', at);
    if (text.substr(at, 2) != "R\"" || open == std::string_view::npos || open - at > 18) {
        return at;
    }
    const std::string close = ")" + std::string(text.substr(at + 2, open - at - 2)) + "\"";
    const std::size_t end = text.find(close, open);
    return end == std::string_view::npos ? text.size() : end + close.size();
}

/// The end of a string or character literal that begins at `at`.
std::size_t literal_end(std::string_view text, std::size_t at) {
    const char quote = text[at];
    std::size_t i = at + 1;
    while (i < text.size() && text[i] != quote && text[i] != '\n') {
        i += text[i] == '\\' ? 2 : 1;
    }
    return std::min(i + 1, text.size());
}

}  // namespace

std::vector<std::string_view> lines_of(std::string_view text) {
    std::vector<std::string_view> lines;
    while (!text.empty()) {
        const std::size_t end = text.find('\n');
        lines.push_back(text.substr(0, end));
        if (end == std::string_view::npos) {
            break;
        }
        text.remove_prefix(end + 1);
    }
    return lines;
}

std::vector<Include> includes_of(std::string_view text) {
    std::vector<Include> found;
    int number = 0;
    for (const std::string_view line : lines_of(text)) {
        Include include;
        include.line = ++number;
        if (parse_include(line, include)) {
            found.push_back(include);
        }
    }
    return found;
}

std::string code_of(std::string_view text, bool hash) {
    std::string code(text);
    std::size_t i = 0;
    while (i < text.size()) {
        const bool in_word = i > 0 && is_word_character(text[i - 1]);
        std::size_t end = i;
        if (hash ? text[i] == '#' : text.substr(i, 2) == "//") {
            end = std::min(text.find('\n', i), text.size());
            blank(code, i, end);
        } else if (!hash && text.substr(i, 2) == "/*") {
            end = text.find("*/", i + 2);
            end = end == std::string_view::npos ? text.size() : end + 2;
            blank(code, i, end);
        } else if (!in_word && raw_string_end(text, i) > i) {
            end = raw_string_end(text, i);
            blank(code, i + 1, end);
            code[i] = ' ';
        } else if (text[i] == '"' || (text[i] == '\'' && !in_word)) {
            end = literal_end(text, i);
            blank(code, i + 1, end - 1);
        }
        i = std::max(end, i + 1);
    }
    return code;
}

std::vector<Token> tokens_of(std::string_view code) {
    std::vector<Token> tokens;
    int number = 0;
    bool goes_on = false;  // a line of the preprocessor
    for (const std::string_view line : lines_of(code)) {
        ++number;
        const std::size_t first = line.find_first_not_of(" \t");
        const bool directive = goes_on || (first != std::string_view::npos && line[first] == '#');
        goes_on = directive && line.ends_with('\\');
        for (std::size_t i = 0; !directive && i < line.size();) {
            std::size_t end = i + 1;
            while (is_word_character(line[i]) && end < line.size() &&
                   is_word_character(line[end])) {
                ++end;
            }
            if (line[i] != ' ' && line[i] != '\t' && line[i] != '\r') {
                tokens.push_back({line.substr(i, end - i), number});
            }
            i = end;
        }
    }
    return tokens;
}

std::string_view opening_comment(std::string_view text) {
    std::size_t end = 0;
    for (const std::string_view line : lines_of(text)) {
        if (!line.starts_with("//")) {
            break;
        }
        end += line.size() + 1;
    }
    return text.substr(0, end);
}

std::string_view folder_of(std::string_view path) {
    const std::size_t slash = path.rfind('/');
    return slash == std::string_view::npos ? std::string_view() : path.substr(0, slash);
}

std::string_view name_of(std::string_view path) {
    return path.substr(path.rfind('/') + 1);
}

std::string_view stem_of(std::string_view path) {
    return path.substr(0, path.rfind('.'));
}

bool is_product(std::string_view path) {
    static constexpr std::array<std::string_view, 4> kFolders{
        "server/", "client-sim/", "shared/", "kernels/"};
    return (path.ends_with(".h") || path.ends_with(".cpp")) &&
           std::any_of(kFolders.begin(), kFolders.end(), [path](std::string_view folder) {
               return path.starts_with(folder);
           });
}

bool is_word_character(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

}  // namespace zoned::lint

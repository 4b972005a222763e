// Text of a source file: its lines, its include lines, and its code without comments and strings.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace zoned::lint {

/// Without their line ends.
[[nodiscard]] std::vector<std::string_view> lines_of(std::string_view text);

/// An #include line.
struct Include {
    std::string_view target;
    bool quoted = false;  ///< "target" rather than <target>
    int line = 0;         ///< counted from 1
};

[[nodiscard]] std::vector<Include> includes_of(std::string_view text);

/// The same text with blanks in place of comments and of what stands in string and character
/// literals, so that places stay what they are. `hash`: comments begin with # (text configs).
[[nodiscard]] std::string code_of(std::string_view text, bool hash = false);

/// An identifier, a number or one character.
struct Token {
    std::string_view text;
    int line = 0;  ///< counted from 1
};

/// Of code without comments and literals; lines of the preprocessor are left out.
[[nodiscard]] std::vector<Token> tokens_of(std::string_view code);

/// Walks through a source by its braces and semicolons: calls open() at a `{`, close() at a `}` and
/// end() at a `;`. Until each returns, `head` holds the tokens since the call before.
template <class Open, class Close, class End>
void walk_braces(std::string_view text, std::vector<Token>& head, Open open, Close close, End end) {
    const std::string code = code_of(text);
    for (const Token& token : tokens_of(code)) {
        if (token.text == "{") {
            open();
        } else if (token.text == "}") {
            close();
        } else if (token.text == ";") {
            end();
        } else {
            head.push_back(token);
            continue;
        }
        head.clear();
    }
    head.clear();
}

/// The comment that a file begins with; empty: it begins with something else.
[[nodiscard]] std::string_view opening_comment(std::string_view text);

/// The folder of a path, without the slash at its end; empty for a file of the root.
[[nodiscard]] std::string_view folder_of(std::string_view path);

/// The last part of a path.
[[nodiscard]] std::string_view name_of(std::string_view path);

/// A path without the ending of its name.
[[nodiscard]] std::string_view stem_of(std::string_view path);

/// Whether a path is that of a header or source of server, client-sim, shared or kernels.
[[nodiscard]] bool is_product(std::string_view path);

/// A letter, a digit or an underscore.
bool is_word_character(char c);

}  // namespace zoned::lint

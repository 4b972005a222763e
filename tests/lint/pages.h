// Pages: the sentences and tables of a Markdown page, and how long they may be.
#pragma once

#include "tests/lint/check.h"

#include <string_view>
#include <vector>

namespace zoned::lint {

/// A sentence by its words: runs of characters with a letter or a digit among them.
struct Sentence {
    int line = 0;  ///< where it begins, counted from 1
    int words = 0;
};

/// The sentences of a page's running text and lists: code blocks, tables, headings and comments are
/// left out. A sentence ends with a full stop, a question or exclamation mark before a blank, or
/// with its paragraph or list item.
[[nodiscard]] std::vector<Sentence> sentences_of(std::string_view text);

/// Limits of a page.
inline constexpr double kMostMeanWords = 20.0;   ///< in the mean of its sentences
inline constexpr int kMostWords = 40;            ///< in any sentence
inline constexpr std::size_t kMostInCell = 200;  ///< characters in a cell of a table

/// The page keeps the limits. Files that are no page (*.md) pass.
[[nodiscard]] std::vector<Finding> check_page(const SourceFile& file);

}  // namespace zoned::lint

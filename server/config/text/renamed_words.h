// renamed_words: the present names of settings and values that older configs call otherwise.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace zoned::config {

struct RenamedWord {
    std::string_view scope;  ///< full name of the message or enum that holds it
    std::string_view before;
    std::string_view now;
};

std::span<const RenamedWord> renamed_words();

/// Present name of a word of a message or enum (by full name); empty where the word was never
/// renamed.
std::string_view word_now(const std::string& scope, const std::string& before);

}  // namespace zoned::config

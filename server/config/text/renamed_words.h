// Renamed words: settings and values that configs of earlier versions know under another name.
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

/// What a word of a message or enum (by full name) is called now; empty where it has never had
/// another name.
std::string_view word_now(const std::string& scope, const std::string& before);

}  // namespace zoned::config

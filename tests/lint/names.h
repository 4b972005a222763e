// Names: headers and types of the product whose names occur once, and words that were renamed.
#pragma once

#include "tests/lint/check.h"
#include "tests/lint/vocabulary.h"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace zoned::lint {

/// A class, struct, union or enum where it is defined.
struct TypeDefinition {
    std::string name;
    int line = 0;  ///< counted from 1
};

/// The types that a text defines, nested ones too. Left out are those in functions and anonymous
/// namespaces, specialisations of templates, and definitions of what was declared elsewhere
/// (`struct A::B {`).
[[nodiscard]] std::vector<TypeDefinition> types_of(std::string_view text);

/// Each header of the product has a name of its own.
[[nodiscard]] std::vector<Finding> check_header_names(
    const std::vector<SourceFile>& files,
    std::span<const std::string_view> exceptions = kRepeatedHeaders);

/// Each type that a header of the product defines has a name of its own.
[[nodiscard]] std::vector<Finding> check_type_names(
    const std::vector<SourceFile>& files,
    std::span<const std::string_view> exceptions = kRepeatedTypes);

/// The words of an identifier: "kMaxWay_count" has max, way, count (k alone is no word).
[[nodiscard]] std::vector<std::string> words_of(std::string_view identifier);

/// No identifier of the product's code, protocols and configs contains a word that was renamed.
[[nodiscard]] std::vector<Finding> check_renamed_words(
    const SourceFile& file,
    std::span<const RenamedWord> renamed = kRenamedWords);

}  // namespace zoned::lint

// Local names: what sources keep to themselves in anonymous namespaces, and where two of a library
// agree by chance.
#pragma once

#include "tests/lint/check.h"

#include <string>
#include <string_view>
#include <vector>

namespace zoned::lint {

/// A name that an anonymous namespace defines.
struct LocalName {
    std::string scope;  ///< the namespaces around it, "zoned::physics"
    std::string name;
    std::string parameters;  ///< of a function, "(int a)"; of an alias, "=int"; empty for others
    int line = 0;            ///< counted from 1
};

/// Names that stand directly in anonymous namespaces. Declarations without a body are left out.
[[nodiscard]] std::vector<LocalName> local_names_of(std::string_view text);

/// A build that compiles several sources of a library as one (ZONED_UNITY) sees the anonymous
/// namespaces of all of them as one. No two sources of a library define the same name there.
/// Functions that differ in their parameters may share one, as may aliases of the same thing.
[[nodiscard]] std::vector<Finding> check_local_names(const std::vector<SourceFile>& files);

}  // namespace zoned::lint

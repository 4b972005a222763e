#include "shared/core/assert.h"

#include <cstdio>
#include <cstdlib>

namespace zoned::core {

void assertion_failed(const char* expression,
                      const char* reason,
                      const char* file,
                      int line) noexcept {
    std::fprintf(
        stderr, "zoned: broken expectation at %s:%d: %s (%s)\n", file, line, reason, expression);
    std::abort();
}

}  // namespace zoned::core

// ZONED_ASSERT: stops the process at a programming error, with place and reason, in every build
// type.
#pragma once

namespace zoned::core {

/// Prints the place and the broken expectation on standard error and aborts.
[[noreturn]] void assertion_failed(const char* expression,
                                   const char* reason,
                                   const char* file,
                                   int line) noexcept;

}  // namespace zoned::core

/// States a condition that the code relies on. Never use it for bytes from outside: they get a
/// Result.
#define ZONED_ASSERT(expression, reason) \
    (static_cast<bool>(expression)       \
         ? static_cast<void>(0)          \
         : ::zoned::core::assertion_failed(#expression, reason, __FILE__, __LINE__))

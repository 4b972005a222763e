// ZONED_ASSERT: a mistake of the programmer stops the process with place and reason, in every build
// type.
#pragma once

namespace zoned::core {

/// Prints the place and the broken expectation on standard error and aborts.
[[noreturn]] void assertion_failed(const char* expression,
                                   const char* reason,
                                   const char* file,
                                   int line) noexcept;

}  // namespace zoned::core

/// States what the code relies on. Never use it for bytes from outside: those get a Result.
#define ZONED_ASSERT(expression, reason) \
    (static_cast<bool>(expression)       \
         ? static_cast<void>(0)          \
         : ::zoned::core::assertion_failed(#expression, reason, __FILE__, __LINE__))

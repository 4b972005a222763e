// Secrets: unguessable numbers, comparison without a timing leak, keys as hexadecimal text.
#pragma once

#include "shared/core/result.h"
#include "shared/wire/seal.h"

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace zoned::session {

/// Fills `out` from the operating system's random source; throws std::runtime_error when there is
/// none.
void random_bytes(std::span<std::uint8_t> out);

/// A key that nobody has had before.
[[nodiscard]] wire::SealKey random_key();

/// A random number that is not zero.
[[nodiscard]] std::uint32_t random_nonzero_u32();

/// Takes the same time wherever the first difference lies. Different lengths are unequal at once.
[[nodiscard]] bool equal_in_constant_time(std::span<const std::uint8_t> a,
                                          std::span<const std::uint8_t> b);

/// The digest of a secret is an index for it: it says nothing about the secret, and so does the
/// timing of a look-up.
[[nodiscard]] std::array<std::uint8_t, 32> sha256(std::span<const std::uint8_t> bytes);

/// 32 bytes from 64 hexadecimal digits; white space around them is ignored.
[[nodiscard]] core::Result<std::array<std::uint8_t, 32>> parse_key_hex(std::string_view text);

}  // namespace zoned::session

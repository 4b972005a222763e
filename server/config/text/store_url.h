// store_url: what a URL of a PostgreSQL database may hold. Above all no password: configs are
// printed, logged and recorded.
#pragma once

#include <string>
#include <string_view>

namespace zoned::config {

/// The mistake in it, without a word of it; empty: none.
[[nodiscard]] std::string wrong_with_store_url(std::string_view url);

/// How one looks, and where the password belongs.
[[nodiscard]] std::string store_url_advice();

}  // namespace zoned::config

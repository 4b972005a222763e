// ClusterUrl: the addresses of NATS servers, which may hold secrets.
#pragma once

#include "shared/core/result.h"

#include <string>
#include <vector>

namespace zoned::cluster {

/// URLs from texts that each hold one or more with commas between:
/// nats://[USER:PASSWORD@]HOST:PORT, nats://TOKEN@HOST:PORT, or tls:// for an encrypted connection.
/// The error repeats no secret.
[[nodiscard]] core::Result<std::vector<std::string>> parse_cluster_urls(
    const std::vector<std::string>& texts);

/// The same without what stands before an '@': for logs.
[[nodiscard]] std::string without_secrets(const std::string& url);

}  // namespace zoned::cluster

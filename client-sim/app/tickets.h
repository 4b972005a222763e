// Tickets: reads login tickets from files.
#pragma once

#include <string>
#include <vector>

namespace zoned::app {

/// Serialised tickets from files and directories (their files in the order of names). A file holds
/// one ticket as bytes, or one per line in base64. Throws std::runtime_error naming the file that
/// cannot be read.
std::vector<std::string> read_tickets(const std::vector<std::string>& paths);

}  // namespace zoned::app

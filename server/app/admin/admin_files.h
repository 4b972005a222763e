// Admin files: what the admin server keeps in the state folder: token, address.
#pragma once

#include <cstdint>
#include <string>

namespace zoned::app {

/// The token of `folder`/admin.token; made on first use, 64 hexadecimal digits, mode 0600. Throws
/// std::runtime_error that names the file and the remedy, also where others may read the file.
std::string admin_token(const std::string& folder);

/// Random, 64 hexadecimal digits.
std::string new_admin_token();

/// Writes `folder`/admin.address, from which `zoned ctl` knows the port. Throws as above.
void write_admin_address(const std::string& folder, const std::string& address);

/// Copies the certificate that the admin server shows to `folder`/admin.certificate, so that `zoned
/// ctl` trusts it. Throws as above.
void write_admin_certificate(const std::string& folder, const std::string& certificate_file);

/// The text of a file, for files of this size at most; throws std::runtime_error.
std::string read_small_file(const std::string& path, std::size_t most_bytes);

}  // namespace zoned::app

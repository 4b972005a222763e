// Certificate: the server's TLS identity, from files or made on first start for development.
#pragma once

#include <asio/ssl/context.hpp>

#include <string>

namespace zoned::net {

struct CertificateSettings {
    std::string certificate_file;  ///< PEM chain; both empty: self-signed, kept in state_dir
    std::string key_file;          ///< PEM
    std::string state_dir = ".";   ///< for the self-signed pair; made when missing
};

/// Where the pair lies that will be used.
struct CertificateFiles {
    std::string certificate;
    std::string key;
    bool self_signed = false;
};

/// Finds the pair, or makes one: P-256 (FIPS 186-4), valid ten years, both files with mode 0600.
/// Throws std::runtime_error that names the file and the remedy.
[[nodiscard]] CertificateFiles prepare_certificate(const CertificateSettings& settings);

/// A server context, TLS 1.3 only, with this pair. Throws std::runtime_error: missing, unreadable,
/// no certificate, key does not match.
[[nodiscard]] asio::ssl::context make_server_context(const CertificateFiles& files);

/// SHA-256 over the DER form of the context's certificate, 64 lower-case hexadecimal digits.
/// Clients pin it.
[[nodiscard]] std::string certificate_fingerprint(asio::ssl::context& context);

}  // namespace zoned::net

// TlsSession: TLS 1.3 over a stream of sockets.
#pragma once

#include "client-sim/link/sockets/sockets.h"
#include "client-sim/link/trust.h"
#include "shared/core/foreign_handle.h"

#include <openssl/ssl.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace zoned::link {

/// Settings that all sessions of a network share.
class TlsContext {
  public:
    /// `ca_file` empty: the system's authorities. They are read where `verify` holds.
    TlsContext(bool verify, const std::string& ca_file);

    /// Why there can be no session; empty: all is well.
    [[nodiscard]] const std::string& trouble() const { return trouble_; }

    [[nodiscard]] SSL_CTX* get() const { return context_.get(); }

  private:
    core::Foreign<SSL_CTX, SSL_CTX_free> context_;
    std::string trouble_;
};

enum class TlsResult : std::uint8_t {
    kDone,
    kWaits,  ///< for the stream: again when it is ready
    kEnded,
    kFailed,  ///< trouble() says why
};

/// No call takes memory of ours while OpenSSL runs: it could not be left in the middle.
class TlsSession {
  public:
    TlsSession(const TlsContext& context, const Trust& trust, Sockets& sockets, int stream);

    /// Until it is done. It fails at a server that is not the trusted one.
    TlsResult shake_hands();
    /// `size` is how much came.
    TlsResult read(std::span<std::uint8_t> into, std::size_t& size);
    /// `size` is how much was taken.
    TlsResult write(std::span<const std::uint8_t> bytes, std::size_t& size);
    /// Tells the server that nothing more comes.
    void shut_down();

    [[nodiscard]] const std::string& trouble() const { return trouble_; }

    /// The stream, as OpenSSL's callbacks see it.
    struct Wire {
        Sockets* sockets = nullptr;
        int stream = 0;
        bool ended = false;
    };

  private:
    TlsResult result_of(int returned);
    [[nodiscard]] bool is_pinned() const;

    Trust trust_;
    Wire wire_;
    core::Foreign<SSL, SSL_free> ssl_;
    std::string trouble_;
};

}  // namespace zoned::link

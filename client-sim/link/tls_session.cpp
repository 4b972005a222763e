#include "client-sim/link/tls_session.h"

#include "client-sim/link/sockets/name_lookup.h"

#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/x509_vfy.h>

#include <algorithm>

namespace zoned::link {

namespace {

TlsSession::Wire& wire_of(BIO* bio) {
    return *static_cast<TlsSession::Wire*>(BIO_get_data(bio));
}

/// 0 of a stream is "not now" for OpenSSL.
int answer(BIO* bio, std::ptrdiff_t size, int again) {
    BIO_clear_retry_flags(bio);
    if (size > 0) {
        return static_cast<int>(size);
    }
    if (size == Sockets::kEnded) {
        wire_of(bio).ended = true;
        return 0;
    }
    if (size == 0) {
        BIO_set_flags(bio, again | BIO_FLAGS_SHOULD_RETRY);
    }
    return -1;
}

int write_bytes(BIO* bio, const char* bytes, int size) {
    const TlsSession::Wire& wire = wire_of(bio);
    const auto* const first = reinterpret_cast<const std::uint8_t*>(bytes);
    return answer(bio,
                  wire.sockets->send(wire.stream, {first, static_cast<std::size_t>(size)}),
                  BIO_FLAGS_WRITE);
}

int read_bytes(BIO* bio, char* bytes, int size) {
    const TlsSession::Wire& wire = wire_of(bio);
    auto* const first = reinterpret_cast<std::uint8_t*>(bytes);
    return answer(bio,
                  wire.sockets->receive(wire.stream, {first, static_cast<std::size_t>(size)}),
                  BIO_FLAGS_READ);
}

long control(BIO* bio, int command, long /*number*/, void* /*pointer*/) {
    switch (command) {
        case BIO_CTRL_EOF:
            return wire_of(bio).ended ? 1 : 0;
        case BIO_CTRL_FLUSH:
            return 1;
        default:
            return 0;
    }
}

/// One for the process; nullptr: no memory.
BIO_METHOD* wire_method() {
    static BIO_METHOD* const method = [] {
        BIO_METHOD* const made = BIO_meth_new(BIO_get_new_index() | BIO_TYPE_SOURCE_SINK, "zoned");
        if (made != nullptr) {
            BIO_meth_set_write(made, write_bytes);
            BIO_meth_set_read(made, read_bytes);
            BIO_meth_set_ctrl(made, control);
        }
        return made;
    }();
    return method;
}

/// OpenSSL's name for its newest trouble.
std::string reason_of(const SSL* ssl) {
    const unsigned long code = ERR_get_error();
    const char* const reason = ERR_reason_error_string(code);
    std::string text = reason != nullptr ? reason : "the stream was lost";
    if (const long verdict = SSL_get_verify_result(ssl); verdict != X509_V_OK) {
        text += std::string(": ") + X509_verify_cert_error_string(verdict);
    }
    return text;
}

}  // namespace

TlsContext::TlsContext(bool verify, const std::string& ca_file)
    : context_(SSL_CTX_new(TLS_client_method())) {
    SSL_CTX* const context = context_.get();
    if (context == nullptr) {
        trouble_ = "the TLS library does not start";
        return;
    }
    SSL_CTX_set_min_proto_version(context, TLS1_3_VERSION);
    // A stream that just ends is an end: frames have lengths, and a session has a goodbye.
    SSL_CTX_set_options(context, SSL_OP_IGNORE_UNEXPECTED_EOF);
    SSL_CTX_set_mode(context, SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
    if (!verify) {
        return;
    }
    ERR_clear_error();
    const int read = ca_file.empty() ? SSL_CTX_set_default_verify_paths(context)
                                     : SSL_CTX_load_verify_file(context, ca_file.c_str());
    if (read != 1) {
        const char* const reason = ERR_reason_error_string(ERR_get_error());
        trouble_ = "cannot read the certificate authorities" +
                   (ca_file.empty() ? std::string() : " in " + ca_file) + ": " +
                   (reason != nullptr ? reason : "unknown reason");
    }
}

TlsSession::TlsSession(const TlsContext& context, const Trust& trust, Sockets& sockets, int stream)
    : trust_(trust),
      wire_{&sockets, stream},
      ssl_(SSL_new(context.get())) {
    SSL* const ssl = ssl_.get();
    BIO* const bio = ssl != nullptr && wire_method() != nullptr ? BIO_new(wire_method()) : nullptr;
    if (bio == nullptr) {
        trouble_ = "the TLS library has no memory";
        return;
    }
    BIO_set_data(bio, &wire_);
    BIO_set_init(bio, 1);
    SSL_set_bio(ssl, bio, bio);
    SSL_set_connect_state(ssl);
    const bool is_name = !parse_address(trust.host);
    if (is_name) {
        // A server name is sent for names only, never for addresses (RFC 6066, section 3).
        SSL_set_tlsext_host_name(ssl, trust.host.c_str());
    }
    if (trust.kind == Trust::TrustKind::kVerify) {
        const char* const host = trust.host.c_str();
        const int set = is_name ? SSL_set1_host(ssl, host)
                                : X509_VERIFY_PARAM_set1_ip_asc(SSL_get0_param(ssl), host);
        SSL_set_verify(ssl, SSL_VERIFY_PEER, nullptr);
        if (set != 1 || trust.host.empty()) {
            trouble_ = "there is no name to verify";
        }
    }
}

/// After a call that did not succeed.
TlsResult TlsSession::result_of(int returned) {
    switch (SSL_get_error(ssl_.get(), returned)) {
        case SSL_ERROR_WANT_READ:
        case SSL_ERROR_WANT_WRITE:
            return TlsResult::kWaits;
        case SSL_ERROR_ZERO_RETURN:
            return TlsResult::kEnded;
        case SSL_ERROR_SYSCALL:
            trouble_ =
                wire_.ended ? "the server closed the stream" : wire_.sockets->trouble(wire_.stream);
            return TlsResult::kFailed;
        default:
            trouble_ = reason_of(ssl_.get());
            return TlsResult::kFailed;
    }
}

TlsResult TlsSession::shake_hands() {
    if (!trouble_.empty()) {
        return TlsResult::kFailed;
    }
    ERR_clear_error();
    const int done = SSL_do_handshake(ssl_.get());
    if (done != 1) {
        const TlsResult result = result_of(done);
        if (result == TlsResult::kEnded) {
            trouble_ = "the server closed the stream";
            return TlsResult::kFailed;
        }
        return result;
    }
    if (trust_.kind == Trust::TrustKind::kPin && !is_pinned()) {
        trouble_ = "the server's certificate is not the pinned one";
        return TlsResult::kFailed;
    }
    return TlsResult::kDone;
}

bool TlsSession::is_pinned() const {
    const X509* const certificate = SSL_get0_peer_certificate(ssl_.get());
    std::array<std::uint8_t, EVP_MAX_MD_SIZE> digest{};
    unsigned int size = 0;
    return certificate != nullptr &&
           X509_digest(certificate, EVP_sha256(), digest.data(), &size) == 1 &&
           size == trust_.pin.size() &&
           std::equal(trust_.pin.begin(), trust_.pin.end(), digest.begin());
}

TlsResult TlsSession::read(std::span<std::uint8_t> into, std::size_t& size) {
    ERR_clear_error();
    const int done = SSL_read_ex(ssl_.get(), into.data(), into.size(), &size);
    return done == 1 ? TlsResult::kDone : result_of(done);
}

TlsResult TlsSession::write(std::span<const std::uint8_t> bytes, std::size_t& size) {
    ERR_clear_error();
    const int done = SSL_write_ex(ssl_.get(), bytes.data(), bytes.size(), &size);
    return done == 1 ? TlsResult::kDone : result_of(done);
}

void TlsSession::shut_down() {
    ERR_clear_error();
    SSL_shutdown(ssl_.get());
}

}  // namespace zoned::link

#include "client-sim/link/frame_stream.h"

#include <openssl/evp.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <algorithm>
#include <array>
#include <utility>

namespace zoned::link {

namespace {

/// To be told before the handshake.
void prepare_trust(TlsSocket& stream, const Trust& trust) {
    if (trust.kind == Trust::TrustKind::kVerify) {
        stream.set_verify_mode(asio::ssl::verify_peer);
        stream.set_verify_callback(asio::ssl::host_name_verification(trust.host));
    } else {
        stream.set_verify_mode(asio::ssl::verify_none);
    }
    asio::error_code ignored;
    if (asio::ip::make_address(trust.host, ignored); ignored) {
        // A server name is sent for names only, never for addresses (RFC 6066, section 3).
        SSL_set_tlsext_host_name(stream.native_handle(), trust.host.c_str());
    }
}

/// Empty: after the handshake the certificate is the pinned one, or none is pinned.
std::string check_pin(TlsSocket& stream, const Trust& trust) {
    if (trust.kind != Trust::TrustKind::kPin) {
        return {};
    }
    const std::unique_ptr<X509, decltype(&X509_free)> certificate(
        SSL_get1_peer_certificate(stream.native_handle()), &X509_free);
    std::array<std::uint8_t, EVP_MAX_MD_SIZE> digest{};
    unsigned int size = 0;
    if (!certificate || X509_digest(certificate.get(), EVP_sha256(), digest.data(), &size) != 1 ||
        size != trust.pin.size() ||
        !std::equal(trust.pin.begin(), trust.pin.end(), digest.begin())) {
        return "the server's certificate is not the pinned one";
    }
    return {};
}

}  // namespace

SocketStream::SocketStream(asio::io_context& io,
                           asio::ssl::context& tls,
                           Trust trust,
                           StreamEvents events,
                           bool plain_at_home)
    : stream_(io, tls),
      trust_(std::move(trust)),
      events_(std::move(events)),
      plain_at_home_(plain_at_home) {
    prepare_trust(stream_, trust_);
}

void SocketStream::connect(const asio::ip::tcp::endpoint& endpoint) {
    plain_ = plain_at_home_ && endpoint.address().is_loopback();
    stream_.next_layer().async_connect(
        endpoint, [self = shared_from_this()](const asio::error_code& error) {
            if (error) {
                self->fail("cannot connect: " + error.message());
                return;
            }
            asio::error_code ignored;
            self->stream_.next_layer().set_option(asio::ip::tcp::no_delay(true), ignored);
            self->handshake();
        });
}

void SocketStream::handshake() {
    if (dead_) {
        return;
    }
    if (plain_) {
        open();
        return;
    }
    stream_.async_handshake(asio::ssl::stream_base::client,
                            [self = shared_from_this()](const asio::error_code& error) {
                                if (error) {
                                    self->fail("TLS handshake failed: " + error.message());
                                    return;
                                }
                                self->open();
                            });
}

void SocketStream::open() {
    if (dead_) {
        return;
    }
    if (const std::string wrong = plain_ ? "" : check_pin(stream_, trust_); !wrong.empty()) {
        fail(wrong);
        return;
    }
    open_ = true;
    on_open();
    if (!dead_) {
        read();
        write();
    }
}

void SocketStream::read() {
    const std::span<std::uint8_t> into = room();
    auto done = [self = shared_from_this()](const asio::error_code& error, std::size_t size) {
        if (self->dead_) {
            return;
        }
        if (error) {
            const bool orderly =
                error == asio::error::eof || error == asio::ssl::error::stream_truncated;
            self->fail(orderly ? std::string() : "stream failed: " + error.message());
            return;
        }
        self->on_bytes(size);
        if (!self->dead_) {
            self->read();
        }
    };
    if (plain_) {
        stream_.next_layer().async_read_some(asio::buffer(into.data(), into.size()),
                                             std::move(done));
    } else {
        stream_.async_read_some(asio::buffer(into.data(), into.size()), std::move(done));
    }
}

void SocketStream::write() {
    if (!open_ || dead_ || !writing_.empty()) {
        return;
    }
    if (pending_.empty()) {
        if (closing_) {
            finish();
        }
        return;
    }
    writing_.swap(pending_);
    auto done = [self = shared_from_this()](const asio::error_code& error, std::size_t) {
        self->writing_.clear();
        if (error) {
            self->fail("stream failed: " + error.message());
            return;
        }
        self->write();
    };
    if (plain_) {
        asio::async_write(stream_.next_layer(), asio::buffer(writing_), std::move(done));
    } else {
        asio::async_write(stream_, asio::buffer(writing_), std::move(done));
    }
}

void SocketStream::close() {
    if (dead_ || closing_) {
        return;
    }
    closing_ = true;
    events_ = {};
    if (!open_) {
        fail({});
        return;
    }
    say_goodbye();
    write();
}

void SocketStream::finish() {
    dead_ = true;
    if (plain_) {
        asio::error_code ignored;
        stream_.next_layer().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
        stream_.next_layer().close(ignored);
        return;
    }
    stream_.async_shutdown([self = shared_from_this()](const asio::error_code&) {
        asio::error_code ignored;
        self->stream_.next_layer().close(ignored);
    });
}

void SocketStream::fail(const std::string& reason) {
    if (dead_) {
        return;
    }
    dead_ = true;
    asio::error_code ignored;
    stream_.next_layer().close(ignored);
    // Moved out first: the listener may close or reopen from within the call.
    const auto closed = std::move(events_.closed);
    events_ = {};
    if (closed) {
        closed(reason);
    }
}

}  // namespace zoned::link

#include "client-sim/link/tls_stream.h"

#include <openssl/evp.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

namespace zoned::link {

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

TlsStream::TlsStream(asio::io_context& io,
                     asio::ssl::context& tls,
                     Trust trust,
                     StreamEvents events)
    : stream_(io, tls),
      trust_(std::move(trust)),
      events_(std::move(events)),
      input_(16384) {
    prepare_trust(stream_, trust_);
}

void TlsStream::connect(const asio::ip::tcp::endpoint& endpoint) {
    peer_ = endpoint.address();
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

void TlsStream::handshake() {
    if (dead_) {
        return;
    }
    stream_.async_handshake(asio::ssl::stream_base::client,
                            [self = shared_from_this()](const asio::error_code& error) {
                                if (error) {
                                    self->fail("TLS handshake failed: " + error.message());
                                    return;
                                }
                                self->on_open();
                            });
}

bool TlsStream::export_key(const char* label, wire::SealKey& key) {
    std::array<std::uint8_t, 28> material{};
    if (SSL_export_keying_material(stream_.native_handle(),
                                   material.data(),
                                   material.size(),
                                   label,
                                   std::strlen(label),
                                   nullptr,
                                   0,
                                   0) != 1) {
        return false;
    }
    std::copy_n(material.begin(), key.key.size(), key.key.begin());
    std::copy_n(material.begin() + key.key.size(), key.salt.size(), key.salt.begin());
    return true;
}

void TlsStream::on_open() {
    if (dead_) {
        return;
    }
    if (const std::string wrong = check_pin(stream_, trust_); !wrong.empty()) {
        fail(wrong);
        return;
    }
    wire::SealKey down;
    wire::SealKey up;
    if (!export_key(wire::kExporterLabelDown, down) || !export_key(wire::kExporterLabelUp, up)) {
        fail("the TLS library exported no keys");
        return;
    }
    open_ = true;
    read();
    if (events_.opened) {
        events_.opened(down, up);
    }
    write();
}

void TlsStream::read() {
    if (input_used_ == input_.size()) {
        input_.resize(std::min(input_.size() * 2, kMaxFrameBytes + 4));
    }
    stream_.async_read_some(
        asio::buffer(input_.data() + input_used_, input_.size() - input_used_),
        [self = shared_from_this()](const asio::error_code& error, std::size_t size) {
            if (self->dead_) {
                return;
            }
            if (error) {
                const bool orderly =
                    error == asio::error::eof || error == asio::ssl::error::stream_truncated;
                self->fail(orderly ? std::string() : "stream failed: " + error.message());
                return;
            }
            self->input_used_ += size;
            if (self->take_frames() && !self->dead_) {
                self->read();
            }
        });
}

bool TlsStream::take_frames() {
    std::size_t at = 0;
    while (input_used_ - at >= 4) {
        const std::uint8_t* head = input_.data() + at;
        const std::size_t size =
            static_cast<std::size_t>(head[0]) | static_cast<std::size_t>(head[1]) << 8 |
            static_cast<std::size_t>(head[2]) << 16 | static_cast<std::size_t>(head[3]) << 24;
        if (size > kMaxFrameBytes) {
            fail("the server sent a frame of " + std::to_string(size) + " bytes");
            return false;
        }
        if (input_used_ - at - 4 < size) {
            break;
        }
        if (events_.frame && !closing_) {
            events_.frame(Bytes(head + 4, head + 4 + size));
        }
        at += 4 + size;
    }
    std::copy(input_.begin() + static_cast<std::ptrdiff_t>(at),
              input_.begin() + static_cast<std::ptrdiff_t>(input_used_),
              input_.begin());
    input_used_ -= at;
    return true;
}

void TlsStream::send_frame(const Bytes& frame) {
    if (dead_ || closing_) {
        return;
    }
    const auto size = static_cast<std::uint32_t>(frame.size());
    for (int shift = 0; shift < 32; shift += 8) {
        pending_.push_back(static_cast<std::uint8_t>(size >> shift));
    }
    pending_.insert(pending_.end(), frame.begin(), frame.end());
    write();
}

void TlsStream::write() {
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
    asio::async_write(stream_,
                      asio::buffer(writing_),
                      [self = shared_from_this()](const asio::error_code& error, std::size_t) {
                          self->writing_.clear();
                          if (error) {
                              self->fail("stream failed: " + error.message());
                              return;
                          }
                          self->write();
                      });
}

void TlsStream::close() {
    if (dead_ || closing_) {
        return;
    }
    closing_ = true;
    events_ = {};
    if (!open_) {
        fail({});
        return;
    }
    write();
}

void TlsStream::finish() {
    dead_ = true;
    stream_.async_shutdown([self = shared_from_this()](const asio::error_code&) {
        asio::error_code ignored;
        self->stream_.next_layer().close(ignored);
    });
}

void TlsStream::fail(const std::string& reason) {
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

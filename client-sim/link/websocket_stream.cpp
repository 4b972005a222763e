#include "client-sim/link/websocket_stream.h"

#include "shared/wire/websocket/websocket_frames.h"
#include "shared/wire/websocket/websocket_upgrade.h"

#include <openssl/rand.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>
#include <vector>

namespace zoned::link {

namespace {

constexpr std::size_t kReadBytes = 16384;
constexpr std::array<std::uint8_t, 2> kNormalEnd = {1000 >> 8, 1000 & 0xFF};

class WebSocketStream final : public FrameStream,
                              public std::enable_shared_from_this<WebSocketStream> {
  public:
    WebSocketStream(asio::io_context& io, asio::ssl::context& tls, Trust trust, StreamEvents events)
        : stream_(io, tls),
          trust_(std::move(trust)),
          events_(std::move(events)),
          input_(kReadBytes),
          reader_(wire::WebSocketEnd::kClient, kMostFrameBytes) {
        prepare_trust(stream_, trust_);
    }

    void connect(const asio::ip::tcp::endpoint& endpoint) override;
    void send_frame(const Bytes& frame) override;
    void close() override;

  private:
    void on_connected();
    void send_upgrade();
    void read();
    void on_read(std::size_t size);
    void take_answer(std::span<const std::uint8_t> bytes);
    void take_messages(std::span<const std::uint8_t> bytes);
    void take_item(const wire::WebSocketItem& item);
    void append(wire::WebSocketOpcode opcode, std::span<const std::uint8_t> payload);
    void write();
    void finish();
    void fail(const std::string& reason);

    TlsSocket stream_;
    Trust trust_;
    StreamEvents events_;
    std::vector<std::uint8_t> input_;
    wire::WebSocketReader reader_;
    bool plain_ = false;
    std::string key_;     // of the request
    std::string answer_;  // to it, as far as it has come
    bool upgraded_ = false;
    std::uint32_t mask_ = 0;
    std::vector<std::uint8_t> pending_;
    std::vector<std::uint8_t> writing_;
    bool open_ = false;
    bool closing_ = false;
    bool dead_ = false;
};

void WebSocketStream::connect(const asio::ip::tcp::endpoint& endpoint) {
    plain_ = endpoint.address().is_loopback();
    stream_.next_layer().async_connect(endpoint,
                                       [self = shared_from_this()](const asio::error_code& error) {
                                           if (error) {
                                               self->fail("cannot connect: " + error.message());
                                           } else if (!self->dead_) {
                                               self->on_connected();
                                           }
                                       });
}

void WebSocketStream::on_connected() {
    asio::error_code ignored;
    stream_.next_layer().set_option(asio::ip::tcp::no_delay(true), ignored);
    if (plain_) {
        send_upgrade();
        return;
    }
    stream_.async_handshake(asio::ssl::stream_base::client,
                            [self = shared_from_this()](const asio::error_code& error) {
                                if (error) {
                                    self->fail("TLS handshake failed: " + error.message());
                                } else if (!self->dead_) {
                                    self->send_upgrade();
                                }
                            });
}

void WebSocketStream::send_upgrade() {
    if (const std::string wrong = plain_ ? "" : check_pin(stream_, trust_); !wrong.empty()) {
        fail(wrong);
        return;
    }
    std::array<unsigned char, 16> random{};
    RAND_bytes(random.data(), static_cast<int>(random.size()));
    std::memcpy(&mask_, random.data(), sizeof(mask_));
    key_ = wire::to_base64({reinterpret_cast<const char*>(random.data()), random.size()});
    const std::string request = wire::upgrade_request(trust_.host, key_);
    pending_.insert(pending_.begin(), request.begin(), request.end());
    open_ = true;
    read();
    write();
}

void WebSocketStream::read() {
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
        self->on_read(size);
    };
    if (plain_) {
        stream_.next_layer().async_read_some(asio::buffer(input_), std::move(done));
    } else {
        stream_.async_read_some(asio::buffer(input_), std::move(done));
    }
}

void WebSocketStream::on_read(std::size_t size) {
    const std::span<const std::uint8_t> bytes(input_.data(), size);
    if (upgraded_) {
        take_messages(bytes);
    } else {
        take_answer(bytes);
    }
    if (!dead_) {
        read();
    }
}

void WebSocketStream::take_answer(std::span<const std::uint8_t> bytes) {
    answer_.append(bytes.begin(), bytes.end());
    const std::size_t length = wire::upgrade_length(answer_);
    if (length == 0) {
        if (answer_.size() > wire::kMaxUpgradeBytes) {
            fail("the answer is no WebSocket's");
        }
        return;
    }
    if (const std::string wrong = wire::check_upgrade_answer(answer_.substr(0, length), key_);
        !wrong.empty()) {
        fail(wrong);
        return;
    }
    upgraded_ = true;
    const std::vector<std::uint8_t> rest(answer_.begin() + static_cast<std::ptrdiff_t>(length),
                                         answer_.end());
    answer_ = {};
    if (events_.opened_inside) {
        events_.opened_inside();
    }
    take_messages(rest);
}

void WebSocketStream::take_messages(std::span<const std::uint8_t> bytes) {
    wire::WebSocketItem item;
    while (!dead_ && reader_.next(bytes, item)) {
        take_item(item);
    }
    if (!dead_ && reader_.fault() != wire::WebSocketFault::kNone) {
        fail("the server's WebSocket makes no sense: " +
             std::string(wire::text_of(reader_.fault())));
    }
}

void WebSocketStream::take_item(const wire::WebSocketItem& item) {
    if (item.opcode == wire::WebSocketOpcode::kBinary) {
        if (events_.frame && !closing_) {
            events_.frame(Bytes(item.payload.begin(), item.payload.end()));
        }
    } else if (item.opcode == wire::WebSocketOpcode::kPing) {
        append(wire::WebSocketOpcode::kPong, item.payload);
    } else if (item.opcode == wire::WebSocketOpcode::kClose) {
        const auto code = item.payload.first(std::min(kNormalEnd.size(), item.payload.size()));
        const bool orderly =
            code.empty() ||
            std::equal(code.begin(), code.end(), kNormalEnd.begin(), kNormalEnd.end());
        const auto text = item.payload.subspan(code.size());
        fail(orderly ? std::string()
                     : "the server ended the WebSocket: " + std::string(text.begin(), text.end()));
    }
}

/// The mask guards proxies against scripts that choose bytes, and a bot is none of these.
void WebSocketStream::append(wire::WebSocketOpcode opcode, std::span<const std::uint8_t> payload) {
    wire::write_masked_frame(opcode, payload, ++mask_, pending_);
    write();
}

void WebSocketStream::send_frame(const Bytes& frame) {
    if (!dead_ && !closing_) {
        append(wire::WebSocketOpcode::kBinary, frame);
    }
}

void WebSocketStream::write() {
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

void WebSocketStream::close() {
    if (dead_ || closing_) {
        return;
    }
    closing_ = true;
    events_ = {};
    if (!open_) {
        fail({});
        return;
    }
    append(wire::WebSocketOpcode::kClose, kNormalEnd);
}

void WebSocketStream::finish() {
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

void WebSocketStream::fail(const std::string& reason) {
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

}  // namespace

std::shared_ptr<FrameStream> make_websocket_stream(asio::io_context& io,
                                                   asio::ssl::context& tls,
                                                   const Trust& trust,
                                                   StreamEvents events) {
    return std::make_shared<WebSocketStream>(io, tls, trust, std::move(events));
}

}  // namespace zoned::link

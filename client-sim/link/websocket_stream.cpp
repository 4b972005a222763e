// Frames as messages of a WebSocket.
#include "client-sim/link/frame_stream.h"
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

class WebSocketStream final : public SocketStream {
  public:
    WebSocketStream(const StreamWorld& world, Trust trust, StreamEvents events)
        : SocketStream(world, std::move(trust), std::move(events), true),
          input_(kReadBytes),
          reader_(wire::WebSocketEnd::kClient, kMostFrameBytes) {}

    void send_frame(const Bytes& frame) override;

  private:
    void on_open() override;

    std::span<std::uint8_t> room() override { return input_; }

    void on_bytes(std::size_t size) override;
    void say_goodbye() override;
    void take_answer(std::span<const std::uint8_t> bytes);
    void take_messages(std::span<const std::uint8_t> bytes);
    void take_item(const wire::WebSocketItem& item);
    void append(wire::WebSocketOpcode opcode, std::span<const std::uint8_t> payload);

    std::vector<std::uint8_t> input_;
    wire::WebSocketReader reader_;
    std::string key_;     // of the request
    std::string answer_;  // to it, as far as it has come
    bool upgraded_ = false;
    std::uint32_t mask_ = 0;
};

void WebSocketStream::on_open() {
    std::array<unsigned char, 16> random{};
    if (RAND_bytes(random.data(), static_cast<int>(random.size())) != 1) {
        fail("the TLS library has no random numbers");
        return;
    }
    std::memcpy(&mask_, random.data(), sizeof(mask_));
    key_ = wire::to_base64({reinterpret_cast<const char*>(random.data()), random.size()});
    const std::string request = wire::upgrade_request(trust_.host, key_);
    pending_.insert(pending_.begin(), request.begin(), request.end());
}

void WebSocketStream::on_bytes(std::size_t size) {
    const std::span<const std::uint8_t> bytes(input_.data(), size);
    if (upgraded_) {
        take_messages(bytes);
    } else {
        take_answer(bytes);
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
    if (events_.opened) {
        events_.opened(true);
    }
    take_messages(rest);
}

void WebSocketStream::take_messages(std::span<const std::uint8_t> bytes) {
    wire::WebSocketItem item;
    while (!dead() && reader_.next(bytes, item)) {
        take_item(item);
    }
    if (!dead() && reader_.fault() != wire::WebSocketFault::kNone) {
        fail("the server's WebSocket makes no sense: " +
             std::string(wire::text_of(reader_.fault())));
    }
}

void WebSocketStream::take_item(const wire::WebSocketItem& item) {
    if (item.opcode == wire::WebSocketOpcode::kBinary) {
        if (events_.frame) {
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
    if (!done()) {
        append(wire::WebSocketOpcode::kBinary, frame);
    }
}

void WebSocketStream::say_goodbye() {
    append(wire::WebSocketOpcode::kClose, kNormalEnd);
}

}  // namespace

std::shared_ptr<FrameStream> make_websocket_stream(const StreamWorld& world,
                                                   const Trust& trust,
                                                   StreamEvents events) {
    return std::make_shared<WebSocketStream>(world, trust, std::move(events));
}

}  // namespace zoned::link

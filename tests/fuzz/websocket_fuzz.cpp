// Fuzzing of WebSockets: any bytes, cut anywhere, give the same messages and the same fault, never
// more memory than a message may have; requests and answers are read or refused.
#include "tests/fuzz/fuzz.h"
#include "shared/wire/websocket/websocket_frames.h"
#include "shared/wire/websocket/websocket_upgrade.h"

#include <cstdlib>

namespace zoned::fuzz {

namespace {

constexpr std::size_t kMostBytes = 4096;

struct Heard {
    std::vector<Bytes> items;
    wire::WebSocketFault fault = wire::WebSocketFault::kNone;

    bool operator==(const Heard&) const = default;
};

Heard hear(wire::WebSocketEnd end, std::span<const std::uint8_t> bytes, std::size_t piece) {
    wire::WebSocketReader reader(end, kMostBytes);
    Heard heard;
    while (!bytes.empty()) {
        std::span<const std::uint8_t> part = bytes.first(std::min(piece, bytes.size()));
        bytes = bytes.subspan(part.size());
        wire::WebSocketItem item;
        while (reader.next(part, item)) {
            if (item.payload.size() > kMostBytes) {
                std::abort();
            }
            Bytes& kept = heard.items.emplace_back(item.payload.begin(), item.payload.end());
            kept.push_back(static_cast<std::uint8_t>(item.opcode));
        }
        if (!part.empty() && reader.fault() == wire::WebSocketFault::kNone) {
            std::abort();  // bytes were left without a reason
        }
    }
    heard.fault = reader.fault();
    return heard;
}

/// The bytes written for a message are read again.
void write_and_read(std::span<const std::uint8_t> payload) {
    Bytes out;
    wire::write_masked_frame(wire::WebSocketOpcode::kBinary, payload, 0x55AA33CC, out);
    const Heard heard = hear(wire::WebSocketEnd::kServer, out, 5);
    if (payload.size() <= kMostBytes &&
        (heard.items.size() != 1 || heard.items[0].size() != payload.size() + 1 ||
         !std::equal(payload.begin(), payload.end(), heard.items[0].begin()))) {
        std::abort();
    }
}

Bytes frame(const std::string& payload) {
    Bytes out;
    wire::write_masked_frame(
        wire::WebSocketOpcode::kBinary, Bytes(payload.begin(), payload.end()), 77, out);
    return out;
}

Bytes bytes_of(const std::string& text) {
    return {text.begin(), text.end()};
}

}  // namespace

std::vector<Bytes> seeds() {
    Bytes parts = {0x02, 0x83, 1, 2, 3, 4, 9, 9, 9, 0x89, 0x80, 0, 0, 0, 0, 0x80, 0x80, 4, 3, 2, 1};
    Bytes two = frame(std::string(300, 'a'));
    const Bytes more = frame("b");
    two.insert(two.end(), more.begin(), more.end());
    const std::string key = "dGhlIHNhbXBsZSBub25jZQ==";
    return {frame("hello"),
            two,
            parts,
            {0x82, 0x02, 'h', 'i', 0x88, 0x00},
            bytes_of(wire::upgrade_request("127.0.0.1:7780", key)),
            bytes_of(wire::upgrade_answer(key))};
}

}  // namespace zoned::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace zoned;
    const std::span<const std::uint8_t> bytes(data, size);
    for (const wire::WebSocketEnd end :
         {wire::WebSocketEnd::kServer, wire::WebSocketEnd::kClient}) {
        const fuzz::Heard whole = fuzz::hear(end, bytes, std::max<std::size_t>(1, size));
        if (whole != fuzz::hear(end, bytes, 1) || whole != fuzz::hear(end, bytes, 7)) {
            std::abort();
        }
    }
    fuzz::write_and_read(bytes);
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    if (const auto request = wire::read_upgrade_request(text)) {
        if (request->key.empty() || request->host.empty() ||
            !wire::check_upgrade_answer(wire::upgrade_answer(request->key), request->key).empty()) {
            std::abort();
        }
    } else if (request.error().status < 400 || request.error().text.empty()) {
        std::abort();
    }
    (void)wire::check_upgrade_answer(text, "dGhlIHNhbXBsZSBub25jZQ==");
    return 0;
}

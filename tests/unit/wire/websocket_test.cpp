// The bytes of WebSockets: what readers take, what they refuse, and the handshake of RFC 6455.
#include "shared/wire/websocket/websocket_frames.h"
#include "shared/wire/websocket/websocket_upgrade.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace zoned::wire {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kMost = 70000;

std::string text_of(std::span<const std::uint8_t> bytes) {
    return {bytes.begin(), bytes.end()};
}

Bytes bytes_of(const std::string& text) {
    return {text.begin(), text.end()};
}

struct Heard {
    std::vector<std::string> messages;
    std::vector<std::string> pings;
    WebSocketFault fault = WebSocketFault::kNone;
};

/// Gives a reader the bytes in pieces of this size.
Heard hear(WebSocketReader& reader, const Bytes& bytes, std::size_t piece) {
    Heard heard;
    for (std::size_t at = 0; at < bytes.size(); at += piece) {
        std::span<const std::uint8_t> part(bytes.data() + at, std::min(piece, bytes.size() - at));
        WebSocketItem item;
        while (reader.next(part, item)) {
            (item.opcode == WebSocketOpcode::kBinary ? heard.messages : heard.pings)
                .push_back(text_of(item.payload));
        }
    }
    heard.fault = reader.fault();
    return heard;
}

Bytes server_frame(std::uint8_t first, const std::string& payload) {
    std::array<std::uint8_t, kMaxWebSocketHead> head{};
    const std::size_t size = write_websocket_head(WebSocketOpcode::kBinary, payload.size(), head);
    head[0] = first;
    Bytes out(head.begin(), head.begin() + static_cast<std::ptrdiff_t>(size));
    out.insert(out.end(), payload.begin(), payload.end());
    return out;
}

Bytes operator+(Bytes a, const Bytes& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

TEST(WebSocketFrames, ComeOutAsTheyWentInHoweverTheyAreCut) {
    Bytes masked;
    Bytes plain;
    std::vector<std::string> sent;
    for (const std::size_t size : {0U, 1U, 125U, 126U, 127U, 65535U, 65536U, 66000U}) {
        std::string payload(size, 'x');
        for (std::size_t i = 0; i < size; ++i) {
            payload[i] = static_cast<char>('a' + (i * 7 + size) % 26);
        }
        sent.push_back(payload);
        write_masked_frame(WebSocketOpcode::kBinary, bytes_of(payload), 0x89ABCDEF, masked);
        plain = plain + server_frame(0x82, payload);
    }
    for (const std::size_t piece :
         {std::size_t{1}, std::size_t{3}, std::size_t{4097}, masked.size()}) {
        WebSocketReader server(WebSocketEnd::kServer, kMost);
        EXPECT_EQ(hear(server, masked, piece).messages, sent) << piece;
        WebSocketReader client(WebSocketEnd::kClient, kMost);
        EXPECT_EQ(hear(client, plain, piece).messages, sent) << piece;
    }
}

TEST(WebSocketFrames, PartsMakeOneMessageAndControlFramesMayStandBetween) {
    const Bytes bytes = server_frame(0x02, "one ") + server_frame(0x89, "ping") +
                        server_frame(0x00, "two ") + server_frame(0x80, "three") +
                        server_frame(0x82, "next");
    WebSocketReader reader(WebSocketEnd::kClient, kMost);
    const Heard heard = hear(reader, bytes, 2);
    EXPECT_EQ(heard.messages, (std::vector<std::string>{"one two three", "next"}));
    EXPECT_EQ(heard.pings, std::vector<std::string>{"ping"});
    EXPECT_EQ(heard.fault, WebSocketFault::kNone);
}

struct BadFrame {
    const char* name;
    WebSocketEnd end;
    Bytes bytes;
    WebSocketFault fault;
    std::uint16_t code;
};

class BadFrames : public ::testing::TestWithParam<BadFrame> {};

TEST_P(BadFrames, AreRefusedWithTheirReason) {
    for (const std::size_t piece : {std::size_t{1}, std::size_t{64}}) {
        WebSocketReader reader(GetParam().end, 1000);
        const Heard heard = hear(reader, GetParam().bytes, piece);
        EXPECT_EQ(heard.fault, GetParam().fault) << text_of(reader.fault());
        EXPECT_TRUE(heard.messages.empty());
        EXPECT_EQ(close_code_of(reader.fault()), GetParam().code);
        // Nothing more is read once a fault was found.
        EXPECT_TRUE(hear(reader, server_frame(0x82, "later"), 100).messages.empty());
    }
}

constexpr auto kFromServer = WebSocketEnd::kClient;
constexpr auto kFromClient = WebSocketEnd::kServer;

INSTANTIATE_TEST_SUITE_P(
    Rfc6455,
    BadFrames,
    ::testing::Values(
        BadFrame{"NoMask", kFromClient, {0x82, 0x01, 0x41}, WebSocketFault::kMask, 1002},
        BadFrame{"MaskOfAServer",
                 kFromServer,
                 {0x82, 0x81, 1, 2, 3, 4, 0x41},
                 WebSocketFault::kMask,
                 1002},
        BadFrame{"ReservedBit", kFromServer, {0xC2, 0x00}, WebSocketFault::kReserved, 1002},
        BadFrame{"Opcode3", kFromServer, {0x83, 0x00}, WebSocketFault::kReserved, 1002},
        BadFrame{"Opcode11", kFromServer, {0x8B, 0x00}, WebSocketFault::kReserved, 1002},
        BadFrame{"Text", kFromServer, {0x81, 0x01, 0x41}, WebSocketFault::kText, 1003},
        BadFrame{"LongPing", kFromServer, {0x89, 126, 0, 126}, WebSocketFault::kControl, 1002},
        BadFrame{"PingInParts", kFromServer, {0x09, 0x00}, WebSocketFault::kControl, 1002},
        BadFrame{"WideLength", kFromServer, {0x82, 126, 0, 125}, WebSocketFault::kLength, 1002},
        BadFrame{"WiderLength",
                 kFromServer,
                 {0x82, 127, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF},
                 WebSocketFault::kLength,
                 1002},
        BadFrame{"LengthOf2To63",
                 kFromServer,
                 {0x82, 127, 0x80, 0, 0, 0, 0, 0, 0, 0},
                 WebSocketFault::kLength,
                 1002},
        BadFrame{"HugeLength",
                 kFromServer,
                 {0x82, 127, 0x7F, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF},
                 WebSocketFault::kOversize,
                 1009},
        BadFrame{"OneTooMany",
                 kFromServer,
                 {0x82, 126, 0x03, 0xE9},
                 WebSocketFault::kOversize,
                 1009},
        BadFrame{
            "TooMuchInParts",
            kFromServer,
            server_frame(0x02, std::string(600, 'a')) + server_frame(0x80, std::string(600, 'b')),
            WebSocketFault::kOversize,
            1009},
        BadFrame{"NoBeginning", kFromServer, {0x80, 0x00}, WebSocketFault::kFragments, 1002},
        BadFrame{"TwoBeginnings",
                 kFromServer,
                 {0x02, 0x00, 0x82, 0x00},
                 WebSocketFault::kFragments,
                 1002}),
    [](const auto& bad) { return std::string(bad.param.name); });

TEST(WebSocketFrames, TooManyPartsAreRefused) {
    Bytes bytes = server_frame(0x02, "");
    for (std::size_t i = 1; i < WebSocketReader::kMostFragments; ++i) {
        bytes = bytes + server_frame(0x00, "");
    }
    WebSocketReader good(WebSocketEnd::kClient, kMost);
    EXPECT_EQ(hear(good, bytes, 7).fault, WebSocketFault::kNone);
    WebSocketReader bad(WebSocketEnd::kClient, kMost);
    EXPECT_EQ(hear(bad, bytes + server_frame(0x80, ""), 7).fault, WebSocketFault::kFragments);
}

std::string request(const std::string& without = "", const std::string& more = "") {
    std::string out = "GET / HTTP/1.1\r\n";
    for (const std::string line : {"Host: 127.0.0.1:7780",
                                   "Upgrade: websocket",
                                   "Connection: keep-alive, Upgrade",
                                   "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
                                   "Sec-WebSocket-Version: 13",
                                   "Sec-WebSocket-Protocol: chat, zoned"}) {
        if (without.empty() || !line.starts_with(without)) {
            out += line + "\r\n";
        }
    }
    return out + more + "\r\n";
}

TEST(WebSocketUpgrade, AnswersWithTheKeyOfTheStandardsExample) {
    const auto read = read_upgrade_request(request("", "Origin: https://play.example\r\n"));
    ASSERT_TRUE(read) << read.error().text;
    EXPECT_EQ(read->host, "127.0.0.1:7780");
    EXPECT_EQ(read->origin, "https://play.example");
    EXPECT_FALSE(read->forwarded);
    const std::string answer = upgrade_answer(read->key);
    EXPECT_THAT(answer,
                ::testing::HasSubstr("Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n"));
    EXPECT_EQ(check_upgrade_answer(answer, read->key), "");
    EXPECT_NE(check_upgrade_answer(answer, "x3JJHMbDL1EzLkh9GBhXDw=="), "");
    EXPECT_NE(check_upgrade_answer(refusal_answer({403, "origin", "no"}), read->key), "");
    EXPECT_TRUE(read_upgrade_request(upgrade_request("host:1", to_base64("0123456789abcdef"))));
    EXPECT_TRUE(read_upgrade_request(request("", "X-Forwarded-For: 10.0.0.1\r\n"))->forwarded);
    // An empty origin is one that nobody can list.
    EXPECT_EQ(read_upgrade_request(request("", "Origin: \r\n"))->origin, "null");
}

TEST(WebSocketUpgrade, RefusesWithStatusAndReason) {
    struct Case {
        std::string text;
        unsigned status;
        std::string_view reason;
    };

    const std::string good = request();
    const Case cases[] = {
        {"GET / HTTP/1.0\r\n\r\n", 400, "upgrade_malformed"},
        {"POST / HTTP/1.1\r\n\r\n", 405, "upgrade_method"},
        {"GET /else HTTP/1.1\r\n\r\n", 404, "upgrade_path"},
        {"GET / HTTP/1.1\r\nHost: a\r\n\r\n", 426, "upgrade_missing"},
        {request("Upgrade"), 426, "upgrade_missing"},
        {request("Connection"), 426, "upgrade_missing"},
        {request("Sec-WebSocket-Version"), 426, "upgrade_version"},
        {request("Sec-WebSocket-Version", "Sec-WebSocket-Version: 8\r\n"), 426, "upgrade_version"},
        {request("Sec-WebSocket-Key"), 400, "upgrade_malformed"},
        {request("Sec-WebSocket-Key", "Sec-WebSocket-Key: short\r\n"), 400, "upgrade_malformed"},
        {request("Host"), 400, "upgrade_malformed"},
        {request("", "Host: other\r\n"), 400, "upgrade_malformed"},
        {request("Sec-WebSocket-Protocol"), 400, "upgrade_protocol"},
        {request("", "Origin: https://a\r\nOrigin: https://b\r\n"), 400, "upgrade_malformed"},
        {request("", "no colon\r\n"), 400, "upgrade_malformed"},
        {request("", ": no name\r\n"), 400, "upgrade_malformed"},
        {request("", " folded: line\r\n"), 400, "upgrade_malformed"},
        {request("", std::string("Zero: \0\r\n", 9)), 400, "upgrade_malformed"},
        {request("", "Naked: \n\r\n"), 400, "upgrade_malformed"},
    };
    for (const Case& c : cases) {
        const auto read = read_upgrade_request(c.text);
        ASSERT_FALSE(read) << c.text;
        EXPECT_EQ(read.error().status, c.status) << c.text;
        EXPECT_EQ(read.error().reason, c.reason) << c.text;
        EXPECT_THAT(refusal_answer(read.error()),
                    ::testing::StartsWith("HTTP/1.1 " + std::to_string(c.status)));
    }
    std::string many = request();
    many.resize(many.size() - 2);
    for (int i = 0; i < 80; ++i) {
        many += "A" + std::to_string(i) + ": b\r\n";
    }
    EXPECT_FALSE(read_upgrade_request(many + "\r\n"));
    EXPECT_EQ(upgrade_length("GET / HTTP/1.1\r\nHost: a\r\n"), 0U);
    EXPECT_EQ(upgrade_length(good + "more"), good.size());
}

TEST(WebSocketUpgrade, Base64IsThatOfTheStandard) {
    EXPECT_EQ(to_base64(""), "");
    EXPECT_EQ(to_base64("f"), "Zg==");
    EXPECT_EQ(to_base64("fo"), "Zm8=");
    EXPECT_EQ(to_base64("foobar"), "Zm9vYmFy");
}

}  // namespace
}  // namespace zoned::wire

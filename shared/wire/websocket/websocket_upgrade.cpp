#include "shared/wire/websocket/websocket_upgrade.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace zoned::wire {

namespace {

constexpr std::string_view kGuid = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
constexpr std::string_view kLineEnd = "\r\n";
/// More lines than browsers send, by far.
constexpr std::size_t kMostLines = 64;
constexpr std::size_t kKeyLength = 24;

char lower(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

bool same_word(std::string_view a, std::string_view b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
        return lower(x) == lower(y);
    });
}

std::string_view trim(std::string_view text) {
    while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) {
        text.remove_prefix(1);
    }
    while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) {
        text.remove_suffix(1);
    }
    return text;
}

/// Whether a list with commas holds a word.
bool holds_word(std::string_view list, std::string_view word) {
    while (!list.empty()) {
        const std::size_t comma = std::min(list.find(','), list.size());
        if (same_word(trim(list.substr(0, comma)), word)) {
            return true;
        }
        list.remove_prefix(std::min(list.size(), comma + 1));
    }
    return false;
}

struct Header {
    std::string_view name;
    std::string_view value;
};

/// The first line and the headers; nothing where they are malformed.
struct Message {
    std::string_view first;
    std::vector<Header> headers;

    /// nullptr: it is missing, or there more than once.
    [[nodiscard]] const std::string_view* only(std::string_view name) const {
        const std::string_view* found = nullptr;
        for (const Header& header : headers) {
            if (same_word(header.name, name)) {
                if (found != nullptr) {
                    return nullptr;
                }
                found = &header.value;
            }
        }
        return found;
    }

    [[nodiscard]] bool has(std::string_view name) const {
        return std::ranges::any_of(
            headers, [&](const Header& header) { return same_word(header.name, name); });
    }
};

bool is_token(std::string_view text) {
    return !text.empty() && std::ranges::all_of(text, [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               c == '-' || c == '_';
    });
}

bool is_printable(std::string_view text) {
    return std::ranges::all_of(text, [](char c) { return c == '\t' || (c >= ' ' && c <= '~'); });
}

std::optional<Message> split(std::string_view text) {
    Message message;
    for (std::size_t line = 0;; ++line) {
        const std::size_t end = text.find(kLineEnd);
        if (end == std::string_view::npos || line > kMostLines) {
            return std::nullopt;
        }
        const std::string_view content = text.substr(0, end);
        text.remove_prefix(end + kLineEnd.size());
        if (content.empty() && line > 0) {
            return message;
        }
        if (!is_printable(content)) {
            return std::nullopt;
        }
        if (line == 0) {
            message.first = content;
            continue;
        }
        const std::size_t colon = content.find(':');
        if (colon == std::string_view::npos || !is_token(content.substr(0, colon))) {
            return std::nullopt;
        }
        message.headers.push_back({content.substr(0, colon), trim(content.substr(colon + 1))});
    }
}

std::string accept_of(std::string_view key) {
    const std::string text = std::string(key) + std::string(kGuid);
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned int size = 0;
    EVP_Digest(text.data(), text.size(), digest.data(), &size, EVP_sha1(), nullptr);
    return to_base64({reinterpret_cast<const char*>(digest.data()), size});
}

core::Result<UpgradeRequest, UpgradeRefusal> refuse(unsigned status,
                                                    std::string_view reason,
                                                    std::string_view text) {
    return core::Result<UpgradeRequest, UpgradeRefusal>::failure({status, reason, text});
}

}  // namespace

std::string to_base64(std::string_view bytes) {
    constexpr std::string_view kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t at = 0; at < bytes.size(); at += 3) {
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - at);
        std::uint32_t group = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            group = group << 8U | (i < count ? static_cast<unsigned char>(bytes[at + i]) : 0U);
        }
        for (std::size_t i = 0; i < 4; ++i) {
            out.push_back(i <= count ? kDigits[(group >> (18 - 6 * i)) & 63U] : '=');
        }
    }
    return out;
}

std::size_t upgrade_length(std::string_view bytes) {
    const std::size_t end = bytes.find("\r\n\r\n");
    return end == std::string_view::npos ? 0 : end + 4;
}

core::Result<UpgradeRequest, UpgradeRefusal> read_upgrade_request(std::string_view text) {
    const auto message = split(text);
    if (!message || !message->first.ends_with(" HTTP/1.1")) {
        return refuse(400, "upgrade_malformed", "this is no request of HTTP/1.1");
    }
    if (!message->first.starts_with("GET ")) {
        return refuse(405, "upgrade_method", "a WebSocket begins with GET");
    }
    if (message->first != "GET / HTTP/1.1") {
        return refuse(404, "upgrade_path", "the WebSocket of the game is at /");
    }
    const std::string_view* const upgrade = message->only("Upgrade");
    const std::string_view* const connection = message->only("Connection");
    if (upgrade == nullptr || !holds_word(*upgrade, "websocket") || connection == nullptr ||
        !holds_word(*connection, "upgrade")) {
        return refuse(426, "upgrade_missing", "this port speaks WebSocket alone (RFC 6455)");
    }
    const std::string_view* const version = message->only("Sec-WebSocket-Version");
    if (version == nullptr || *version != "13") {
        return refuse(426, "upgrade_version", "version 13 of WebSocket is wanted");
    }
    const std::string_view* const key = message->only("Sec-WebSocket-Key");
    const std::string_view* const host = message->only("Host");
    const std::string_view* const protocol = message->only("Sec-WebSocket-Protocol");
    if (key == nullptr || key->size() != kKeyLength || host == nullptr || host->empty()) {
        return refuse(400, "upgrade_malformed", "Host or Sec-WebSocket-Key is missing or wrong");
    }
    if (protocol == nullptr || !holds_word(*protocol, kWebSocketProtocol)) {
        return refuse(400, "upgrade_protocol", "the protocol 'zoned' must be asked for");
    }
    const std::string_view* const origin = message->only("Origin");
    if (origin == nullptr && message->has("Origin")) {
        return refuse(400, "upgrade_malformed", "Origin stands there twice");
    }
    UpgradeRequest request;
    request.host = *host;
    request.origin = origin != nullptr ? (origin->empty() ? "null" : std::string(*origin)) : "";
    request.key = *key;
    request.forwarded = message->has("Forwarded") || message->has("X-Forwarded-For");
    return request;
}

std::string upgrade_answer(const std::string& key) {
    return "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
           "Sec-WebSocket-Protocol: " +
           std::string(kWebSocketProtocol) + "\r\nSec-WebSocket-Accept: " + accept_of(key) +
           "\r\n\r\n";
}

std::string refusal_answer(const UpgradeRefusal& refusal) {
    const char* name = refusal.status == 403   ? "Forbidden"
                       : refusal.status == 404 ? "Not Found"
                       : refusal.status == 405 ? "Method Not Allowed"
                       : refusal.status == 426 ? "Upgrade Required"
                       : refusal.status == 431 ? "Request Header Fields Too Large"
                                               : "Bad Request";
    const std::string body = std::string(refusal.text) + "\n";
    return "HTTP/1.1 " + std::to_string(refusal.status) + " " + name +
           "\r\nConnection: close\r\nContent-Type: text/plain; charset=utf-8\r\n" +
           (refusal.status == 426 ? "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n" : "") +
           (refusal.status == 405 ? "Allow: GET\r\n" : "") +
           "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
}

std::string upgrade_request(const std::string& host, const std::string& key) {
    return "GET / HTTP/1.1\r\nHost: " + host +
           "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
           "Sec-WebSocket-Protocol: " +
           std::string(kWebSocketProtocol) + "\r\nSec-WebSocket-Key: " + key + "\r\n\r\n";
}

std::string check_upgrade_answer(std::string_view text, const std::string& key) {
    const auto message = split(text);
    if (!message || !message->first.starts_with("HTTP/1.1 ")) {
        return "the answer is not of HTTP/1.1";
    }
    if (!message->first.starts_with("HTTP/1.1 101")) {
        return "the server refuses the WebSocket: " + std::string(message->first.substr(9));
    }
    const std::string_view* const accept = message->only("Sec-WebSocket-Accept");
    const std::string_view* const protocol = message->only("Sec-WebSocket-Protocol");
    if (accept == nullptr || *accept != accept_of(key) || protocol == nullptr ||
        *protocol != kWebSocketProtocol) {
        return "the answer is not that of this game's WebSocket";
    }
    return {};
}

}  // namespace zoned::wire

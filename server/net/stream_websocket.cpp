// The WebSocket of a StreamConnection: its handshake, messages and control frames (RFC 6455).
#include "server/net/stream_connection.h"
#include "shared/wire/websocket/websocket_upgrade.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <utility>

namespace zoned::net {

namespace {

constexpr std::uint16_t kPolicy = 1008;

double steady_s() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

}  // namespace

void StreamConnection::count_refused(std::string_view reason) {
    auto& refused = events_->stats.websocket_refused;
    const auto it = refused.find(reason);
    if (it == refused.end()) {
        refused.emplace(reason, 1);
    } else {
        ++it->second;
    }
}

// ---------------------------------------------------------------- the handshake

void StreamConnection::read_upgrade() {
    if (filled_ == in_.size()) {
        in_.resize(std::min(2 * in_.size(), wire::kMaxUpgradeBytes));
    }
    reading_ = true;
    stream_.async_read_some(
        asio::buffer(in_.data() + filled_, in_.size() - filled_),
        [self = shared_from_this()](const asio::error_code& ec, std::size_t bytes) {
            self->on_upgrade_read(ec, bytes);
        });
}

void StreamConnection::on_upgrade_read(const asio::error_code& ec, std::size_t bytes) {
    reading_ = false;
    if (state_ != ConnectionState::kHandshake) {
        return;
    }
    if (ec) {
        count_refused("upgrade_missing");
        finish("the connection ended before its handshake");
        return;
    }
    events_->stats.bytes_in += bytes;
    filled_ += bytes;
    const std::string_view text(reinterpret_cast<const char*>(in_.data()), filled_);
    constexpr std::string_view kStart = "GET ";
    if (text.substr(0, kStart.size()) != kStart.substr(0, text.size())) {
        refuse_upgrade(405, "upgrade_method", "a WebSocket begins with GET");
    } else if (const std::size_t length = wire::upgrade_length(text); length > 0) {
        answer_upgrade(length);
    } else if (filled_ >= wire::kMaxUpgradeBytes) {
        refuse_upgrade(431, "upgrade_long", "the request is longer than 8192 bytes");
    } else {
        read_upgrade();
    }
}

void StreamConnection::answer_upgrade(std::size_t length) {
    const auto request =
        wire::read_upgrade_request({reinterpret_cast<const char*>(in_.data()), length});
    if (!request) {
        const wire::UpgradeRefusal& why = request.error();
        refuse_upgrade(why.status, why.reason, why.text);
        return;
    }
    if (!request->origin.empty() &&
        std::find(gate_->origins.begin(), gate_->origins.end(), request->origin) ==
            gate_->origins.end()) {
        refuse_upgrade(403,
                       "origin",
                       "pages of this site may not connect: network.websocket_origin does not "
                       "name it");
        return;
    }
    forwarded_ = request->forwarded;
    const std::string answer = wire::upgrade_answer(request->key);
    pending_.emplace_back();
    pending_.back().own.assign(answer.begin(), answer.end());
    queued_ += answer.size();
    reader_.emplace(wire::WebSocketEnd::kServer, limits_.max_frame_bytes);
    // Bytes behind the request are the client's first message already.
    std::copy(in_.begin() + static_cast<std::ptrdiff_t>(length),
              in_.begin() + static_cast<std::ptrdiff_t>(filled_),
              in_.begin());
    filled_ -= length;
    start_writing();
    open();
    if (state_ == ConnectionState::kOpen && take_messages()) {
        read();
    }
}

void StreamConnection::refuse_upgrade(unsigned status,
                                      std::string_view reason,
                                      std::string_view text) {
    count_refused(reason);
    const std::string answer = wire::refusal_answer({status, reason, text});
    pending_.emplace_back();
    pending_.back().own.assign(answer.begin(), answer.end());
    queued_ += answer.size();
    state_ = ConnectionState::kClosing;
    arm_deadline(limits_.close_timeout_s);
    start_writing();
}

// ---------------------------------------------------------------- messages

bool StreamConnection::take_messages() {
    std::span<const std::uint8_t> bytes(in_.data(), std::exchange(filled_, 0));
    wire::WebSocketItem item;
    while (reader_->next(bytes, item)) {
        if (!take_item(item)) {
            return false;
        }
    }
    if (reader_->fault() == wire::WebSocketFault::kNone) {
        return true;
    }
    const wire::WebSocketFault fault = reader_->fault();
    if (fault == wire::WebSocketFault::kOversize) {
        ++events_->stats.frame_oversize;
        close_websocket(wire::close_code_of(fault),
                        "message_oversize",
                        "a message of " + std::to_string(reader_->announced()) +
                            " bytes was announced; at most " +
                            std::to_string(limits_.max_frame_bytes) + " are taken");
    } else {
        close_websocket(wire::close_code_of(fault), "framing", wire::text_of(fault));
    }
    return false;
}

/// False: the connection is no longer open.
bool StreamConnection::take_item(const wire::WebSocketItem& item) {
    if (item.opcode == wire::WebSocketOpcode::kBinary) {
        if (events_->frame) {
            events_->frame(*this, item.payload);
        }
        return state_ == ConnectionState::kOpen;
    }
    if (item.opcode == wire::WebSocketOpcode::kClose) {
        close();  // the peer ended in order: answer in order
        return false;
    }
    if (!control_frames_.take(steady_s())) {
        close_websocket(kPolicy, "control_flood", "too many pings");
        return false;
    }
    if (item.opcode == wire::WebSocketOpcode::kPing) {
        append_control(wire::WebSocketOpcode::kPong, item.payload);
        start_writing();
    }
    return true;
}

void StreamConnection::append_control(wire::WebSocketOpcode opcode,
                                      std::span<const std::uint8_t> payload) {
    if (pending_.empty() || pending_.back().tail) {
        pending_.emplace_back();
    }
    std::vector<std::uint8_t>& own = pending_.back().own;
    std::array<std::uint8_t, wire::kMaxWebSocketHead> head{};
    const std::size_t size = wire::write_websocket_head(opcode, payload.size(), head);
    own.insert(own.end(), head.begin(), head.begin() + static_cast<std::ptrdiff_t>(size));
    own.insert(own.end(), payload.begin(), payload.end());
    queued_ += size + payload.size();
    start_writing();
}

void StreamConnection::close_websocket(std::uint16_t code,
                                       std::string_view reason,
                                       std::string_view text) {
    count_refused(reason);
    std::vector<std::uint8_t> payload = {static_cast<std::uint8_t>(code >> 8U),
                                         static_cast<std::uint8_t>(code & 0xFFU)};
    text = text.substr(0, wire::kMaxWebSocketControl - payload.size());
    payload.insert(payload.end(), text.begin(), text.end());
    close_sent_ = true;
    append_control(wire::WebSocketOpcode::kClose, payload);
    close();
}

}  // namespace zoned::net

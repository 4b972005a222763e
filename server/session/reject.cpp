#include "server/session/reject.h"

#include "shared/core/assert.h"

namespace zoned::session {

namespace {

constexpr std::array<const char*, static_cast<std::size_t>(Reject::kCount)> kNames = {
    "datagram_short",
    "datagram_long",
    "connection_unknown",
    "connection_foreign",
    "replayed",
    "not_authentic",
    "transport_malformed",
    "datagram_flood",
    "datagram_overtaken",
    "ack_ahead",
    "body_malformed",
    "input_range",
    "input_ahead",
    "input_late",
    "input_missed",
    "frame_oversize",
    "frame_malformed",
    "frame_empty",
    "frame_no_stream",
    "frame_flood",
    "hello_missing",
    "hello_again",
    "login_timeout",
    "login_malformed",
    "login_version",
    "login_digest",
    "login_ticket",
    "login_full",
    "login_busy",
    "login_address",
    "login_resume",
    "login_shutdown",
    "login_banned",
    "login_not_stored",
    "login_elsewhere",
    "command_gap",
    "command_duplicate",
    "command_flood",
    "command_kind",
    "command_size",
    "event_ack_ahead",
    "confirm_unknown",
    "view_reset_flood",
    "freeze_no_right",
    "audit_no_right",
    "audit_flood",
    "silence",
    "events_overflow",
    "out_no_session",
    "out_sequence",
    "out_oversize",
    "out_suspended",
    "out_tunnel_backlog",
    "out_unproved",
    "out_audit_no_right"};

// A reason without a name would be a null pointer at the end of the table.
static_assert(kNames.back() != nullptr);

}  // namespace

const char* reject_name(Reject reason) {
    ZONED_ASSERT(reason < Reject::kCount, "a reason outside the enumeration");
    return kNames[static_cast<std::size_t>(reason)];
}

std::map<std::string, std::uint64_t> RejectCounters::by_name() const {
    std::map<std::string, std::uint64_t> out;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
        if (counts_[i] != 0) {
            out.emplace(kNames[i], counts_[i]);
        }
    }
    return out;
}

}  // namespace zoned::session

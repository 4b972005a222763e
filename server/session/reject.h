// Reject: the reasons for a refusal and their counters, cheap enough to count a flood.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

namespace zoned::session {

/// The reason why a request from outside, or from the zones, was not carried out. Datagrams first,
/// then frames, then output.
enum class Reject : std::uint8_t {
    kDatagramShort,
    kDatagramLong,
    kConnectionUnknown,
    kConnectionForeign,  // another session's datagram inside a stream
    kReplayed,
    kNotAuthentic,
    kTransportMalformed,
    kDatagramFlood,
    kDatagramOvertaken,
    kAckAhead,
    kBodyMalformed,
    kInputRange,
    kInputAhead,
    kInputLate,
    kInputMissed,  // the step of its tick was over, by a few ticks at most
    kFrameOversize,
    kFrameMalformed,
    kFrameEmpty,
    kFrameNoStream,
    kFrameFlood,
    kHelloMissing,
    kHelloAgain,
    kLoginTimeout,
    kLoginMalformed,
    kLoginVersion,
    kLoginDigest,
    kLoginTicket,
    kLoginFull,
    kLoginBusy,
    kLoginAddress,
    kLoginResume,
    kLoginShutdown,
    kLoginBanned,
    kLoginNotStored,
    kLoginElsewhere,
    kCommandGap,
    kCommandDuplicate,
    kCommandFlood,
    kCommandKind,
    kCommandSize,
    kEventAckAhead,
    kConfirmUnknown,
    kViewResetFlood,
    kFreezeNoRight,
    kAuditNoRight,
    kAuditFlood,
    kSilence,
    kEventsOverflow,
    kOutNoSession,
    kOutSequence,
    kOutOversize,
    kOutSuspended,
    kOutTunnelBacklog,
    kOutUnproved,  // no stream, and the client has not shown yet that it receives at its address
    kOutAuditNoRight,
    kCount,
};

/// Name of a reason in reports and metrics, e.g. "not_authentic".
[[nodiscard]] const char* reject_name(Reject reason);

/// One counter per reason.
class RejectCounters {
  public:
    void count(Reject reason) { ++counts_[static_cast<std::size_t>(reason)]; }

    [[nodiscard]] std::uint64_t of(Reject reason) const {
        return counts_[static_cast<std::size_t>(reason)];
    }

    /// Reasons that occurred, by name.
    [[nodiscard]] std::map<std::string, std::uint64_t> by_name() const;

  private:
    std::array<std::uint64_t, static_cast<std::size_t>(Reject::kCount)> counts_{};
};

}  // namespace zoned::session

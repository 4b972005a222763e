// SessionFigures: what an operator may know of a session, as plain values that cross threads.
#pragma once

#include "server/mailbox/address.h"
#include "shared/core/ids.h"

#include <cstddef>
#include <cstdint>
#include <string>

namespace zoned::session {

struct SessionFigures {
    ClientId client;
    std::string account;
    std::string name;
    std::string team;
    mailbox::Address address;    ///< of the datagrams, else of the stream
    ZoneId zone;                 ///< where it joined; none before
    EntityId avatar;             ///< none before it joined
    bool connected = false;      ///< false: within its grace time
    bool udp = false;            ///< states go by UDP, not inside the stream
    double rtt_ms = 0.0;         ///< 0 before the first measurement
    std::uint64_t bytes_in = 0;  ///< datagrams, UDP payload, also those inside the stream
    std::uint64_t bytes_out = 0;
    double silent_s = 0.0;  ///< since the client was last heard
    std::size_t waiting_events = 0;
};

/// A client came, went or was refused: for the log.
struct SessionNote {
    enum class Kind : std::uint8_t {
        kJoined,
        kResumed,  ///< came back within the grace time
        kAway,     ///< its stream ended; the grace time runs
        kLeft,     ///< for good
        kRefused,  ///< was not let in
    };

    Kind kind = Kind::kJoined;
    ClientId client;  ///< none where it was refused
    std::string account;
    std::string name;
    mailbox::Address from;
    std::uint32_t rights = 0;
    std::string text;  ///< the reason, for all but the first two kinds
};

}  // namespace zoned::session

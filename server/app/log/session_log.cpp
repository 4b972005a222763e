#include "server/app/log/session_log.h"

#include "server/app/log/log.h"
#include "server/mailbox/messages.h"
#include "server/net/socket_address.h"
#include "server/session/login/display_names.h"

#include <array>
#include <utility>

namespace zoned::app {

namespace {

constexpr std::size_t kMostText = 256;

/// "client 5 (account ann, name Ann) of 10.0.0.1:4711"; names come from outside.
std::string client_text(const session::SessionNote& note) {
    return fmt::format("client {} (account {}, name {}) of {}",
                       note.client.value,
                       session::printable(note.account),
                       session::printable(note.name),
                       net::text_of(note.from));
}

}  // namespace

std::string rights_text(std::uint32_t rights) {
    static constexpr std::array<std::pair<std::uint32_t, const char*>, 4> kNames{
        {{mailbox::kRightPlay, "PLAY"},
         {mailbox::kRightAudit, "AUDIT"},
         {mailbox::kRightFreeze, "FREEZE"},
         {mailbox::kRightAdmin, "ADMIN"}}};
    std::string out;
    for (const auto& [bit, name] : kNames) {
        if ((rights & bit) != 0) {
            out += (out.empty() ? "" : ", ") + std::string(name);
        }
    }
    return out.empty() ? "none" : out;
}

void log_session(const session::SessionNote& note) {
    using Kind = session::SessionNote::Kind;
    spdlog::logger& log = log_of(LogArea::kSession);
    switch (note.kind) {
        case Kind::kJoined:
            log.info("{} joined, rights {}", client_text(note), rights_text(note.rights));
            return;
        case Kind::kResumed:
            log.info("{} came back", client_text(note));
            return;
        case Kind::kAway:
            log.info("{} is away, its grace time runs: {}",
                     client_text(note),
                     session::printable(note.text, kMostText));
            return;
        case Kind::kLeft:
            log.info("{} left: {}", client_text(note), session::printable(note.text, kMostText));
            return;
        case Kind::kRefused:
            log.warn("a login from {} was refused: {}",
                     net::text_of(note.from),
                     session::printable(note.text, kMostText));
            return;
    }
}

}  // namespace zoned::app

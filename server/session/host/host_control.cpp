// An operator asks the sessions: who is there, kick, ban, notices, drain, limits.
#include "server/session/host/host_impl.h"
#include "server/session/login/display_names.h"

#include <algorithm>
#include <limits>

namespace zoned::session {

namespace {

SessionFigures figures_of(const Session& session, double now_s) {
    SessionFigures out;
    out.client = session.client;
    out.account = session.identity.account;
    out.name = session.identity.name;
    out.team = session.identity.team;
    out.address = session.has_address ? session.address : session.peer;
    if (session.joined) {
        out.zone = session.joined->zone;
        out.avatar = session.joined->avatar;
    }
    out.connected = static_cast<bool>(session.stream);
    out.udp = session.route == Route::kAddress;
    out.rtt_ms = session.path.rtt_us() * 1e-3;
    out.bytes_in = session.bytes_in;
    out.bytes_out = session.bytes_out;
    out.silent_s = std::max(0.0, now_s - session.last_heard_s);
    out.waiting_events = session.events.waiting().size();
    return out;
}

}  // namespace

void SessionHost::set_peer(StreamId stream, const mailbox::Address& address) {
    const auto it = impl_->streams.find(stream);
    if (it != impl_->streams.end()) {
        it->second.peer = address;
    }
}

std::vector<SessionFigures> SessionHost::figures(ClientId after,
                                                 std::size_t most,
                                                 double now_s) const {
    std::vector<SessionFigures> out;
    const auto& all = impl_->table.all();
    auto it =
        std::upper_bound(all.begin(), all.end(), after, [](ClientId client, const auto& session) {
            return client < session->client;
        });
    for (; it != all.end() && out.size() < most; ++it) {
        out.push_back(figures_of(**it, now_s));
    }
    return out;
}

std::size_t SessionHost::kick(const SessionChoice& who, const std::string& reason) {
    std::vector<Session*> chosen;
    for (const auto& session : impl_->table.all()) {
        if ((who.client && session->client == who.client) ||
            (!who.account.empty() && session->identity.account == who.account) ||
            (!who.name.empty() && session->identity.name == who.name)) {
            chosen.push_back(session.get());
        }
    }
    for (Session* session : chosen) {
        impl_->end(*session, proto::CLOSING_KICKED, reason, mailbox::LeaveReason::kKicked);
    }
    return chosen.size();
}

std::size_t SessionHost::ban(AccountBan ban) {
    const std::string reason = ban.reason.empty() ? "banned" : "banned: " + ban.reason;
    SessionChoice who;
    who.account = ban.account;
    impl_->bans.ban(std::move(ban));
    return kick(who, reason);
}

bool SessionHost::unban(const std::string& account) {
    return impl_->bans.unban(account);
}

std::vector<AccountBan> SessionHost::bans() const {
    return impl_->bans.all();
}

std::size_t SessionHost::notify(ClientId client, const std::string& text) {
    const std::size_t recipients = !client ? impl_->table.all().size()
                                   : impl_->table.by_client(client) != nullptr ? 1
                                                                               : 0;
    if (recipients > 0) {
        impl_->output.to_zones(mailbox::Notice{client, text});
    }
    return recipients;
}

void SessionHost::set_draining(const std::string& text) {
    impl_->draining = text;
}

void SessionHost::set_limits(const HostLimits& limits) {
    static_cast<HostLimits&>(impl_->settings) = limits;
}

void SessionHost::measured(double load, double now_s) {
    Impl& host = *impl_;
    const std::uint64_t bytes = host.stats.bytes_out + host.stats.tunnelled_bytes;
    const double since_s = now_s - host.measured_s;
    if (host.measured_s >= 0.0 && since_s > 0.0) {
        host.overload.measured(load,
                               host.table.all().size(),
                               static_cast<double>(bytes - host.measured_bytes) / since_s,
                               host.settings.rate.floor,
                               host.settings.max_load,
                               now_s);
    }
    host.measured_bytes = bytes;
    host.measured_s = now_s;
    host.stats.load = host.overload.load();
    host.stats.refusing = host.overload.refusing();
    host.stats.ceiling_bytes_per_s = host.overload.ceiling();
}

}  // namespace zoned::session
